// The points of surfels, from which their rays start: ssdo_gl/raytracing/surfels.py.
#include "rays/emitters.glsl"
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"

uniform usampler2D t_surfel_points;  // a row of tiles, one for each point
uniform int u_surfel_rows;           // height of a tile

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
