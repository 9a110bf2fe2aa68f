#version 330 core
// Removes the estimators' noise without mixing across edges, and brings images of half
// size to full size.
//
// Defines: STAGE 0 separable, 1 upsample, 2 box, 3 copy;
// IS_VISIBILITY 1: one value in [0, 1], and 1 where nothing is, 0: rgb irradiance + a;
// VALUE_HOLDS_Z: the channel after the value is z, else it is visibility;
// TAP_RADIUS: taps on each side; USE_NORMALS.
//
// The estimators give neighbouring pixels different sample sets that repeat every 4 x 4
// pixels, so the filter must weight all sets alike where nothing separates them. A box
// of 4 taps convolved with any other kernel does: the separable kernel is a box of 4
// convolved with a box of 2 TAP_RADIUS - 2, which is symmetric about the pixel.
#include "lib/finite.glsl"
#include "lib/gbuffer.glsl"

#define STAGE_SEPARABLE 0
#define STAGE_UPSAMPLE 1
#define STAGE_BOX 2
#define STAGE_COPY 3

uniform sampler2D t_value;
uniform int u_stride;          // texels of the frame per pixel of t_value
uniform ivec2 u_axis;          // separable: (1, 0), then (0, 1)
uniform float u_depth_tolerance;  // distance from the plane at which a tap counts 1/4, pixels
uniform float u_value_bound;   // larger values are faults, not light

layout(location = 0) out vec4 o_value;

#if IS_VISIBILITY
const vec4 NEUTRAL = vec4(1.0, 0.0, 0.0, 0.0);
#elif !VALUE_HOLDS_Z
const vec4 NEUTRAL = vec4(0.0, 0.0, 0.0, 1.0);
#else
const vec4 NEUTRAL = vec4(0.0);
#endif

// Distance of octahedral codes, 2 across the square, at which normals have nothing in
// common. cos^8 of the decoded angle gives the same errors to 1 %.
const float NORMAL_REACH = 0.8;

// A plane through the centre pixel's surface point, and what weights are relative to.
struct Centre {
    float z;
    vec3 geometric;
    vec2 shading_code;  // octahedral
    float plane;        // distance of the plane from the camera, signed: P . n
    float inv_spread;   // 1 / (tolerance in scene units)
};

Centre centre_at(ivec2 texel, float z)
{
    Centre c;
    c.z = z;
    vec4 normals = texelFetch(t_normals_vs, texel, 0);
    c.shading_code = normals.xy;
    c.geometric = oct_decode(normals.zw);
    c.plane = z * dot(view_ray_at(uv_of_texel(texel)), c.geometric);
    // What one pixel of t_value covers at this depth.
    float footprint = z * 2.0 * u_tan_half_fov.y / u_frame_size_px.y * float(u_stride);
    c.inv_spread = 1.0 / (u_depth_tolerance * footprint);
    return c;
}

// How much a tap shows the same surface: 1 on the centre's tangent plane at any tilt,
// falling with the distance from it in units of the pixel's footprint. So it knows
// neither scene units nor the angle of view.
float same_surface(Centre c, ivec2 texel, float z)
{
    float height = z * dot(view_ray_at(uv_of_texel(texel)), c.geometric) - c.plane;
    float x = height * c.inv_spread;
    float weight = 1.0 / (1.0 + x * x);
    // The tail of 1 / (1 + x^2) is long: cut it off smoothly.
    weight *= weight;
#if USE_NORMALS
    // Compared as they are stored: decoding them costs half as much as the whole filter.
    // Codes of normals that face the camera, all but a few at grazing angles, lie on one
    // sheet, and their distance is about the angle: a weight of 1 if alike, a half at 25
    // degrees, next to nothing from 50 on. Never 0: where all taps face elsewhere (a ledge
    // thinner than a pixel of a half-size image), they are still the best that is known.
    vec2 turn = 2.0 * (texelFetch(t_normals_vs, texel, 0).xy - c.shading_code);
    float agree = max(1.0 - dot(turn, turn) / (NORMAL_REACH * NORMAL_REACH), 0.0);
    weight *= max(agree * agree, 1e-3);
#endif
    return z > 0.0 ? weight : 0.0;
}

