// A parallelogram. Its axes: half of each edge; it emits on the side of their cross product.
//
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

// Whether all of a parallelogram is above both horizons, and (half edge / distance)^2 below `most`.
bool is_small_and_above(vec3 c, vec3 u, vec3 v, vec3 n, vec3 m, float most)
{
    // No corner is farther from the centre than both half edges together.
    float size_2 = max(dot(u, u), dot(v, v));
    return min(dot(c, n), dot(c, m)) > 2.0 * sqrt(size_2) && size_2 < most * dot(c, c);
}

float integral_by_points(vec3 c, vec3 u, vec3 v, vec3 n)
{
    vec3 uv = cross(u, v);
    vec3 gu = GAUSS_POINT * u;
    vec3 gv = GAUSS_POINT * v;
    return point_form(c - gu - gv, uv, n) + point_form(c + gu - gv, uv, n)
         + point_form(c + gu + gv, uv, n) + point_form(c - gu + gv, uv, n);
}

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

    if (is_small_and_above(c, u, v, n, m, SMALL_LIGHT)) {
        return integral_by_points(c, u, v, n);
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

// Normal of a rectangle, not of unit length: products of lengths would overflow or vanish.
vec3 front_of(Light light)
{
    return cross(light.axis_vs / largest_component(light.axis_vs),
                 light.second_axis_vs / largest_component(light.second_axis_vs));
}

// Irradiance of a rectangle light at `p`; 0 on its dark side, in its plane and on it.
vec3 rectangle_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    vec3 c = light.place_vs - p_vs;
    vec3 normal = front_of(light);
    float height = -dot(c, normal);
    float rounding = LIGHT_ROUNDING * length(normal)
                   * (largest_component(p_vs) + largest_component(light.place_vs));
    if (!(light.two_sided ? abs(height) > rounding : height > rounding)) {
        return vec3(0.0);
    }
    float f = parallelogram_cosine_integral(c, light.axis_vs, light.second_axis_vs, n_vs, m_vs);
    return light.power * max(height > 0.0 ? f : -f, 0.0);
}

// Distance along w at which the ray from p_vs meets the rectangle's emitting side;
// FLOAT_MAX if it does not.
float rectangle_distance(Light light, vec3 p_vs, vec3 w)
{
    vec2 size = vec2(largest_component(light.axis_vs), largest_component(light.second_axis_vs));
    vec3 u = light.axis_vs / size.x;
    vec3 v = light.second_axis_vs / size.y;
    vec3 normal = cross(u, v);  // not unit length; the front is on its side
    vec3 from_centre = p_vs - light.place_vs;
    float height = dot(from_centre, normal);
    float rate = dot(w, normal);
    // Towards the plane: the height and its rate of change have opposite signs.
    bool approaches = height * rate < 0.0;
    float t = -height / (approaches ? rate : 1.0);
    // Coordinates in the plane by the dual basis of (u, v): -size..size inside.
    vec3 offset = (from_centre + t * w) / max(dot(normal, normal), 1e-37);
    float a = dot(offset, cross(v, normal));
    float b = dot(offset, cross(normal, u));
    bool emits_here = height > 0.0 || light.two_sided;
    bool is_inside = abs(a) <= size.x && abs(b) <= size.y;
    return emits_here && approaches && is_inside ? t : FLOAT_MAX;
}

// The point of the rectangle at `u` in the unit square.
vec3 rectangle_point(Light light, vec2 u)
{
    vec2 q = 2.0 * u - 1.0;
    return light.place_vs + q.x * light.axis_vs
                                    + q.y * light.second_axis_vs;
}

// Unit normal of the rectangle on the side of p_vs.
vec3 rectangle_normal(Light light, vec3 p_vs)
{
    vec3 n = normalize(front_of(light));
    return dot(p_vs - light.place_vs, n) < 0.0 ? -n : n;
}
