// Distant light, in world orientation.
//
// ENVIRONMENT_KIND: 0 none, 1 constant, 2 gradient over elevation (both evaluated from
// uniforms, without a fetch), 3 map (lat-long radiance, octahedral irradiance).
#include "lib/constants.glsl"
#include "lib/octahedral.glsl"

uniform mat3 u_world_from_view;
uniform vec3 u_environment_zenith;    // the constant's radiance, too
uniform vec3 u_environment_horizon;
uniform vec3 u_environment_ground;
uniform sampler2D t_environment;             // lat-long, row 0 is +y, -z in the middle column
uniform sampler2D t_environment_irradiance;  // octahedral, odd size, nodes on the rim

vec3 direction_ws_of(vec3 direction_vs)
{
    return u_world_from_view * direction_vs;
}

#if ENVIRONMENT_KIND == 3
// Texels of the map are constant patches: the nearest one, never a blend across poles.
vec3 environment_map_radiance(vec3 d)
{
    ivec2 size = textureSize(t_environment, 0);
    // atan(length, y) is acos(y) without the driver's acos, 60 times less exact.
    vec2 uv = vec2(atan(d.x, -d.z) * INV_TWO_PI + 0.5, atan(length(d.xz), d.y) * INV_PI);
    return texelFetch(t_environment, clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).rgb;
}

// Texels are the nodes of a grid over the square, its rim and its axes included, so that
// every crease of the octahedron runs along the triangles that halve the grid's cells:
// interpolation never reaches across one, nor past the rim.
vec3 environment_map_irradiance(vec3 n)
{
    int middle = textureSize(t_environment_irradiance, 0).x / 2;
    vec2 p = oct_project(n);
    ivec2 toward = ivec2(sign_not_zero(p));
    vec2 place = abs(p) * float(middle);
    ivec2 cell = min(ivec2(place), middle - 1);
    vec2 t = place - vec2(cell);
    // The fold |x| + |y| = 1 is parallel to the diagonal between the other two corners.
    bool is_near = t.x + t.y <= 1.0;
    vec2 weight = is_near ? t : 1.0 - t.yx;
    ivec2 corner = middle + toward * (is_near ? cell : cell + 1);
    ivec2 along_x = middle + toward * ivec2(cell.x + 1, cell.y);
    ivec2 along_y = middle + toward * ivec2(cell.x, cell.y + 1);
    return (1.0 - weight.x - weight.y) * texelFetch(t_environment_irradiance, corner, 0).rgb
         + weight.x * texelFetch(t_environment_irradiance, along_x, 0).rgb
         + weight.y * texelFetch(t_environment_irradiance, along_y, 0).rgb;
}
#endif

#if ENVIRONMENT_KIND == 2
// Integral over the sphere of max(0, w.y) max(0, w.n), with n.y = cos_angle: two clamped
// cosines whose axes enclose an angle a give 2/3 (sin a + (pi - a) cos a).
float clamped_cosine_overlap(float cos_angle)
{
    float sin_angle = sqrt(max(0.0, (1.0 - cos_angle) * (1.0 + cos_angle)));
    return 2.0 / 3.0 * (sin_angle + (PI - atan(sin_angle, cos_angle)) * cos_angle);
}
#endif

// Radiance arriving from `direction_ws` (unit length).
vec3 environment_radiance(vec3 direction_ws)
{
#if ENVIRONMENT_KIND == 1
    return u_environment_zenith;
#elif ENVIRONMENT_KIND == 2
    return u_environment_horizon
         + (u_environment_zenith - u_environment_horizon) * max(direction_ws.y, 0.0)
         + (u_environment_ground - u_environment_horizon) * max(-direction_ws.y, 0.0);
#elif ENVIRONMENT_KIND == 3
    return environment_map_radiance(direction_ws);
#else
    return vec3(0.0);
#endif
}

// Unoccluded irradiance on a surface of unit normal `normal_ws`.
vec3 environment_irradiance(vec3 normal_ws)
{
#if ENVIRONMENT_KIND == 1
    return PI * u_environment_zenith;
#elif ENVIRONMENT_KIND == 2
    return PI * u_environment_horizon
         + (u_environment_zenith - u_environment_horizon) * clamped_cosine_overlap(normal_ws.y)
         + (u_environment_ground - u_environment_horizon) * clamped_cosine_overlap(-normal_ws.y);
#elif ENVIRONMENT_KIND == 3
    return environment_map_irradiance(normal_ws);
#else
    return vec3(0.0);
#endif
}
