// What a lobe reflects of a rectangle, and how much of it the lobe sees. Any frame; needs lib/brdf.glsl
// and lights/lights.glsl.
#if GLOSSY
// Gauss's points and weights on [-1, 1]: 6, and 14 for lines across a rectangle that reaches to
// the horizon or nearly so, where lobes end.
const int GAUSS_COUNT = 6;
const int LOW_COUNT = 14;
const float GAUSS_POINTS[GAUSS_COUNT + LOW_COUNT] = float[](
    -0.93246951420315, -0.66120938646626, -0.23861918608320, 0.23861918608320, 0.66120938646626,
    0.93246951420315,
    -0.98628380869681, -0.92843488366357, -0.82720131506977, -0.68729290481169, -0.51524863635815,
    -0.31911236892789, -0.10805494870734, 0.10805494870734, 0.31911236892789, 0.51524863635815,
    0.68729290481169, 0.82720131506977, 0.92843488366357, 0.98628380869681);
const float GAUSS_WEIGHTS[GAUSS_COUNT + LOW_COUNT] = float[](
    0.17132449237917, 0.36076157304814, 0.46791393457269, 0.46791393457269, 0.36076157304814,
    0.17132449237917,
    0.03511946033175, 0.08015808715976, 0.12151857068790, 0.15720316715819, 0.18553839747794,
    0.20519846372130, 0.21526385346316, 0.21526385346316, 0.20519846372130, 0.18553839747794,
    0.15720316715819, 0.12151857068790, 0.08015808715976, 0.03511946033175);

// Of half of a rectangle, that a lobe sees at least of it.
const float LEAST_SEEN = 0.02;

// Where on a line through middle + s edge, seen from the origin, Gauss's points of equal
// angles lie.
struct Angles {
    float foot;    // minus s of the point next to the origin
    float width;   // distance of that point in edges
    float middle;  // of the angles from that point
    float half_range;
};

// `height` of the line's middle above the horizon, `rise` of its edge: s from -1 to 1, but
// above the horizon only.
Angles angles_on_line(vec3 middle, vec3 edge, float height, float rise)
{
    float edge_2 = max(dot(edge, edge), 1e-30);
    float foot = dot(middle, edge) / edge_2;
    float width = max(length(middle - foot * edge) * inversesqrt(edge_2), 1e-6 * (1.0 + abs(foot)));
    float crossing = rise == 0.0 ? (height > 0.0 ? -1.0 : 1.0) : clamp(-height / rise, -1.0, 1.0);
    vec2 ends = rise < 0.0 ? vec2(-1.0, crossing) : vec2(crossing, 1.0);
    vec2 angles = atan((ends + foot) / width);
    return Angles(foot, width, 0.5 * (angles.x + angles.y), 0.5 * (angles.y - angles.x));
}

// s of the point of that number, and its weight in an integral over s.
vec2 point_of_angles(Angles angles, int i)
{
    float tangent = tan(angles.middle + angles.half_range * GAUSS_POINTS[i]);
    float weight = angles.half_range * GAUSS_WEIGHTS[i] * angles.width * (1.0 + tangent * tangent);
    return vec2(angles.width * tangent - angles.foot, weight);
}

// How facets mirror near the axis of a lobe: by the tangents `width` along x and
// width * narrowing along y it is about half as high.
struct Lobe {
    vec3 x;
    vec3 y;
    vec3 axis;
    float width;
    float narrowing;
};

Lobe lobe_of(vec3 n, vec3 w_out, float cos_out, float alpha)
{
    vec3 axis = normalize(2.0 * cos_out * n - w_out);
    vec3 across = cross(n, axis);
    float size = length(across);
    vec3 y = size > 1e-5 ? across / size : frame_from_z(axis)[1];
    float width = 1.75 * alpha / (1.0 + 1.75 * alpha);
    float narrowing = sqrt(cos_out * cos_out + 0.8 * alpha * alpha);
    return Lobe(cross(y, axis), y, axis, width, narrowing);
}

// To the space in which the lobe is about as wide as a clamped cosine, up to scale: a
// linear map, as those of Heitz et al. 2016. Parallelograms stay what they are.
mat3 cosine_from_lobe(Lobe lobe)
{
    return transpose(mat3(lobe.x, lobe.y / lobe.narrowing, lobe.axis * lobe.width));
}

// Where a lobe meets the plane of a rectangle seen from the surface, and half of what it sees most of
// there: with edges as units, from -1 to 1 along each.
struct LobeOnPlane {
    vec2 middle;
    vec2 half_size;
    bool is_met;
};

