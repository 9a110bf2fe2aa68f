#version 330 core
// Removes noise along surfaces, stage by stage. Defines: see lib/edge_aware_filter.glsl, and
// IS_OF_GLOSS 1: the z of the values is 0 where a surface is not glossy; LEAVES_NOISE 1: of
// KNOWS_NOISE, for the next stage; HAS_FACTOR 1: the first value is a share of an image.
#include "lib/edge_aware_filter.glsl"

#if HAS_FACTOR
uniform sampler2D t_factor;
#endif

layout(location = 0) out vec4 o_value_0;
#if SIGNAL_COUNT > 1
layout(location = 1) out vec4 o_value_1;
#endif
// As t_light, which the next stage reads.
#if KNOWS_NOISE == 1 && LEAVES_NOISE && SIGNAL_COUNT > 1
layout(location = 2) out vec2 o_light;
#elif KNOWS_NOISE == 1 && LEAVES_NOISE
layout(location = 1) out vec2 o_light;
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#if STAGE == STAGE_UPSAMPLE || STAGE == STAGE_COPY
    // The target has the frame's size.
    ivec2 texel = pixel;
#else
    ivec2 texel = pixel * STRIDE;
#endif
#if IS_OF_GLOSS
    float z = value_at(0, pixel).a;
#else
    float z = gbuffer_z_vs(texel);
#endif
    vec4 results[SIGNAL_COUNT];
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        results[i] = neutral(i);
    if (z > 0.0)
        filter_surface(pixel, texel, z, results);
#if STAGE == STAGE_SEPARABLE || STAGE == STAGE_BOX
    // The next stage reads z beside the value again, and whose rays these were.
    for (int i = 0; i < SIGNAL_COUNT; ++i) {
#if IS_VISIBILITY
        results[i].y = z;
#else
        results[i].a = holds_z(i) ? z : results[i].a;
#endif
    }
#endif
#if HAS_FACTOR
    results[0].rgb *= texelFetch(t_factor, pixel, 0).rgb;
#endif
    o_value_0 = results[0];
#if SIGNAL_COUNT > 1
    o_value_1 = results[1];
#endif
#if KNOWS_NOISE == 1 && LEAVES_NOISE
    float scale = 1.0 / max(light_sum.z, 1e-30);
    o_light = vec2(light_sum.x * scale, light_sum.y * scale * scale);
#endif
}
