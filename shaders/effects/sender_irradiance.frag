#version 330 core
// What surfaces in view receive, from what the first frame of this view has looked up: a frame
// that differs in its jitter alone shows the same surfaces, some of them a pixel beside.
#include "lib/gbuffer.glsl"

uniform sampler2D t_cached_irradiance;  // a: depth

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float z = gbuffer_z_vs(texel);
    ivec2 last = ivec2(u_frame_size_px) - 1;
    vec4 found = texelFetch(t_cached_irradiance, texel, 0);
    const ivec2 BESIDE[4] = ivec2[4](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));
    for (int i = 0; i < 4; ++i) {
        vec4 other = texelFetch(t_cached_irradiance, clamp(texel + BESIDE[i], ivec2(0), last), 0);
        found = abs(other.a - z) < abs(found.a - z) ? other : found;
    }
    o_irradiance = z > 0.0 ? found : vec4(0.0);
}
