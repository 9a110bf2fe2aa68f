// What the camera sees of an irradiance, by diffuse reflection.
#include "lib/brdf.glsl"
#include "lib/gbuffer.glsl"

vec3 reflected_towards_camera(ivec2 texel, vec3 irradiance)
{
#if GLOSSY
    vec3 w_out = toward_camera(gbuffer_position_vs(texel));
    vec3 normal = gbuffer_shading_normal_vs(texel);
    return diffuse_radiance_towards(brdf_at(texel), normal, w_out, irradiance);
#else
    return diffuse_radiance(brdf_at(texel), irradiance);
#endif
}
