// Probes of the far field: where they stand, and which texel holds which direction.
//
// A tile of PROBE_TILE x PROBE_TILE pixels has up to two probes, each at a surface point that
// the tile shows. An image has a texel for each, second ones above the first.
// Radiance has PROBE_SIDE x PROBE_SIDE texels for each probe: the square, mapped onto the disk so that
// areas keep (Shirley, Chiu 1997), lifted to the hemisphere about the probe's normal: all texels
// stand for the same share of a cosine-weighted hemisphere.
#include "lib/octahedral.glsl"
#include "lib/sampling.glsl"

// xyz: position in view space, w: code of the shading normal there. 0: there is no probe;
// negative: the tile has a second one.
uniform sampler2D t_far_probe_points;

// Two numbers of 14 bits in what is a normal float, which is kept bit by bit.
const uint PROBE_CODE_BASE = 0x20000000u;
const float PROBE_CODE_HALF_RANGE = 8191.0;

float probe_code(vec3 normal)
{
    uvec2 steps = uvec2((oct_project(normal) + 1.0) * PROBE_CODE_HALF_RANGE + 0.5);
    return uintBitsToFloat(PROBE_CODE_BASE + (steps.x | steps.y << 14));
}

// The square of lib/octahedral.glsl.
vec2 probe_square(float code)
{
    uint bits = floatBitsToUint(abs(code)) - PROBE_CODE_BASE;
    return vec2(ivec2(bits & 16383u, bits >> 14)) * (1.0 / PROBE_CODE_HALF_RANGE) - 1.0;
}

// Columns and rows of tiles.
ivec2 probe_tiles()
{
    return textureSize(t_far_probe_points, 0) / ivec2(1, 2);
}

// Position and code of the probe that is number `second` of a tile, 0 or 1.
vec4 probe_point(ivec2 tile, int second)
{
    return texelFetch(t_far_probe_points, tile + ivec2(0, second * probe_tiles().y), 0);
}

// The first texel of a probe in the image of radiance.
ivec2 probe_texel(ivec2 probe)
{
    return probe * PROBE_SIDE;
}

const float QUARTER_PI = 0.25 * PI;

// [0, 1)^2 -> unit vector about +z.
vec3 probe_direction(vec2 place)
{
    vec2 s = 2.0 * place - 1.0;
    bool is_wide = abs(s.x) > abs(s.y);
    float r = is_wide ? s.x : s.y;
    float ratio = r != 0.0 ? (is_wide ? s.y : s.x) / r : 0.0;
    float angle = is_wide ? QUARTER_PI * ratio : 2.0 * QUARTER_PI - QUARTER_PI * ratio;
    return vec3(r * cos(angle), r * sin(angle), sqrt(max(1.0 - r * r, 0.0)));
}

// The inverse; what lies below the horizon is taken for what lies on it.
vec2 probe_place(vec3 w)
{
    vec2 d = w.z < 0.0 ? normalize(w.xy) : w.xy;
    bool is_wide = abs(d.x) > abs(d.y);
    float large = is_wide ? d.x : d.y;
    float r = large < 0.0 ? -length(d) : length(d);
    float x = large != 0.0 ? (is_wide ? d.y : d.x) / large : 0.0;
    // atan(x) / (pi / 4), to 2e-5: as good as any for texels, in .98 of the pass' time.
    float z = x * x;
    float ratio = x * (1.27306 + z * (-0.42055 + z * (0.229363 + z * (-0.108395 + z * 0.026528))));
    vec2 s = is_wide ? vec2(r, r * ratio) : vec2(r * ratio, r);
    return clamp(0.5 * s + 0.5, 0.0, 1.0 - FLOAT_EPSILON);
}
