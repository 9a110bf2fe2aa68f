// Which of 32 points of a light a surface point does not see, by one walk through the hierarchy.
//
// All ways to the points lie in a shaft (Haines, Wallace 1991): the walk meets the boxes that any
// of them may meet, and each triangle hides the points that it lies before, as bits (after Eisemann,
// Decoret 2007). So no blocker is missed, however thin. Where more triangles lie in the shaft than
// SHAFT_STEPS allow, rays to the points that are left take less time.
//
// SHAFT_IS_ROUND: points are those of a disk, not of a parallelogram.
#include "lib/constants.glsl"
#include "rays/bvh.glsl"

uniform vec2 u_shaft_step;  // from each of the light's points to the next

// Of the hierarchy. 12 take 1.19 of the time in cornell_meso, .96 in coloured_lights, 64 take 1.15
// and 1.21; where nothing else is in the shaft, there are two to six.
const int SHAFT_STEPS = 24;

// Four points of the light from number `i` after `begin` on: x and y, as multiples of its axes.
mat2x4 shaft_points(vec2 begin, int i)
{
    vec4 numbers = float(i) + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 u = fract(begin.x + numbers * u_shaft_step.x);
    vec4 v = fract(begin.y + numbers * u_shaft_step.y);
#if SHAFT_IS_ROUND
    vec4 r = sqrt(u);
    return mat2x4(r * cos(TWO_PI * v), r * sin(TWO_PI * v));
#else
    return mat2x4(2.0 * u - 1.0, 2.0 * v - 1.0);
#endif
}

struct Shaft {
    vec3 apex;
    mat3 way;           // columns: to the middle of the light, and from there along its axes
    vec3 inverse_low;   // 1 / the least way to a point of the light along each of the axes of _ns
    vec3 inverse_high;  // 1 / the largest
    float t_max;        // the end, as a part of the ways
};

vec3 shaft_way(Shaft shaft, mat2x4 points, int i)
{
    return shaft.way * vec3(1.0, points[0][i], points[1][i]);
}

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

// A triangle as seen from the apex: a point is hidden where all sides are positive, if `volume`
// is less than t_max times their sum.
struct ShaftTriangle {
    vec3 side_0;
    vec3 side_1;
    vec3 side_2;
    float volume;
};

ShaftTriangle shaft_triangle(vec3 side_0, vec3 side_1, vec3 side_2, float volume)
{
    float s = sign(volume);
    return ShaftTriangle(side_0 * s, side_1 * s, side_2 * s, abs(volume));
}

float shaft_largest(vec3 side)
{
    return side.x + abs(side.y) + abs(side.z);
}

bool shaft_may_hide(ShaftTriangle item, float t_max)
{
    float least = min(min(shaft_largest(item.side_0), shaft_largest(item.side_1)),
                      shaft_largest(item.side_2));
    float most = shaft_largest(item.side_0 + item.side_1 + item.side_2);
    return least >= 0.0 && item.volume < t_max * most;
}

vec4 shaft_sides(vec3 side, mat2x4 points)
{
    return side.x + side.y * points[0] + side.z * points[1];
}

bvec4 shaft_hides(ShaftTriangle item, mat2x4 points, float t_max)
{
    vec4 side_0 = shaft_sides(item.side_0, points);
    vec4 side_1 = shaft_sides(item.side_1, points);
    vec4 side_2 = shaft_sides(item.side_2, points);
    vec4 least = min(min(side_0, side_1), side_2);
    vec4 reach = t_max * (side_0 + side_1 + side_2) - item.volume;
    bvec4 is_inside = greaterThanEqual(least, vec4(0.0));
    bvec4 is_before = greaterThan(reach, vec4(0.0));
    return bvec4(uvec4(is_inside) & uvec4(is_before));
}

// What a pair of triangles hides of the points that are open, as bits.
uint shaft_meet_pair(Shaft shaft, BvhRecord pair, int record, bool is_leaf, vec2 begin, int count)
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
    ShaftTriangle item_1 = shaft_triangle(
        shaft_side(shaft, v0, v1), shaft_side(shaft, v1, v2), side_20, volume_1);
    ShaftTriangle item_2 = shaft_triangle(
        -side_20, shaft_side(shaft, v2, v3), shaft_side(shaft, v3, v0), volume_2);
    bool is_met = shaft_may_hide(item_1, shaft.t_max) || shaft_may_hide(item_2, shaft.t_max);
    int end = is_leaf && is_met ? count : 0;
    uint hidden = 0u;
    int i = 0;
    do {
        mat2x4 points = shaft_points(begin, i);
        uvec4 hides = uvec4(shaft_hides(item_1, points, shaft.t_max))
            | uvec4(shaft_hides(item_2, points, shaft.t_max));
        hides <<= uvec4(0u, 1u, 2u, 3u);
        hidden |= (hides.x | hides.y | hides.z | hides.w) << uint(i);
        i += 4;
    } while (i < end);
    return end > 0 ? hidden : 0u;
}

bool shaft_point_is_hidden(Shaft shaft, vec2 begin, int number)
{
    vec3 way = shaft_way(shaft, shaft_points(begin, number), 0);
    float size = max(length(way), 1e-30);
    return bvh_light_is_blocked(shaft.apex, way / size, shaft.t_max * size);
}

uint shaft_all_points(int count)
{
    return 0xffffffffu >> uint(32 - count);
}

// Points as bits.
struct ShaftPoints {
    uint open;
    bool by_rays;  // the shaft did not tell
};

// Asks for `count` points of the light from `begin` on.
ShaftPoints shaft_open_points(Shaft shaft, vec2 begin, int count)
{
    uint all = shaft_all_points(count);
    uint open = all;
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
        open &= ~shaft_meet_pair(shaft, record, number, is_leaf, begin, count);
        goes_on = walk.goes_on && open != 0u;
    } while (goes_on && ++steps < SHAFT_STEPS);
#if RAY_CUTOUTS
    // What hides a point may have a hole there.
    uint unsure = goes_on ? all : all & ~open;
#else
    uint unsure = goes_on ? open : 0u;
#endif
    int end = unsure == 0u ? 0 : count;
    int i = 0;
    if (end > 0) do {
        uint bit = 1u << uint(i);
        if ((unsure & bit) != 0u) {
            bool is_hidden = shaft_point_is_hidden(shaft, begin, i);
            open = is_hidden ? open & ~bit : open | bit;
        }
    } while (++i < end);
    return ShaftPoints(open, unsure != 0u);
}
