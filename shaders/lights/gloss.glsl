// What a glossy surface reflects of one light towards the camera.
#include "lights/gloss_along.glsl"
#include "lib/layer_reflectance.glsl"
#include "lights/lights.glsl"

#if GLOSSY
#if LIGHT_FORM == FORM_AREA
uniform sampler2D t_lobe_transforms;

// Mean radiance over the surface's lobe of a light of radiance 1, unshadowed: the lobe as
// a linearly transformed cosine (Heitz et al. 2016), a parallelogram stays one.
float area_in_lobe(Light light, vec3 p_vs, vec3 n_vs, vec3 w_out, float cos_out, float roughness)
{
    vec4 t = textureLod(t_lobe_transforms, node_of_table(cos_out, roughness), 0.0);
    vec3 across = w_out - n_vs * dot(w_out, n_vs);
    float size = length(across);
    vec3 x = size > 1e-5 ? across / size : frame_from_z(n_vs)[0];
    mat3 local = transpose(mat3(x, cross(n_vs, x), n_vs));
    mat3 cosine_from_local = mat3(vec3(t.x, 0.0, t.z), vec3(0.0, 1.0, 0.0), vec3(t.y, 0.0, t.w));
    mat3 m = cosine_from_local * local;
    vec3 c = light.place_vs - p_vs;
    vec3 normal = cross(light.axis_vs, light.second_axis_vs);
    const vec3 UP = vec3(0.0, 0.0, 1.0);
    float f = parallelogram_cosine_integral(
        m * c, m * light.axis_vs, m * light.second_axis_vs, UP, UP);
    return max(dot(c, normal) < 0.0 ? f : -f, 0.0) * INV_PI;
}
#endif

// `irradiance`: what arrives, `visibility` of it past shadows.
LightGloss gloss_of_light(Brdf brdf, Light light, vec3 p_vs, vec3 n_vs, vec3 irradiance,
                          float visibility)
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
    float cos_out = cosine_out(n_vs, w_out);
    float share = area_in_lobe(light, p_vs, n_vs, w_out, cos_out, brdf.roughness);
    vec3 radiance = light.power * layer_reflectance(brdf, cos_out) * (share * visibility);
    return LightGloss(irradiance, radiance);
#endif
}
#endif
