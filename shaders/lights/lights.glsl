// The scene's lights in view space, and the irradiance of each without any shadow.
//
// A light is LIGHT_ROWS vectors (written by graph/light_rows.py):
//        xyz                                            w
//   0    kind, shadow, parts with a shadow map each     1 if both sides emit
//        along an edge of a rectangle
//   1    position (point, spot), centre (rectangle),    cosine of a spot's outer angle
//        unit direction TOWARDS a directional light
//   2    intensity (point, spot), irradiance            1 / (cos inner - cos outer)
//        (directional), radiance (rectangle)            of a spot
//   3    half of edge_u (rectangle); unit direction     half width of a shadow map's face:
//        in which a spot shines                         a tangent, or a length if parallel
//   4    half of edge_v (rectangle)                     half height
//   5..7 rows of light_from_view: +z is where the       column and row of the first face in
//        light shines                                   the atlas, its size, all in tiles
//   8    origin of the shadow map                       faces of the shadow map
//
// HAS_SHADING_NORMALS (default 1): 0 promises that n and m below are the same.
#include "lib/constants.glsl"
#include "lib/angle.glsl"

#ifndef HAS_SHADING_NORMALS
#define HAS_SHADING_NORMALS 1
#endif

#define LIGHT_ROWS 9

#define LIGHT_POINT 0
#define LIGHT_SPOT 1
#define LIGHT_DIRECTIONAL 2
#define LIGHT_RECTANGLE 3

#define SHADOW_NONE 0
#define SHADOW_MAP 1
#define SHADOW_SSDO 2

struct Light {
    int kind;
    int shadow;
    bool two_sided;
    vec3 place_vs;      // row 1
    vec3 power;         // row 2
    vec3 axis_vs;       // row 3: half edge_u, or a spot's direction
    vec3 half_edge_v_vs;
    float cos_outer;
    float inverse_cos_range;
};

Light light_from_rows(vec4 rows[LIGHT_ROWS])
{
    return Light(int(rows[0].x), int(rows[0].y), rows[0].w > 0.5, rows[1].xyz, rows[2].rgb,
                 rows[3].xyz, rows[4].xyz, rows[1].w, rows[2].w);
}

// Lights reach no surface nearer than a few roundings of float32: there a position no
// longer says on which side of the light it lies. Relative to the distance from the eye.
const float LIGHT_ROUNDING = 4.0 * FLOAT_EPSILON;
// Bound on irradiance, so that a light within rounding of a surface stays finite and
// sums of many lights do, too. No picture comes near it.
const float IRRADIANCE_MAX = 1e30;

float largest_component(vec3 v)
{
    vec3 a = abs(v);
    return max(a.x, max(a.y, a.z));
}

vec3 bounded_irradiance(vec3 e)
{
    return vec3(e.r < IRRADIANCE_MAX ? e.r : IRRADIANCE_MAX,
                e.g < IRRADIANCE_MAX ? e.g : IRRADIANCE_MAX,
                e.b < IRRADIANCE_MAX ? e.b : IRRADIANCE_MAX);
}

// One edge of Lambert's formula: the angle that the edge a-b subtends, times the cosine
// between n and the normal of the plane through the edge and the receiver (the origin).
float edge_integral(vec3 a, vec3 b, vec3 n)
{
    // a x (b - a) = a x b, but without its cancellation for an edge that is short.
    vec3 normal = cross(a, b - a);
    float size = length(normal);
    // Zero if the edge points at the receiver: it subtends no angle then.
    return size > 0.0 ? angle_of(size, dot(a, b)) * dot(normal, n) / size : 0.0;
}

// Where the outline of a convex polygon crosses a plane: the gap that clipping leaves.
struct Cut {
    vec3 leaves;   // going below
    vec3 returns;  // coming up again
    bool is_cut;
};

const Cut UNCUT = Cut(vec3(0.0), vec3(0.0), false);

// Shortens edge a-b to what lies above the plane through the origin; false if nothing
// does. Edges of one outline must come in order and share their end points exactly.
bool clip_edge(inout vec3 a, inout vec3 b, vec3 plane_normal, inout Cut cut)
{
    float height_a = dot(a, plane_normal);
    float height_b = dot(b, plane_normal);
    bool is_above_a = height_a > 0.0;
    bool is_above_b = height_b > 0.0;
    if (is_above_a != is_above_b) {
        vec3 crossing = a + (b - a) * (height_a / (height_a - height_b));
        cut.is_cut = true;
        if (is_above_a) {
            cut.leaves = crossing;
            b = crossing;
        } else {
            cut.returns = crossing;
            a = crossing;
        }
    }
    return is_above_a || is_above_b;
}

// The edge that clipping leaves along the horizon itself, where the cosine is 1 or -1:
// taking only its sign from the cross product stays exact for edges near 180 degrees.
float horizon_integral(Cut cut, vec3 n)
{
    vec3 normal = cross(cut.leaves, cut.returns - cut.leaves);
    float angle = angle_of(length(normal), dot(cut.leaves, cut.returns));
    return dot(normal, n) < 0.0 ? -angle : angle;
}

float clipped_edge_integral(vec3 a, vec3 b, vec3 n, inout Cut cut)
{
    return clip_edge(a, b, n, cut) ? edge_integral(a, b, n) : 0.0;
}

float twice_clipped_edge_integral(vec3 a, vec3 b, vec3 m, vec3 n, inout Cut cut_m, inout Cut cut_n)
{
    return clip_edge(a, b, m, cut_m) ? clipped_edge_integral(a, b, n, cut_n) : 0.0;
}

// cos(receiver) cos(light) / distance^2 of a point of a light with edges' product `uv`.
float point_form(vec3 p, vec3 uv, vec3 n)
{
    float inverse_2 = 1.0 / dot(p, p);
    return -dot(uv, p) * dot(p, n) * inverse_2 * inverse_2;
}

