#version 330 core
// Scene-linear radiance to sRGB. TONE_CURVE: 0 clips at 1, 1 is filmic.
#include "lib/color.glsl"

uniform sampler2D t_beauty;
uniform float u_exposure_scale;  // 2^EV

layout(location = 0) out vec4 o_display;

void main()
{
    vec3 radiance = texelFetch(t_beauty, ivec2(gl_FragCoord.xy), 0).rgb;
    vec3 exposed = displayable(radiance * u_exposure_scale);
#if TONE_CURVE == 1
    vec3 shown = tone_curve_aces(exposed);
#else
    vec3 shown = min(exposed, vec3(1.0));
#endif
    o_display = vec4(srgb_encode(shown), 1.0);
}
