// Which of up to 256 points of a light a surface point does not see, by one walk through the hierarchy.
//
// All ways to the points lie in a shaft (Haines, Wallace 1991): the walk meets the boxes that any
// of them may meet, and each triangle hides the points that it lies before, as bits (after Eisemann,
// Decoret 2007). So no blocker is missed, however thin. The points stand on parallel lines, so
// those that a triangle hides of one follow each other: where they begin and end is told by
// where its edges cut the line. Where more triangles lie in the shaft than u_shaft_steps allow,
// rays to some of the points take less time.
//
// SHAFT_GROUPS: how many times four lines there are, 1 or 2.
#include "lib/constants.glsl"
#include "rays/bvh.glsl"

// Lines, four by four: where the first of the 32 points on each stands, and from each to the
// next, as multiples of the light's axes; and which of them are on the light, as bits.
uniform vec4 u_shaft_x[SHAFT_GROUPS];
uniform vec4 u_shaft_y[SHAFT_GROUPS];
uniform vec2 u_shaft_step;
uniform uvec4 u_shaft_points[SHAFT_GROUPS];
// Records of the hierarchy that are looked at, and rays where these do not tell. Where nothing else
// is in the shaft, there are two to six.
uniform int u_shaft_steps;
uniform int u_shaft_rays;

struct Shaft {
    vec3 apex;
    mat3 way;           // columns: to the middle of the light, and from there along its axes
    vec3 inverse_low;   // 1 / the least way to a point of the light along each of the axes of _ns
    vec3 inverse_high;  // 1 / the largest
    float t_max;        // the end, as a part of the ways
};

// `extent`: how far the light reaches from its middle, along each of the axes of _ns.
Shaft shaft_from(vec3 apex, mat3 way, vec3 extent, float t_max)
{
    return Shaft(apex, way, bvh_inverse(way[0] - extent), bvh_inverse(way[0] + extent), t_max);
}

// Where ways enter four boxes at the earliest and leave them at the latest, along one axis:
// t * high >= box_low and t * low <= box_high, whatever their signs.
void shaft_meet_slabs(vec4 box_low, vec4 box_high, float inverse_low, float inverse_high,
                      inout vec4 enter, inout vec4 leave)
{
    vec4 a = box_low * inverse_high;
    vec4 b = box_high * inverse_low;
    bool a_enters = inverse_high > 0.0;
    bool b_enters = inverse_low < 0.0;
    enter = max(enter, max(a_enters ? a : vec4(0.0), b_enters ? b : vec4(0.0)));
    leave = min(leave, min(a_enters ? vec4(FLOAT_MAX) : a, b_enters ? vec4(FLOAT_MAX) : b));
}

BvhChildren shaft_children(Shaft shaft, BvhRecord node, bool is_leaf)
{
    vec3 base = uintBitsToFloat(node.words_0.xyz) - shaft.apex;
    uint head = node.words_0.w;
    vec3 scale = uintBitsToFloat((uvec3(head, head >> 8, head >> 16) & 255u) << 23);
    uvec3 low = node.words_1.xyz;
    uvec3 high = uvec3(node.words_1.w, node.words_2.xy);
    vec4 enter = vec4(0.0);
    vec4 leave = vec4(shaft.t_max);
    for (int i = 0; i < 3; ++i) {
        shaft_meet_slabs(bvh_bytes(low[i]) * scale[i] + base[i],
                         bvh_bytes(high[i]) * scale[i] + base[i],
                         shaft.inverse_low[i], shaft.inverse_high[i], enter, leave);
    }
    return bvh_met(node, is_leaf, enter, leave);
}

// On which side of the plane through the apex and an edge a point of the light lies, as a linear
// function of its place. Swapping a and b negates it whatever is rounded, fused or not: so no
// way passes between triangles that share an edge ("robust Pluecker test" of Embree).
vec3 shaft_side(Shaft shaft, vec3 a, vec3 b)
{
    return cross(a + b, b - a) * shaft.way;
}

// Six times the volume over a triangle, with shaft_side's factor of 2. 0: it hides nothing.
float shaft_volume(vec3 a, vec3 b, vec3 c)
{
    return 2.0 * dot(cross(b - a, c - a), a);
}

// A triangle as seen from the apex: a point is hidden where all sides and `reach` are positive.
struct ShaftTriangle {
    vec3 side_0;
    vec3 side_1;
    vec3 side_2;
    vec3 reach;
};