// A value that may enter a sum.
bool is_sound(vec4 value)
{
#if IS_VISIBILITY
    return is_finite(value.x) && value.x >= 0.0 && value.x <= 1.0;
#else
    bool is_light = is_finite(value) && all(greaterThanEqual(value.rgb, vec3(0.0)))
                 && all(lessThanEqual(value.rgb, vec3(u_value_bound)));
#if VALUE_HOLDS_Z
    return is_light;
#else
    return is_light && value.a >= 0.0 && value.a <= 1.0;
#endif
#endif
}

float z_of(ivec2 texel, vec4 value)
{
#if VALUE_HOLDS_Z && IS_VISIBILITY
    return value.y;
#elif VALUE_HOLDS_Z
    return value.a;
#else
    return gbuffer_z_vs(texel);
#endif
}

struct Sum {
    vec4 value;
    float weight;
};

void add_tap(inout Sum sum, Centre c, ivec2 pixel, ivec2 size, float weight)
{
    ivec2 inside = clamp(pixel, ivec2(0), size - 1);
    ivec2 texel = inside * u_stride;
    vec4 value = texelFetch(t_value, inside, 0);
    weight *= same_surface(c, texel, z_of(texel, value));
    bool use = inside == pixel && weight > 0.0 && is_sound(value);
    sum.value += use ? value * weight : vec4(0.0);
    sum.weight += use ? weight : 0.0;
}

vec4 resolved(Sum sum)
{
    return sum.weight > 0.0 ? sum.value / sum.weight : NEUTRAL;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 size = textureSize(t_value, 0);
#if STAGE == STAGE_UPSAMPLE || STAGE == STAGE_COPY
    // The target has the frame's size.
    ivec2 texel = pixel;
#else
    ivec2 texel = pixel * u_stride;
#endif
    float z = gbuffer_z_vs(texel);
    vec4 result = NEUTRAL;
    if (z > 0.0) {
#if STAGE == STAGE_COPY
        vec4 value = texelFetch(t_value, pixel / u_stride, 0);
        result = is_sound(value) ? value : NEUTRAL;
#else
        Centre c = centre_at(texel, z);
        Sum sum = Sum(vec4(0.0), 0.0);
#if STAGE == STAGE_SEPARABLE
        for (int i = -TAP_RADIUS; i <= TAP_RADIUS; ++i) {
            int trapezoid = min(min(4, 2 * TAP_RADIUS - 2), TAP_RADIUS + 1 - abs(i));
            add_tap(sum, c, pixel + i * u_axis, size, float(trapezoid));
        }
#elif STAGE == STAGE_BOX
        for (int y = -2; y < 2; ++y)
            for (int x = -2; x < 2; ++x)
                add_tap(sum, c, pixel + ivec2(x, y), size, 1.0);
#else
        // The four pixels of t_value around the texel, bilinear times same_surface.
        // Pixel p of t_value sits on texel p * u_stride.
        vec2 position = vec2(pixel) / float(u_stride);
        ivec2 base = ivec2(floor(position));
        vec2 f = position - vec2(base);
        // Never exactly 0, so that a tap across an edge can be replaced by any other.
        vec2 near = max(1.0 - f, vec2(1e-3));
        vec2 far = max(f, vec2(1e-3));
        add_tap(sum, c, base, size, near.x * near.y);
        add_tap(sum, c, base + ivec2(1, 0), size, far.x * near.y);
        add_tap(sum, c, base + ivec2(0, 1), size, near.x * far.y);
        add_tap(sum, c, base + ivec2(1, 1), size, far.x * far.y);
        // A thing so thin that all four lie on background: whatever is known of the
        // surroundings is better than nothing.
        bool is_lost = sum.weight == 0.0;
        for (int i = 0; is_lost && i < 16; ++i)
            add_tap(sum, c, base + ivec2(i & 3, i >> 2) - 1, size, 1.0);
#endif
        result = resolved(sum);
#endif
    }
#if VALUE_HOLDS_Z && (STAGE == STAGE_SEPARABLE || STAGE == STAGE_BOX)
    // The next stage reads z beside the value again.
#if IS_VISIBILITY
    result.y = z;
#else
    result.a = z;
#endif
#endif
    o_value = result;
}
