// What a glossy surface reflects of one light towards the camera.
#include "lights/gloss_filter.glsl"
#include "lights/lights.glsl"
#include "lights/gloss_of_rectangle.glsl"

#if GLOSSY
#if LIGHT_FORM == FORM_AREA
vec3 gloss_of_area(Brdf brdf, Light light, vec3 p_vs, vec3 n_vs, vec3 w_out)
{
    return gloss_of_rectangle(brdf, light.place_vs - p_vs, light.axis_vs, light.second_axis_vs, n_vs,
                              w_out);
}
#endif

// `irradiance`: what arrives, which is x of `visibility`; y of what the lobe sees of the light does.
LightGloss gloss_of_light(Brdf brdf, Light light, vec3 p_vs, vec3 n_vs, vec3 irradiance,
                          vec2 visibility)
{
    if (!is_glossy(brdf) || !(largest_component(irradiance) > 0.0)) {
        return LightGloss(irradiance, vec3(0.0));
    }
    vec3 w_out = toward_camera(p_vs);
#if LIGHT_FORM != FORM_AREA
    vec3 w = toward_light(light, p_vs);
    float d = distribution_of_light(light, p_vs, n_vs, alpha_of(brdf.roughness));
    LightGloss reflected = gloss_along(brdf, n_vs, w_out, w, irradiance, d);
    reflected.radiance *= visibility.y / visibility.x;
    return reflected;
#else
    vec3 radiance = light.power * visibility.y * gloss_of_area(brdf, light, p_vs, n_vs, w_out);
    return LightGloss(irradiance, radiance);
#endif
}
#endif