LobeOnPlane lobe_on_plane(Lobe lobe, vec3 c, vec3 u, vec3 v)
{
    vec3 normal = cross(u, v);
    float square = max(dot(normal, normal), 1e-37);
    float rate = dot(lobe.axis, normal);
    float height = dot(c, normal);
    bool is_met = height * rate > 1e-4 * abs(height) * sqrt(square);
    float reach = is_met ? height / rate : 0.0;
    // Dot products with these are coordinates.
    vec3 dual_u = cross(v, normal) / square;
    vec3 dual_v = cross(normal, u) / square;
    vec3 offset = reach * lobe.axis - c;
    vec3 x = lobe.x * (lobe.width * reach);
    vec3 y = lobe.y * (lobe.width * lobe.narrowing * reach);
    x -= is_met ? lobe.axis * (dot(x, normal) / rate) : vec3(0.0);
    y -= is_met ? lobe.axis * (dot(y, normal) / rate) : vec3(0.0);
    return LobeOnPlane(vec2(dot(offset, dual_u), dot(offset, dual_v)),
                       abs(vec2(dot(x, dual_u), dot(x, dual_v))) + abs(vec2(dot(y, dual_u), dot(y, dual_v))),
                       is_met);
}

// What the lobe sees most of, of the rectangle: low and high corner. All of it, where it does not meet
// the plane.
vec4 seen_of_rectangle(LobeOnPlane lobe)
{
    vec2 half_size = max(lobe.half_size, vec2(LEAST_SEEN));
    vec4 seen = vec4(min(lobe.middle - half_size, 1.0 - LEAST_SEEN),
                     max(lobe.middle + half_size, LEAST_SEEN - 1.0));
    return lobe.is_met ? clamp(seen, -1.0, 1.0) : vec4(-1.0, -1.0, 1.0, 1.0);
}

// Radiance that the glossy layer makes of a rectangle of radiance 1, unshadowed: its centre as seen
// from the surface, half of its edges. Points of equal angles in the lobe's own space are dense
// where the lobe is high.
vec3 gloss_of_rectangle(Brdf brdf, vec3 c, vec3 u, vec3 v, vec3 n, vec3 w_out)
{
    // Only directions count. Dividing by the largest length keeps squares in range.
    float scale = max(largest_component(c), max(largest_component(u), largest_component(v)));
    c /= scale;
    u /= scale;
    v /= scale;
    vec3 uv = cross(u, v);
    // Of a low rectangle, lines that run up from the horizon.
    float height = dot(c, n);
    float u_rise = dot(u, n);
    float v_rise = dot(v, n);
    bool is_low = height < 2.0 * (abs(u_rise) + abs(v_rise));
    if (is_low && abs(u_rise) < abs(v_rise)) {
        vec3 other = u;
        u = v;
        v = other;
        u_rise = dot(u, n);
        v_rise = dot(v, n);
    }
    mat3 m = cosine_from_lobe(lobe_of(n, w_out, cosine_out(n, w_out), alpha_of(brdf.roughness)));
    vec3 c_cs = m * c;
    vec3 u_cs = m * u;
    vec3 v_cs = m * v;
    vec3 along_u = u_cs * inversesqrt(max(dot(u_cs, u_cs), 1e-30));
    Angles lines = angles_on_line(c_cs - along_u * dot(c_cs, along_u),
                                  v_cs - along_u * dot(v_cs, along_u), height + abs(u_rise), v_rise);
    // Tested at their ends, because in software other loops cost two rounds more than they run; and
    // left where nothing is glossy, because they would go through a branch that is not taken.
    int i = is_low ? GAUSS_COUNT : 0;
    int end = is_glossy(brdf) ? i + (is_low ? LOW_COUNT : GAUSS_COUNT) : 0;
    FacetView view = facet_view(brdf, n, w_out);
    vec2 sum = vec2(0.0);
    do {
        vec2 t = point_of_angles(lines, i);
        vec3 q = c + t.x * v;
        Angles points = angles_on_line(c_cs + t.x * v_cs, u_cs, dot(q, n), u_rise);
        int j = 0;
        do {
            vec2 s = point_of_angles(points, j);
            vec3 p = q + s.x * u;
            float inverse = inversesqrt(max(dot(p, p), 1e-30));
            float solid_angle = abs(dot(uv, p)) * inverse * inverse * inverse * s.y * t.y;
            sum += once_shares(view, p * inverse) * solid_angle;
        } while (++j < GAUSS_COUNT);
    } while (++i < end);
    return once_of_shares(brdf, sum) * rescattered(brdf, cosine_out(n, w_out));
}
#endif
