#version 330 core
// What all pixels of a tile see of a light: nothing, all of it, or not the same for certain.
//
// LIGHT_FORM, IS_SOFT, HAS_LIFT: as in effects/direct.frag. TILE_PIXELS: along its sides.
//
// All: the pixels lie in a plane, and what the map holds that could block does not rise over it.
// Nothing: the plane faces away. The map is read in squares of texels, at most READS along each side, so that this takes little.
#if __VERSION__ >= 400
#define HAS_GATHER 1
#elif defined(GL_ARB_texture_gather)
#extension GL_ARB_texture_gather : enable
#define HAS_GATHER 1
#else
#define HAS_GATHER 0
#endif
#include "lib/gbuffer.glsl"
#include "lights/shadow.glsl"
#include "lib/shadow_blocks.glsl"

uniform vec4 u_light[LIGHT_ROWS];
uniform sampler2D t_shadow_blocks;
#if HAS_LIFT
uniform sampler2D t_lift_vs;
#endif

layout(location = 0) out float o_kind;

const int READS = 4;
const float DARK = 0.0;
const float OPEN = 1.0;
const float MIXED = 2.0;

// Light may graze an open tile by no smaller cosine: its pixels are not lifted, see direct.frag, and
// no texel beside a pixel's own is another surface, see SHADOW_FAR_TEXELS.
const float LEAST_COSINE = 0.1;
// Which way a tile faces must be clear by this cosine.
const float CLEAR_COSINE = 0.02;
// Pixels may lie off the tile's plane by this part of a texel.
const float FLAT_TEXELS = 0.01;

// The pixels at `upper` and before it: anticlockwise from the upper left.
vec4 four_of(sampler2D image, ivec2 upper)
{
#if HAS_GATHER
    return textureGather(image, vec2(upper) / u_frame_size_px);
#else
    ivec2 high = min(upper, textureSize(image, 0) - 1);
    ivec2 low = upper - 1;
    return vec4(texelFetch(image, ivec2(low.x, high.y), 0).x, texelFetch(image, high, 0).x,
                texelFetch(image, ivec2(high.x, low.y), 0).x, texelFetch(image, low, 0).x);
#endif
}

struct Tile {
    vec3 p_vs;  // of a pixel in its middle
    vec3 m_vs;
    float height;      // of its plane over the eye, up to a constant
    float off_plane;   // the farthest pixel
    vec2 depths;       // least and largest of its surfaces; 0: it has none
    float lift;        // the largest
};

Tile tile_at(ivec2 first)
{
    ivec2 middle = min(first + TILE_PIXELS / 2, ivec2(u_frame_size_px) - 1);
    vec3 m_vs = gbuffer_geometric_normal_vs(middle);
    vec3 rate = plane_rate(uv_of_texel(middle), m_vs);
    float height = plane_height(rate, vec2(0.0), gbuffer_z_vs(middle));
    Tile tile = Tile(gbuffer_position_vs(middle), m_vs, height, 0.0, vec2(FLOAT_MAX, 0.0), 0.0);
    for (int j = 1; j < TILE_PIXELS; j += 2) {
        for (int i = 1; i < TILE_PIXELS; i += 2) {
            ivec2 upper = first + ivec2(i, j);
            vec4 z = four_of(t_z_vs, upper);
            for (int k = 0; k < 4; ++k) {
                ivec2 from_upper = ivec2(k == 0 || k == 3 ? 1 : 0, k < 2 ? 0 : 1);
                float off = plane_height(rate, vec2(upper - from_upper - middle), z[k]) - height;
                tile.off_plane = z[k] > 0.0 ? max(tile.off_plane, abs(off)) : tile.off_plane;
                tile.depths.x = z[k] > 0.0 ? min(tile.depths.x, z[k]) : tile.depths.x;
                tile.depths.y = max(tile.depths.y, z[k]);
            }
#if HAS_LIFT
            vec4 lift = four_of(t_lift_vs, upper);
            tile.lift = max(tile.lift, max(max(lift.x, lift.y), max(lift.z, lift.w)));
#endif
        }
    }
    return tile;
}

