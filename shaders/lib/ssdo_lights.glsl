// Lights that arrive through SSDO's open directions, as uniforms: they are few, and a
// loop over directions reads them far more often than a texture should be read.
//
// SSDO_RECTANGLE_COUNT, SSDO_POINT_COUNT: how many there are of the two sorts.
#include "lib/lights.glsl"

#if SSDO_RECTANGLE_COUNT > 0
uniform vec3 u_rectangle_centre_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_half_u_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_half_v_vs[SSDO_RECTANGLE_COUNT];
uniform vec3 u_rectangle_radiance[SSDO_RECTANGLE_COUNT];
uniform int u_rectangle_two_sided[SSDO_RECTANGLE_COUNT];

// A rectangle as a receiver sees it: what does not depend on the direction.
struct RectangleTarget {
    vec3 normal_vs;   // not unit length; the front is on its side
    vec3 dual_u_vs;   // dot with an in-plane offset from the centre: -1..1 inside
    vec3 dual_v_vs;
    float height;     // of the receiver above the plane, times |normal|
    vec3 from_centre_vs;
    bool emits_here;  // towards the receiver's side
};

RectangleTarget rectangle_target(int i, vec3 p_vs)
{
    vec3 u = u_rectangle_half_u_vs[i];
    vec3 v = u_rectangle_half_v_vs[i];
    RectangleTarget r;
    r.normal_vs = cross(u, v);
    // Dual basis of (u, v) in their plane: dual_u . u = 1, dual_u . v = 0.
    float area_2 = max(dot(r.normal_vs, r.normal_vs), 1e-37);
    r.dual_u_vs = cross(v, r.normal_vs) / area_2;
    r.dual_v_vs = cross(r.normal_vs, u) / area_2;
    r.from_centre_vs = p_vs - u_rectangle_centre_vs[i];
    r.height = dot(r.from_centre_vs, r.normal_vs);
    r.emits_here = r.height > 0.0 || (u_rectangle_two_sided[i] != 0 && r.height < 0.0);
    return r;
}

// Distance along w at which the ray from the receiver meets the rectangle's emitting
// side; FLOAT_MAX if it does not.
float distance_to_rectangle(RectangleTarget r, vec3 w)
{
    float rate = dot(w, r.normal_vs);
    // Towards the plane: the height and its rate of change have opposite signs.
    bool approaches = r.height * rate < 0.0;
    float t = -r.height / (approaches ? rate : 1.0);
    vec3 offset = r.from_centre_vs + t * w;
    bool inside = abs(dot(offset, r.dual_u_vs)) <= 1.0 && abs(dot(offset, r.dual_v_vs)) <= 1.0;
    return r.emits_here && approaches && inside ? t : FLOAT_MAX;
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
