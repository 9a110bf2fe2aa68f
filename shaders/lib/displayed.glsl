// What a display shows of the picture. TONE_CURVE: 0 clips at 1, 1 is filmic. BACKGROUND, what
// is shown where no surface is: 0 the environment, 1 a colour, 2 nothing.
#include "lib/color.glsl"

uniform float u_exposure_scale;  // 2^EV
#if BACKGROUND > 0
uniform vec3 u_background;  // scene-linear, as shown
#endif

// From scene-linear radiance to sRGB; alpha 0 where nothing is seen.
vec4 displayed(vec4 beauty)
{
    vec3 exposed = displayable(beauty.rgb * u_exposure_scale);
#if TONE_CURVE == 1
    vec3 shown = tone_curve_aces(exposed);
#else
    vec3 shown = min(exposed, vec3(1.0));
#endif
    float alpha = 1.0;
#if BACKGROUND > 0
    if (!(beauty.a > 0.0)) {
        shown = u_background;
        alpha = BACKGROUND == 2 ? 0.0 : 1.0;
    }
#endif
    return vec4(srgb_encode(shown), alpha);
}