// Depth of the tile's plane where it is seen at `uv`.
float plane_z_vs(Tile tile, vec2 uv)
{
    float at_0 = dot(position_vs_at(uv, 0.0), tile.m_vs);
    float at_1 = dot(position_vs_at(uv, 1.0), tile.m_vs);
    return (dot(tile.p_vs, tile.m_vs) - at_0) / (at_1 - at_0);
}

// How high over the receivers' plane what the squares between two texels of the atlas hold may rise.
// `plane`: of nearness w at (x, y) texels from the middle of both, plane.xy * (x, y) + plane.z * w
// + plane.w is the height over the plane. What is no nearer than `nearness` has none.
float squares_between(vec2 low, vec2 high, vec4 plane, float nearness)
{
    vec2 span = high - low;
    float size = max(max(span.x, span.y) / float((READS - 1) * BLOCK_TEXELS), 1.0);
    int level = min(int(ceil(log2(size))), BLOCK_LEVELS - 1);
    float width = float(BLOCK_TEXELS << level);
    vec2 first = floor(low / width);
    ivec2 last = (u_block_grid >> level) - 1;
    bool is_all = all(lessThan(high, (first + float(READS)) * width));
    float highest = is_all ? -FLOAT_MAX : FLOAT_MAX;
    for (int j = 0; j < READS; ++j) {
        for (int i = 0; i < READS; ++i) {
            vec2 number = first + vec2(float(i), float(j));
            ivec2 place = block_corner(level) + min(ivec2(number), last);
            vec4 block = texelFetch(t_shadow_blocks, place, 0);
            vec2 from = max(low, number * width);
            vec2 to = min(high, (number + 1.0) * width - 1.0);
            vec2 centre = 0.5 * (from + to);
            vec2 half_size = 0.5 * (to - from);
            float w = dot(block.xy, centre - number * width - 0.5 * (width - 1.0));
            float change = dot(abs(block.xy), half_size);
            float rise = dot(abs(plane.xy + plane.z * block.xy), half_size);
            float bound = plane.z > 0.0 ? block.z : block.w;
            float height = dot(plane.xy, centre - 0.5 * (low + high)) + plane.w
                         + plane.z * (w + bound) + rise;
            bool is_in = min(half_size.x, half_size.y) >= 0.0;
            bool is_near = is_in && w + block.z + change > nearness;
            highest = is_near ? max(highest, height) : highest;
        }
    }
    return highest;
}

// A tile before the map of a light, or of one part of a rectangle, in the axes of a face.
struct Receivers {
    vec3 corners[8];  // all of it lies between
    vec3 p;
    vec3 m;
    vec3 extent;      // of the light from its centre
    vec3 axis;        // of a rectangle: where it shines
};

// Of `face`, and where the receivers see it.
struct Seen {
    vec2 low;      // texels
    vec2 high;
    vec2 lowest;   // texels that may block
    vec2 highest;
    vec2 depths;
};

Seen seen_by(Face face, Receivers tile)
{
    vec2 last = vec2(face.texels - 1.0);
    Seen seen = Seen(vec2(FLOAT_MAX), vec2(-FLOAT_MAX), vec2(0.0), last, vec2(FLOAT_MAX, -FLOAT_MAX));
    for (int i = 0; i < 8; ++i) {
        vec2 place = face_place(face, tile.corners[i]);
        seen.low = min(seen.low, place);
        seen.high = max(seen.high, place);
        seen.depths = vec2(min(seen.depths.x, tile.corners[i].z),
                           max(seen.depths.y, tile.corners[i].z));
    }
    // Pixels read the texels around their own; those of a rectangle the one they fall on.
    seen.low = floor(seen.low - 2.5);
    seen.high = floor(seen.high + 2.5);
#if LIGHT_FORM == FORM_AREA
    // Nothing beyond the light's own plane is looked up.
    float horizon = 0.5 * face.texels;
    seen.lowest = mix(seen.lowest, vec2(horizon), greaterThan(tile.axis.xy, vec2(0.5)));
    seen.highest = mix(seen.highest, vec2(horizon - 1.0), lessThan(tile.axis.xy, vec2(-0.5)));
#endif
    return seen;
}

