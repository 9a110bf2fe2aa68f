#version 330 core
// Squares of one level: see lib/shadow_blocks.glsl.
//
// IS_FIRST: made of texels in quads (passes/quads.frag), else of four squares of the level before.
// IS_PARALLEL: of the texels of parallel light.
#include "lib/shadow_blocks.glsl"

#if IS_FIRST
uniform sampler2D t_quads;
#if IS_PARALLEL
uniform float u_far_depth;  // nothing in the scene is farther from the light
#endif
#else
uniform sampler2D t_blocks;
uniform int u_level;  // that is made
#endif

layout(location = 0) out vec4 o_block;

const float FARTHEST = 3.0e38;

#if IS_FIRST
vec4 nearness_at(ivec2 quad)
{
    vec4 depths = texelFetch(t_quads, quad, 0);
#if IS_PARALLEL
    return -min(depths, u_far_depth);
#else
    return 1.0 / depths;
#endif
}

vec2 bounds_with(vec2 bounds, vec4 w)
{
    return vec2(max(bounds.x, max(max(w.x, w.y), max(w.z, w.w))),
                min(bounds.y, min(min(w.x, w.y), min(w.z, w.w))));
}

// The slope is that between the corners, or none, where that bounds more closely.
void main()
{
    const int quads = BLOCK_TEXELS / 2;
    const float centre = 0.5 * float(BLOCK_TEXELS - 1);
    ivec2 first = ivec2(gl_FragCoord.xy) * quads;
    float a = nearness_at(first).x;
    float b = nearness_at(first + ivec2(quads - 1, 0)).y;
    float c = nearness_at(first + ivec2(0, quads - 1)).z;
    float d = nearness_at(first + quads - 1).w;
    vec2 slope = vec2(b - a + d - c, c - a + d - b) / (4.0 * centre);
    vec2 tilted = vec2(-FARTHEST, FARTHEST);
    vec2 level = tilted;
    for (int j = 0; j < quads; ++j) {
        for (int i = 0; i < quads; ++i) {
            vec4 w = nearness_at(first + ivec2(i, j));
            vec4 x = float(2 * i) - centre + vec4(0.0, 1.0, 0.0, 1.0);
            vec4 y = float(2 * j) - centre + vec4(0.0, 0.0, 1.0, 1.0);
            level = bounds_with(level, w);
            tilted = bounds_with(tilted, w - slope.x * x - slope.y * y);
        }
    }
    bool is_tilted = tilted.x - tilted.y < level.x - level.y;
    o_block = is_tilted ? vec4(slope, tilted) : vec4(0.0, 0.0, level);
}
#else
// Of the four squares, each `size` texels wide, by planes of a slope.
vec2 bounds(vec4 squares[4], vec2 slope, float size)
{
    vec2 found = vec2(-FARTHEST, FARTHEST);
    for (int i = 0; i < 4; ++i) {
        vec2 from_centre = size * (vec2(i & 1, i >> 1) - 0.5);
        vec2 change = abs(squares[i].xy - slope);
        float spread = 0.5 * size * (change.x + change.y);
        float shift = dot(slope, from_centre);
        found = vec2(max(found.x, squares[i].z - shift + spread),
                     min(found.y, squares[i].w - shift - spread));
    }
    return found;
}

// The slope is that of one of the four, or none, whichever bounds most closely.
void main()
{
    ivec2 first = block_corner(u_level - 1) + 2 * ivec2(gl_FragCoord.xy);
    vec4 squares[4];
    for (int i = 0; i < 4; ++i) {
        squares[i] = texelFetch(t_blocks, first + ivec2(i & 1, i >> 1), 0);
    }
    float size = float(BLOCK_TEXELS << (u_level - 1));
    o_block = vec4(0.0, 0.0, bounds(squares, vec2(0.0), size));
    for (int i = 0; i < 4; ++i) {
        vec2 found = bounds(squares, squares[i].xy, size);
        o_block = found.x - found.y < o_block.z - o_block.w ? vec4(squares[i].xy, found) : o_block;
    }
}
#endif