ShaftTriangle shaft_triangle(vec3 side_0, vec3 side_1, vec3 side_2, float volume, float t_max)
{
    float s = sign(volume);
    // One without a volume hides nothing.
    float height = s == 0.0 ? 1.0 : abs(volume);
    vec3 reach = t_max * s * (side_0 + side_1 + side_2) - vec3(height, 0.0, 0.0);
    return ShaftTriangle(side_0 * s, side_1 * s, side_2 * s, reach);
}

float shaft_largest(vec3 side)
{
    return side.x + abs(side.y) + abs(side.z);
}

bool shaft_may_hide(ShaftTriangle item)
{
    float least = min(min(shaft_largest(item.side_0), shaft_largest(item.side_1)),
                      shaft_largest(item.side_2));
    return least >= 0.0 && shaft_largest(item.reach) > 0.0;
}

// Where a plane through the apex cuts four lines, in steps from their first points: the same,
// whatever is rounded, if `side` is negated. On `rises` it is positive from there on.
struct ShaftCut {
    vec4 at;
    float slope;
};

ShaftCut shaft_cut(vec3 side, vec4 x, vec4 y)
{
    float slope = dot(side.yz, u_shaft_step);
    slope = slope >= 0.0 ? max(slope, 1e-30) : min(slope, -1e-30);
    return ShaftCut((side.x + side.y * x + side.z * y) * (-1.0 / slope), slope);
}

// Leaves of four lines what lies where the side is positive.
void shaft_keep(ShaftCut cut, bool rises, inout vec4 low, inout vec4 high)
{
    low = max(low, rises ? cut.at : vec4(0.0));
    high = min(high, rises ? vec4(31.0) : cut.at);
}

uvec4 shaft_hides(ShaftTriangle item, vec4 x, vec4 y)
{
    vec4 low = vec4(0.0);
    vec4 high = vec4(31.0);
    ShaftCut cut = shaft_cut(item.side_0, x, y);
    shaft_keep(cut, cut.slope > 0.0, low, high);
    cut = shaft_cut(item.side_1, x, y);
    shaft_keep(cut, cut.slope > 0.0, low, high);
    cut = shaft_cut(item.side_2, x, y);
    shaft_keep(cut, cut.slope > 0.0, low, high);
    cut = shaft_cut(item.reach, x, y);
    shaft_keep(cut, cut.slope > 0.0, low, high);
    low = ceil(low);
    high = floor(high);
    uvec4 some = (uvec4(0xffffffffu) >> uvec4(31.0 - high)) & (uvec4(0xffffffffu) << uvec4(low));
    return some * uvec4(lessThanEqual(low, high));
}

// Points as bits: those that the walk found nothing before, and of these, if it did not tell whether
// they are open, those that rays were sent to and that are.
struct ShaftPoints {
    uvec4 left[SHAFT_GROUPS];
    uvec4 asked[SHAFT_GROUPS];
    uvec4 open[SHAFT_GROUPS];
    bool by_rays;
};

// A pair of triangles, and whether it may hide any point.
struct ShaftPair {
    ShaftTriangle first;
    ShaftTriangle second;
    bool is_met;
};

ShaftPair shaft_pair(Shaft shaft, BvhRecord pair, int record, bool is_leaf)
{
    mat4x3 corners = bvh_corners(pair);
    vec3 v0 = corners[0] - shaft.apex;
    vec3 v1 = corners[1] - shaft.apex;
    vec3 v2 = corners[2] - shaft.apex;
    vec3 v3 = corners[3] - shaft.apex;
    vec3 side_20 = shaft_side(shaft, v2, v0);
    float volume_1 = shaft_volume(v0, v1, v2);
    float volume_2 = shaft_volume(v0, v2, v3);
#if RAY_SINGLE_SIDED
    // Light that comes from behind passes.
    uvec4 words_3 = bvh_texel(record, 3);
    volume_1 = (words_3.y & SINGLE_SIDED_FLAG) == 0u ? volume_1 : max(volume_1, 0.0);
    volume_2 = (words_3.z & SINGLE_SIDED_FLAG) == 0u ? volume_2 : max(volume_2, 0.0);
#endif
    ShaftTriangle first = shaft_triangle(
        shaft_side(shaft, v0, v1), shaft_side(shaft, v1, v2), side_20, volume_1, shaft.t_max);
    ShaftTriangle second = shaft_triangle(
        -side_20, shaft_side(shaft, v2, v3), shaft_side(shaft, v3, v0), volume_2, shaft.t_max);
    bool may_hide = shaft_may_hide(first) || shaft_may_hide(second);
    return ShaftPair(first, second, is_leaf && may_hide);
}

