// The points of surfels, from which their rays start: ssdo_gl/raytracing/surfel_points.py.
#include "rays/emitters.glsl"
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"

uniform usampler2D t_surfel_points;  // a row of tiles, one for each point
uniform int u_surfel_rows;           // height of a tile
uniform float u_rays_per_sample;     // rays of a surfel over its shadow rays

const int SURFEL_POINTS = 16;

RaySurface surfel_point(ivec2 surfel, int point)
{
    uvec4 words = texelFetch(t_surfel_points, surfel + ivec2(0, u_surfel_rows * point), 0);
    RaySurface at;
    at.position = uintBitsToFloat(words.xyz);
    at.geometric = oct_unproject(vec2(words.w & 0xffffu, words.w >> 16) * (1.0 / 32767.0) - 1.0);
    at.normal = at.geometric;
    at.start = at.position;
    at.lift = vec3(0.0);
    at.is_smooth = false;
    at.w_out = at.geometric;
    return at;
}

// The direction of one of `count` rays, evenly spread over all points of the surfel.
vec3 surfel_direction(RaySurface at, int ray, uint seed)
{
    return frame_from_z(at.normal) * cosine_hemisphere(random_2d(uint(ray), seed, 0u, true));
}

// How much of a map's light along `w`, which is drawn with density `drawn`, rays by
// `surfel_direction` count: shadow rays count the rest (balance heuristic, Veach, Guibas 1995).
float share_of_own_rays(RaySurface at, vec3 w, float drawn)
{
    float own = u_rays_per_sample * INV_PI * max(dot(w, at.normal), 0.0);
    return drawn > 0.0 ? own / (own + drawn) : 1.0;
}

// Irradiance from `w`, and, for gloss, how much more grazing than even light it arrives, times the
// sum of its colours.
vec4 light_of_surfel(RaySurface at, vec3 w, vec3 irradiance)
{
#if GLOSSY
    float sum = irradiance.r + irradiance.g + irradiance.b;
    return vec4(irradiance, sum * (grazing_of(dot(w, at.normal)) - 1.0));
#else
    return vec4(irradiance, 0.0);
#endif
}
