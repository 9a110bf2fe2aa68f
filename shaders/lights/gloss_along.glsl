// What a glossy surface reflects of light from one direction.
#include "lib/brdf.glsl"

#if GLOSSY
struct LightGloss {
    vec3 irradiance;  // what diffuse reflection gets, on the scale of diffuse_radiance_towards
    vec3 radiance;
};

// A light without an area, all of whose `irradiance` arrives along w; d is the distribution of
// the microfacets that mirror it.
LightGloss gloss_along(Brdf brdf, vec3 n, vec3 w_out, vec3 w, vec3 irradiance, float d)
{
    float cos_in = dot(n, w);
    vec3 h = half_vector(n, w_out, w);
    vec3 passes = vec3(1.0) - fresnel(brdf, dot(w, h));
    vec3 mean = vec3(1.0) - mean_fresnel(brdf, clamp(dot(n, w_out), 0.0, 1.0));
    // Of metals, which reflect nothing diffusely, all of it: it is sent on as it is.
    vec3 share = mix(vec3(1.0), passes / max(mean, vec3(1e-3)), greaterThan(brdf.albedo, vec3(0.0)));
    vec3 radiance = cos_in > 0.0 ? irradiance * once_per_cosine(brdf, n, w_out, w, d) : vec3(0.0);
    return LightGloss(irradiance * share, radiance * rescattered(brdf, cosine_out(n, w_out)));
}
#endif