// Leaves of the points that are open those that a pair does not hide.
void shaft_meet_pair(ShaftPair pair, inout uvec4 open[SHAFT_GROUPS])
{
    for (int g = 0; g < SHAFT_GROUPS; ++g) {
        uvec4 hidden = shaft_hides(pair.first, u_shaft_x[g], u_shaft_y[g])
            | shaft_hides(pair.second, u_shaft_x[g], u_shaft_y[g]);
        open[g] &= pair.is_met ? ~hidden : uvec4(0xffffffffu);
    }
}

vec3 shaft_way(Shaft shaft, int line, float number)
{
    vec2 first = vec2(u_shaft_x[line >> 2][line & 3], u_shaft_y[line >> 2][line & 3]);
    return shaft.way * vec3(1.0, first + number * u_shaft_step);
}

bool shaft_point_is_hidden(Shaft shaft, int line, int bit)
{
    vec3 way = shaft_way(shaft, line, float(bit));
    float size = max(length(way), 1e-30);
    return bvh_light_is_blocked(shaft.apex, way / size, shaft.t_max * size);
}

bool shaft_are_same(uvec4 a[SHAFT_GROUPS], uvec4 b[SHAFT_GROUPS])
{
    uvec4 differ = uvec4(0u);
    for (int g = 0; g < SHAFT_GROUPS; ++g) {
        differ |= a[g] ^ b[g];
    }
    return differ == uvec4(0u);
}

bool shaft_is_any(uvec4 bits[SHAFT_GROUPS])
{
    uvec4 any_bit = bits[0];
    for (int g = 1; g < SHAFT_GROUPS; ++g) {
        any_bit |= bits[g];
    }
    return any_bit != uvec4(0u);
}

// Which points of the light are open.
ShaftPoints shaft_open_points(Shaft shaft)
{
    ShaftPoints points = ShaftPoints(u_shaft_points, u_shaft_points, u_shaft_points, false);
    BvhRecord root = BvhRecord(u_bvh_root[0], u_bvh_root[1], u_bvh_root[2]);
    BvhWalk walk = bvh_waiting(shaft.t_max);
    bvh_go_on(shaft_children(shaft, root, false), walk);
    walk.goes_on = walk.goes_on && shaft.t_max > 0.0;
    bool goes_on = walk.goes_on;
    int steps = 0;
    if (goes_on) do {
        BvhRecord record = bvh_record(walk.record);
        bool is_leaf = walk.is_leaf;
        int number = walk.record;
        bvh_go_on(shaft_children(shaft, record, is_leaf), walk);
        shaft_meet_pair(shaft_pair(shaft, record, number, is_leaf), points.left);
        goes_on = walk.goes_on && shaft_is_any(points.left);
    } while (goes_on && ++steps < u_shaft_steps);
    points.by_rays = goes_on;
#if RAY_CUTOUTS
    // What hides a point may have a hole there.
    points.by_rays = goes_on || !shaft_are_same(points.left, u_shaft_points);
    if (points.by_rays) {
        points.left = u_shaft_points;
    }
#endif
    int end = points.by_rays ? u_shaft_rays : 0;
    for (int g = 0; g < SHAFT_GROUPS; ++g) {
        points.asked[g] = end > 0 ? uvec4(0u) : points.left[g];
        points.open[g] = points.asked[g];
    }
    int i = 0;
    if (end > 0) do {
        // Evenly spread along the lines, and over them, whatever their number.
        int line = 3 * i & (4 * SHAFT_GROUPS - 1);
        int bit = (64 * i + 32) / (2 * end);
        uvec4 mask = uvec4(equal(ivec4(line & 3), ivec4(0, 1, 2, 3))) << uint(bit);
        bool is_left = false;
        for (int g = 0; g < SHAFT_GROUPS; ++g) {
            is_left = is_left || line >> 2 == g && (mask & points.left[g]) != uvec4(0u);
        }
        if (is_left) {
            bool is_hidden = shaft_point_is_hidden(shaft, line, bit);
            for (int g = 0; g < SHAFT_GROUPS; ++g) {
                uvec4 own = line >> 2 == g ? mask : uvec4(0u);
                points.asked[g] |= own;
                points.open[g] |= is_hidden ? uvec4(0u) : own;
            }
        }
    } while (++i < end);
    return points;
}