float highest_before(Face face, Receivers tile, Seen seen, vec2 reach, float nearness)
{
    vec2 from = clamp(seen.low - reach, seen.lowest, seen.highest);
    vec2 to = clamp(seen.high + reach, seen.lowest, seen.highest);
    vec2 slope = 0.5 * (from + to + 1.0 - face.texels) * face.slope_from_texel;
    float over = -dot(tile.p, tile.m);
    vec4 plane = vec4(tile.m.xy * face.slope_from_texel, IS_PARALLEL ? -tile.m.z : over,
                      dot(tile.m.xy, slope) + (IS_PARALLEL ? over : tile.m.z));
    return squares_between(face.corner + from, face.corner + to, plane, nearness);
}

// In texels and nearness, what blocks lies in a pyramid over the receiver, as wide as the light is
// large: this many texels for each unit of nearness. Texels have a size, too.
vec2 widening(Face face, Receivers tile, Seen seen)
{
    vec2 across = tile.extent.xy;
#if LIGHT_FORM == FORM_AREA
    vec2 slope = max(abs(seen.low - 0.5 * face.texels), abs(seen.high - 0.5 * face.texels))
               * face.slope_from_texel;
    across = (across + slope * tile.extent.z) * seen.depths.y / (seen.depths.y - tile.extent.z);
#endif
    return 1.05 * across * face.texel_from_slope + (IS_PARALLEL ? 0.0 : seen.depths.y);
}

// Whether nothing stands before the tile.
bool is_told(Face face, Receivers tile)
{
    Seen seen = seen_by(face, tile);
    float texel = max(face.slope_from_texel.x, face.slope_from_texel.y);
    // Half of what a pixel allows, for rounding.
    float slack = 0.5 * SHADOW_TEXEL_SLACK * texel;
#if IS_SOFT
    bool is_open = seen.depths.x > 2.0 * tile.extent.z;
    vec2 wider = widening(face, tile, seen);
    float farthest = IS_PARALLEL ? -seen.depths.y : 1.0 / seen.depths.y;
    float nearness = -FLOAT_MAX;
    // Ring by ring: what lies outside of one has to be nearer to the light to block.
    float ring = 0.0;
    bool goes_on = is_open;
    do {
        vec2 reach = ring * wider;
        is_open = is_open && highest_before(face, tile, seen, reach, nearness) <= slack;
        nearness = farthest + ring;
        bool is_whole = all(bvec4(lessThanEqual(seen.low - reach, seen.lowest),
                                  greaterThanEqual(seen.high + reach, seen.highest)));
        // The map of parallel light begins before all that there is.
        goes_on = is_open && !is_whole && !(IS_PARALLEL && nearness >= 0.0);
        ring = ring > 0.0 ? 2.0 * ring : 4.0 / max(wider.x, wider.y);
    } while (goes_on);
    return is_open;
#else
    return seen.depths.x > 0.0 && highest_before(face, tile, seen, vec2(0.0), -FLOAT_MAX) <= slack;
#endif
}

