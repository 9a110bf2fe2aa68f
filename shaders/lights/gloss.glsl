// What a glossy surface reflects of one light towards the camera.
#include "lights/gloss_along.glsl"
#include "lights/lights.glsl"

#if GLOSSY
// `irradiance`: what arrives, shadows and all.
LightGloss gloss_of_light(Brdf brdf, Light light, vec3 p_vs, vec3 n_vs, vec3 irradiance)
{
    if (!is_glossy(brdf) || !(largest_component(irradiance) > 0.0)) {
        return LightGloss(irradiance, vec3(0.0));
    }
    vec3 w_out = toward_camera(p_vs);
#if LIGHT_FORM == FORM_PARALLEL
    // The microfacets that mirror a disk of light spread by half of its angle.
    float spread = 0.5 * light.numbers.x;
    float alpha = alpha_of(brdf.roughness);
    brdf.roughness = sqrt(sqrt(alpha * alpha + spread * spread));
    return gloss_along(brdf, n_vs, w_out, light.place_vs, irradiance);
#elif LIGHT_FORM == FORM_POINT
    return gloss_along(brdf, n_vs, w_out, normalize(light.place_vs - p_vs), irradiance);
#else
    return LightGloss(irradiance, vec3(0.0));
#endif
}
#endif
