// The environment as lobes of glossy reflection see it. ENVIRONMENT_KIND: as in
// lib/environment.glsl.
#include "lib/environment.glsl"

#if ENVIRONMENT_KIND > 1
uniform sampler2D t_environment_lobes;  // level k: blurred by a lobe of alpha = 2^(k - 6)
#endif

// The level of t_environment_lobes at which alpha = 1.
const float WIDEST_LOBE = 6.0;

// Mean radiance over a lobe of width `alpha` about `direction_ws`.
vec3 lobe_radiance(vec3 direction_ws, float alpha)
{
#if ENVIRONMENT_KIND > 1
    vec3 d = direction_ws;
    vec2 uv = vec2(atan(d.x, -d.z) * INV_TWO_PI + 0.5, atan(length(d.xz), d.y) * INV_PI);
    float level = clamp(WIDEST_LOBE + log2(max(alpha, 1e-6)), 0.0, WIDEST_LOBE);
    return textureLod(t_environment_lobes, uv, level).rgb;
#else
    return environment_radiance(direction_ws);
#endif
}