// The same for all parts of a light.
bool is_told_by_all(ShadowMap map, Light light, int number, Receivers tile)
{
    Face face = face_at(map, number);
#if LIGHT_FORM == FORM_AREA
    float columns = float(map.parts_per_side);
    mat3 rotation = map.light_from_view;
    vec3 half_u = face_from_light(number, vec3((rotation * light.axis_vs).xy, 0.0)) / columns;
    vec3 half_v = face_from_light(number, vec3((rotation * light.second_axis_vs).xy, 0.0)) / columns;
    tile.extent = abs(half_u) + abs(half_v);
    vec2 first_corner = face.corner;
    Receivers before_part = tile;
    bool is_open = tile.p.z > 2.0 * columns * tile.extent.z;
    int parts = map.parts_per_side * map.parts_per_side;
    int i = 0;
    do {
        vec2 part = vec2(float(i % map.parts_per_side), float(i / map.parts_per_side));
        vec2 place = part * 2.0 + 1.0 - columns;
        vec3 shift = place.x * half_u + place.y * half_v;
        face.corner = first_corner + part * map.texels;
        before_part.p = tile.p - shift;
        for (int k = 0; k < 8; ++k) {
            before_part.corners[k] = tile.corners[k] - shift;
        }
        is_open = is_open && is_told(face, before_part);
    } while (++i < parts && is_open);
    return is_open;
#else
    return is_told(face, tile);
#endif
}

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE_PIXELS;
    Tile tile = tile_at(first);
    ShadowMap map = shadow_map_from_rows(u_light);
    Light light = light_from_rows(vec4[](u_light[0], u_light[1], u_light[2], u_light[3], u_light[4]));
    vec3 p_ls = map.light_from_view * (tile.p_vs - map.origin_vs);
    vec3 m_ls = map.light_from_view * tile.m_vs;
    Face face = face_at(map, 0);
    float texel = max(face.slope_from_texel.x, face.slope_from_texel.y)
                * (IS_PARALLEL ? 1.0 : largest_component(p_ls));
    bool is_flat = tile.p_vs.z < 0.0 && tile.off_plane <= FLAT_TEXELS * texel;

    // Between these lies all of it, in the axes of the light.
    vec3 corners[8];
    int number = 0;
    int other = 0;  // face, if it lies on two
    bool is_on_two = true;
    float longest = 0.0;
    float highest = -FLOAT_MAX;
    for (int i = 0; i < 8; ++i) {
        vec2 uv = (vec2(first) + float(TILE_PIXELS) * vec2(i & 1, (i >> 1) & 1)) / u_frame_size_px;
        float z_vs = is_flat ? plane_z_vs(tile, uv) : (i < 4 ? tile.depths.x : tile.depths.y);
        corners[i] = map.light_from_view * (position_vs_at(uv, z_vs) - map.origin_vs);
        longest = max(longest, length(corners[i]));
        highest = max(highest, corners[i].z);
        int own = IS_PARALLEL || map.face_count == 1 ? 0 : face_of(corners[i]);
        number = i == 0 ? own : number;
        bool is_known = i == 0 || own == number || other == number || own == other;
        is_on_two = is_on_two && is_known && z_vs > 0.0;
        other = i == 0 || other == number ? own : other;
    }

    // How clearly the plane faces the light, and faces away.
    float over = IS_PARALLEL ? -m_ls.z : -dot(p_ls, m_ls);
    float across = half_extent_along(light, tile.m_vs) + (IS_PARALLEL ? light.numbers.x : 0.0);
    float unit = IS_PARALLEL ? 1.0 : longest;
    bool is_facing = over > across + (LIGHT_FORM == FORM_AREA ? CLEAR_COSINE : LEAST_COSINE) * unit;
    bool is_away = is_flat && tile.lift == 0.0 && over < -across - CLEAR_COSINE * unit;
    bool is_behind = LIGHT_FORM == FORM_AREA && !light.two_sided && highest < -1e-3 * longest;

    bool told = is_flat && is_facing && is_on_two;
    int round = 0;
    do {
        Receivers receivers;
        for (int i = 0; i < 8; ++i) {
            receivers.corners[i] = face_from_light(number, corners[i]);
        }
        receivers.p = face_from_light(number, p_ls);
        receivers.m = face_from_light(number, m_ls);
        receivers.extent = vec3(light.numbers.x, light.numbers.x, 0.0);
        receivers.axis = face_from_light(number, vec3(0.0, 0.0, p_ls.z < 0.0 ? -1.0 : 1.0));
        bool by_face = is_told_by_all(map, light, number, receivers);
        // Off the faces of a map light is not blocked.
        told = told && (by_face || number >= map.face_count);
        round += other == number ? 2 : 1;
        number = other;
    } while (round < 2);
    bool is_dark = tile.depths.y == 0.0 || is_away || is_behind;
    o_kind = is_dark ? DARK : (told ? OPEN : MIXED);
}
