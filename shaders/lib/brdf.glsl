// How surfaces reflect light: the only file that knows. Today all of them are diffuse.
//
// `normal` is the shading normal, `w_in` points to where light comes from and `w_out` to
// where it goes: unit vectors away from the surface, all in one space. Values come times
// the cosine at w_in, because all who ask go on to integrate over directions of it.
#include "lib/constants.glsl"
#include "lib/sampling.glsl"

uniform sampler2D t_albedo;  // of the G-buffer; a: 1 on surfaces, 0 elsewhere

struct Brdf {
    vec3 albedo;  // share of diffuse light that leaves again, [0, 1]
};

// A direction that light may have come from, drawn with `density` over solid angle.
struct BrdfSample {
    vec3 w_in;
    vec3 weight;    // brdf_times_cosine / density
    float density;
};

// The surface that the camera sees at `texel`.
Brdf brdf_at(ivec2 texel)
{
    return Brdf(texelFetch(t_albedo, texel, 0).rgb);
}

// Radiance towards w_out for each unit of radiance from the unit solid angle at w_in.
vec3 brdf_times_cosine(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    return brdf.albedo * (max(dot(w_in, normal), 0.0) * INV_PI);
}

// Density over solid angle with which brdf_sample draws w_in.
float brdf_density(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    return max(dot(w_in, normal), 0.0) * INV_PI;
}

// A direction from a point of the unit square.
BrdfSample brdf_sample(Brdf brdf, vec3 normal, vec3 w_out, vec2 u)
{
    vec3 w_in = frame_from_z(normal) * cosine_hemisphere(u);
    return BrdfSample(w_in, brdf.albedo, brdf_density(brdf, normal, w_out, w_in));
}

// About the largest share of light that leaves again, by colour: how far it is worth
// following. 0 only where nothing leaves.
vec3 brdf_reflectance(Brdf brdf)
{
    return brdf.albedo;
}

// Radiance that diffuse reflection makes of an irradiance, the same in all directions.
vec3 diffuse_radiance(Brdf brdf, vec3 irradiance)
{
    return brdf.albedo * INV_PI * irradiance;
}