// Below this (half edge / distance)^2 a light is integrated by 2 x 2 Gauss points, whose
// relative error is of the order of its square, 4e-6. The sum over edges is exact, but its
// terms cancel: rounding / (half edge / distance), 3e-6 here and more for smaller lights.
const float SMALL_LIGHT = 2e-3;
const float GAUSS_POINT = 0.57735026918962576451;  // 1 / sqrt(3)

// Integral of max(0, cos) over the solid angle of a parallelogram, as seen from the
// origin: Lambert 1760, F = 1/2 sum of angle_i cos_i, the outline clipped at the horizon
// of the shading normal `n` and at that of the geometric normal `m`.
// `c` is the centre, `u` and `v` half the edges; positive seen from the side u x v.
float parallelogram_cosine_integral(vec3 c, vec3 u, vec3 v, vec3 n, vec3 m)
{
    // Only directions count. Dividing by the largest length keeps squares in range.
    float scale = max(largest_component(c), max(largest_component(u), largest_component(v)));
    if (!(scale > 0.0)) {
        return 0.0;
    }
    c /= scale;
    u /= scale;
    v /= scale;

    float size_2 = max(dot(u, u), dot(v, v));
    // No corner is farther from the centre than both half edges together.
    bool is_above = min(dot(c, n), dot(c, m)) > 2.0 * sqrt(size_2);
    if (is_above && size_2 < SMALL_LIGHT * dot(c, c)) {
        vec3 uv = cross(u, v);
        vec3 gu = GAUSS_POINT * u;
        vec3 gv = GAUSS_POINT * v;
        return point_form(c - gu - gv, uv, n) + point_form(c + gu - gv, uv, n)
             + point_form(c + gu + gv, uv, n) + point_form(c - gu + gv, uv, n);
    }

    vec3 p0 = c - u - v;
    vec3 p1 = c + u - v;
    vec3 p2 = c + u + v;
    vec3 p3 = c - u + v;
    Cut cut_n = UNCUT;
    float sum;
#if HAS_SHADING_NORMALS
    Cut cut_m = UNCUT;
    sum = twice_clipped_edge_integral(p0, p1, m, n, cut_m, cut_n)
        + twice_clipped_edge_integral(p1, p2, m, n, cut_m, cut_n)
        + twice_clipped_edge_integral(p2, p3, m, n, cut_m, cut_n)
        + twice_clipped_edge_integral(p3, p0, m, n, cut_m, cut_n);
    if (cut_m.is_cut) {
        sum += clipped_edge_integral(cut_m.leaves, cut_m.returns, n, cut_n);
    }
#else
    sum = clipped_edge_integral(p0, p1, n, cut_n) + clipped_edge_integral(p1, p2, n, cut_n)
        + clipped_edge_integral(p2, p3, n, cut_n) + clipped_edge_integral(p3, p0, n, cut_n);
#endif
    sum += cut_n.is_cut ? horizon_integral(cut_n, n) : 0.0;
    return -0.5 * sum;
}

// Irradiance of a rectangle light at `p`; 0 on its dark side, in its plane and on it.
vec3 rectangle_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    vec3 c = light.place_vs - p_vs;
    vec3 normal = cross(light.axis_vs, light.half_edge_v_vs);
    float height = -dot(c, normal);
    float rounding = LIGHT_ROUNDING * length(normal)
                   * (largest_component(p_vs) + largest_component(light.place_vs));
    if (!(light.two_sided ? abs(height) > rounding : height > rounding)) {
        return vec3(0.0);
    }
    float f = parallelogram_cosine_integral(c, light.axis_vs, light.half_edge_v_vs, n_vs, m_vs);
    return light.power * max(height > 0.0 ? f : -f, 0.0);
}

// KHR_lights_punctual: squared linear ramp in the cosine between the two angles.
float spot_falloff(Light light, vec3 to_light_unit)
{
    float c = dot(-to_light_unit, light.axis_vs);
    float ramp = clamp((c - light.cos_outer) * light.inverse_cos_range, 0.0, 1.0);
    return ramp * ramp;
}

// Irradiance of a point or spot light: intensity * cos / distance^2.
vec3 point_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    vec3 to_light = light.place_vs - p_vs;
    float scale = largest_component(to_light);
    if (!(scale > 0.0)) {
        return vec3(0.0);
    }
    vec3 scaled = to_light / scale;
    float distance_scaled = length(scaled);
    vec3 w = scaled / distance_scaled;
    float cos_theta = dot(w, m_vs) > 0.0 ? max(dot(w, n_vs), 0.0) : 0.0;
    if (light.kind == LIGHT_SPOT) {
        cos_theta *= spot_falloff(light, w);
    }
    // One factor at a time: the square of a tiny distance would underflow to 0, and
    // 0 * infinity is NaN.
    float distance = scale * distance_scaled;
    return bounded_irradiance(light.power / distance * cos_theta / distance);
}

// Irradiance at `p` from one light without shadow, on a surface with shading normal `n`
// and geometric normal `m` (both on the camera's side, unit length). Light from below the
// geometric horizon does not count.
vec3 unshadowed_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    if (light.kind == LIGHT_RECTANGLE) {
        return rectangle_irradiance(light, p_vs, n_vs, m_vs);
    }
    if (light.kind == LIGHT_DIRECTIONAL) {
        float cos_theta = max(dot(light.place_vs, n_vs), 0.0);
        return dot(light.place_vs, m_vs) > 0.0 ? light.power * cos_theta : vec3(0.0);
    }
    return point_irradiance(light, p_vs, n_vs, m_vs);
}
