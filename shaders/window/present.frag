#version 330 core
// One image of the renderer as colours on a screen. What is bound is a sum of frames or
// a single one; KIND says what its numbers mean (`ssdo_gl/images/display.py` has the names),
// SMOOTH_EDGES whether edges are smoothed, which is for colours.
#include "lib/color.glsl"
#include "lib/octahedral.glsl"
#include "lib/space.glsl"
#include "window/smoothed.glsl"

uniform sampler2D t_image;
uniform sampler2D t_z_vs;         // of the same frame, for what is no colour
uniform float u_weight;           // 1 / frames summed
uniform float u_smoothing;        // how much of an edge's steps to take away, [0, 1]
uniform int u_first_channel;
uniform float u_exposure_scale;   // 2^EV
uniform mat3 u_world_from_view;
uniform vec3 u_scene_low_rel_ws;  // bounds of the scene relative to the eye
uniform vec3 u_scene_high_rel_ws;
uniform vec2 u_near_far;          // distances between which depth is spread

in vec2 v_uv;

layout(location = 0) out vec4 o_color;

const float FAINTEST = 0.1;  // tells the farthest surface from the background

void main()
{
#if SMOOTH_EDGES == 1
    vec4 image = smoothed(t_image, v_uv, u_weight, u_smoothing);
#else
    vec4 image = u_weight * texture(t_image, v_uv);
#endif
#if KIND == 0
    vec3 shown = srgb_encode(clamp(image.rgb, 0.0, 1.0));
#elif KIND == 1
    vec3 exposed = displayable(image.rgb * u_exposure_scale);
#if TONE_CURVE == 1
    vec3 shown = srgb_encode(tone_curve_aces(exposed));
#else
    vec3 shown = srgb_encode(min(exposed, vec3(1.0)));
#endif
#elif KIND == 2
    vec3 shown = vec3(srgb_encode(clamp(image[u_first_channel], 0.0, 1.0)));
#elif KIND == 3
    vec3 shown = srgb_encode(clamp(image.rgb, 0.0, 1.0));
#else
    // Geometry is taken from one texel: between two there is no surface.
    ivec2 texel = min(ivec2(v_uv * vec2(textureSize(t_z_vs, 0))), textureSize(t_z_vs, 0) - 1);
    float z_vs = texelFetch(t_z_vs, texel, 0).r;
#if KIND == 4
    vec3 normal_vs = oct_decode(texelFetch(t_image, texel, 0).xy);
    vec3 shown = 0.5 + 0.5 * (u_world_from_view * normal_vs);
#elif KIND == 5
    vec3 position_vs = position_vs_at(v_uv, z_vs);
    vec3 offset_ws = u_world_from_view * position_vs - u_scene_low_rel_ws;
    vec3 size_ws = max(u_scene_high_rel_ws - u_scene_low_rel_ws, vec3(1e-30));
    vec3 shown = FAINTEST + (1.0 - FAINTEST) * clamp(offset_ws / size_ws, 0.0, 1.0);
#else
    float far = clamp((z_vs - u_near_far.x) / (u_near_far.y - u_near_far.x), 0.0, 1.0);
    vec3 shown = vec3(FAINTEST + (1.0 - FAINTEST) * (1.0 - far));
#endif
    shown = z_vs > 0.0 ? shown : vec3(0.0);
#endif
#if KIND <= 3
    shown += dither_pattern(gl_FragCoord.xy) / 255.0;
#endif
    o_color = vec4(shown, 1.0);
}
