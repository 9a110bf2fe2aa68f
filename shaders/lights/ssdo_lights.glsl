// Lights that arrive through SSDO's open directions, as uniforms: they are few, and a
// loop over directions reads them far more often than a texture should be read.
//
// SSDO_RECTANGLE_COUNT, SSDO_POINT_COUNT: how many there are of the two sorts.
#include "lights/lights.glsl"

#if SSDO_RECTANGLE_COUNT > 0
uniform vec3 u_rectangle_centre_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_half_u_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_half_v_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_radiance[SSDO_RECTANGLE_COUNT];
uniform int u_rectangle_two_sided[SSDO_RECTANGLE_COUNT];

// Distance along w at which the ray from p_vs meets the rectangle's emitting side;
// FLOAT_MAX if it does not.
float distance_to_rectangle(int i, vec3 p_vs, vec3 w)
{
    vec3 u = u_rectangle_half_u_vs[i];
    vec3 v = u_rectangle_half_v_vs[i];
    vec3 normal = cross(u, v);  // not unit length; the front is on its side
    vec3 from_centre = p_vs - u_rectangle_centre_vs[i];
    float height = dot(from_centre, normal);
    float rate = dot(w, normal);
    // Towards the plane: the height and its rate of change have opposite signs.
    bool approaches = height * rate < 0.0;
    float t = -height / (approaches ? rate : 1.0);
    // Coordinates in the plane by the dual basis of (u, v): -1..1 inside.
    vec3 offset = (from_centre + t * w) / max(dot(normal, normal), 1e-37);
    float a = dot(offset, cross(v, normal));
    float b = dot(offset, cross(normal, u));
    bool emits_here = height > 0.0 || u_rectangle_two_sided[i] != 0;
    return emits_here && approaches && max(abs(a), abs(b)) <= 1.0 ? t : FLOAT_MAX;
}

// The point of the rectangle at `u` in the unit square.
vec3 rectangle_point(int i, vec2 u)
{
    vec2 q = 2.0 * u - 1.0;
    return u_rectangle_centre_vs[i] + q.x * u_rectangle_half_u_vs[i]
                                    + q.y * u_rectangle_half_v_vs[i];
}

// Unit normal of the rectangle on the side of p_vs.
vec3 rectangle_normal(int i, vec3 p_vs)
{
    vec3 n = normalize(cross(u_rectangle_half_u_vs[i], u_rectangle_half_v_vs[i]));
    return dot(p_vs - u_rectangle_centre_vs[i], n) < 0.0 ? -n : n;
}

vec3 rectangle_irradiance_at(int i, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    Light light = Light(LIGHT_RECTANGLE, SHADOW_SSDO, u_rectangle_two_sided[i] != 0,
                        u_rectangle_centre_vs[i], u_rectangle_radiance[i],
                        u_rectangle_half_u_vs[i], u_rectangle_half_v_vs[i], 0.0, 0.0);
    return rectangle_irradiance(light, p_vs, n_vs, m_vs);
}
#endif

#if SSDO_POINT_COUNT > 0
uniform int u_point_kind[SSDO_POINT_COUNT];
uniform vec3 u_point_place_vs[SSDO_POINT_COUNT];  // position, or unit direction to the light
uniform vec3 u_point_axis_vs[SSDO_POINT_COUNT];   // of a spot
uniform vec3 u_point_power[SSDO_POINT_COUNT];     // intensity, or irradiance
uniform vec2 u_point_cone[SSDO_POINT_COUNT];      // cos outer, 1 / (cos inner - cos outer)

Light point_light(int i)
{
    return Light(u_point_kind[i], SHADOW_SSDO, false, u_point_place_vs[i], u_point_power[i],
                 u_point_axis_vs[i], vec3(0.0), u_point_cone[i].x, u_point_cone[i].y);
}
#endif
