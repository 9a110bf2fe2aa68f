// Rays against the scene's triangles: the nearest hit, or whether there is one.
//
// Everything is in the normalised frame (_ns): the scene's bounds centred, half-diagonal
// 1, axes of the world. Layout of the records: ssdo_gl/raytracing/bvh.py.
//
// A step takes one record, node or primitive, and does the work of both kinds, because
// pixels that run in lockstep wait for each other anyway and fetching is what costs. The
// children of a node that wait share one word: group of four records (22 bits),
// number of inner children (3), and a list of child numbers, nearest lowest, 2 bits each,
// under a leading 1 (7). Measured on llvmpipe, 300 000 and 2 500 triangles: 4 times
// faster than one entry for each child on an indexed stack.
//
// BVH_LEVELS: levels of nodes, the largest number of waiting words.
// BVH_STACK_IN_REGISTERS: 1 shifts the words through registers: a push costs BVH_LEVELS
// moves, 5 ns for 8 pixels on llvmpipe, where a store to an address that differs between
// pixels takes 36 ns. 0 indexes an array, as graphics hardware prefers.

#include "lib/sampling.glsl"
#include "rays/surface_data.glsl"

uniform usampler2D t_bvh;
// The first three texels of the root. Every ray begins there: fetching it, once for each
// pixel that runs in lockstep, would be a tenth of all fetches.
uniform uvec4 u_bvh_root[3];

const uint BVH_NO_CHILD = 0xffffffffu;

struct BvhHit {
    float t;         // along the direction, whose length is 1
    int record;      // of the pair that was hit, -1: none
    bool is_second;  // its triangle (v0, v2, v3) instead of (v0, v1, v2)
};

uvec4 bvh_texel(int record, int texel)
{
    return texelFetch(t_bvh, record_place(record, RECORD_TEXELS) + ivec2(texel, 0), 0);
}

vec4 bvh_bytes(uint word)
{
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u);
}

// 1 / w with zeros replaced by something whose inverse is finite: infinity times an edge
// at distance zero would be NaN.
vec3 bvh_inverse(vec3 w)
{
    vec3 side = vec3(w.x < 0.0 ? -1.0 : 1.0, w.y < 0.0 ? -1.0 : 1.0, w.z < 0.0 ? -1.0 : 1.0);
    return side / max(abs(w), vec3(1e-20));
}

uint bvh_append(uint list, uint key)
{
    return key != BVH_NO_CHILD ? list << 2 | (key & 3u) : list;
}

// On which side of the edge a-b the ray passes; x and y are across the ray, z along it.
// Rounding cannot turn the sign of a difference of two products over, only make it zero,
// and swapping a and b negates it: so of the triangles around an edge or a vertex at least
// one is always hit (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection").
float bvh_edge_side(vec3 a, vec3 b)
{
    float forward = a.x * b.y;
    float backward = b.x * a.y;
    float side = forward - backward;
#if BVH_FUSES
    // Fused into the difference, a product is not rounded, and the sign may turn over by
    // one rounding: two of them are taken for zero, which lies inside of all triangles.
    side = abs(side) > 2.0 * FLOAT_EPSILON * abs(forward) ? side : 0.0;
#endif
    return side;
}

bool bvh_is_inside(float side_0, float side_1, float side_2)
{
    return min(min(side_0, side_1), side_2) >= 0.0 || max(max(side_0, side_1), side_2) <= 0.0;
}

// What does not change along a ray.
struct BvhRay {
    vec3 origin;
    mat3 axes;          // columns: two axes across the ray and the ray itself
    vec3 inverse;       // 1 / direction
    bvec3 is_negative;
    float facing;       // of single-sided triangles it meets 1: fronts, -1: backs, 0: both
};

// Where a ray is on its way through the hierarchy.
struct BvhWalk {
    uint waiting[BVH_LEVELS];
    int top;            // number of waiting words, unless they are in registers
    int record;         // to look at next
    bool is_leaf;       // which is a primitive
    bool goes_on;
    BvhHit hit;
};

BvhRay bvh_ray(vec3 origin, vec3 w)
{
    vec3 inverse = bvh_inverse(w);
    return BvhRay(origin, frame_from_z(w), inverse, lessThan(inverse, vec3(0.0)), 1.0);
}

// A ray to a light stands for one that comes from it, which meets the other sides. One that is drawn
// to the sky meets the sides that one by chance does: together they find it. What meets all sides
// tells whether a lamp can be found in both ways.
const float SIDES_TO_LIGHT = -1.0;
const float SIDES_TO_SKY = 1.0;
const float ALL_SIDES = 0.0;

BvhRay bvh_ray_to_light(vec3 origin, vec3 w, float sides)
{
    BvhRay ray = bvh_ray(origin, w);
    ray.facing = sides;
    return ray;
}

// What a record holds, as bits.
struct BvhRecord {
    uvec4 words_0;
    uvec4 words_1;
    uvec4 words_2;
};

// The record as a primitive: columns v0 to v3 of two triangles, (v0, v1, v2) and (v0, v2, v3).
mat4x3 bvh_corners(BvhRecord pair)
{
    return mat4x3(uintBitsToFloat(pair.words_0), uintBitsToFloat(pair.words_1),
                  uintBitsToFloat(pair.words_2));
}

// The children of a node that a ray meets.
struct BvhChildren {
    uint nearest;      // number in the last two bits, BVH_NO_CHILD: none
    uint list;         // the others, nearest lowest, under a leading 1
    uint first;        // record of child 0
    uint inner_count;
};

// The record as a node: which of its boxes are met, of those that `enter` and `leave` are known of.
BvhChildren bvh_met(BvhRecord node, bool is_leaf, vec4 enter, vec4 leave)
{
    bvec4 is_met = lessThanEqual(enter, leave);
    uint child_count = is_leaf ? 0u : node.words_0.w >> 28;

    // Entry distances are not negative, so their bits sort like integers; the child's
    // number takes the place of the last two.
    uvec4 key = floatBitsToUint(enter) & ~3u | uvec4(0u, 1u, 2u, 3u);
    key.x = is_met.x && child_count > 0u ? key.x : BVH_NO_CHILD;
    key.y = is_met.y && child_count > 1u ? key.y : BVH_NO_CHILD;
    key.z = is_met.z && child_count > 2u ? key.z : BVH_NO_CHILD;
    key.w = is_met.w && child_count > 3u ? key.w : BVH_NO_CHILD;
    uvec2 less = min(key.xy, key.zw);
    uvec2 more = max(key.xy, key.zw);
    uint middle_0 = max(less.x, less.y);
    uint middle_1 = min(more.x, more.y);
    uint list = bvh_append(1u, max(more.x, more.y));
    list = bvh_append(list, max(middle_0, middle_1));
    list = bvh_append(list, min(middle_0, middle_1));
    return BvhChildren(min(less.x, less.y), list, node.words_2.z, node.words_0.w >> 24 & 15u);
}

// The record as a node: where the ray enters and leaves the four boxes.
BvhChildren bvh_children(BvhRay ray, BvhRecord node, bool is_leaf, float t_max)
{
    vec3 base = (uintBitsToFloat(node.words_0.xyz) - ray.origin) * ray.inverse;
    uint head = node.words_0.w;
    vec3 scale = uintBitsToFloat((uvec3(head, head >> 8, head >> 16) & 255u) << 23) * ray.inverse;
    uvec3 low = node.words_1.xyz;
    uvec3 high = uvec3(node.words_1.w, node.words_2.xy);
    bvec3 flips = ray.is_negative;
    uvec3 first = uvec3(flips.x ? high.x : low.x, flips.y ? high.y : low.y, flips.z ? high.z : low.z);
    uvec3 last = uvec3(flips.x ? low.x : high.x, flips.y ? low.y : high.y, flips.z ? low.z : high.z);
    vec4 enter = max(max(bvh_bytes(first.x) * scale.x + base.x, bvh_bytes(first.y) * scale.y + base.y),
                     max(bvh_bytes(first.z) * scale.z + base.z, vec4(0.0)));
    vec4 leave = min(min(bvh_bytes(last.x) * scale.x + base.x, bvh_bytes(last.y) * scale.y + base.y),
                     min(bvh_bytes(last.z) * scale.z + base.z, vec4(t_max)));
    return bvh_met(node, is_leaf, enter, leave);
}

// Whether the ray meets a triangle at 0 < t < t_max, and its t.
//
// `sides`: of the edge across from each corner, which is the corner's weight; `along`: how far
// along the ray each corner lies; `word` and `slot`: what surface_data.glsl knows it by.
bool bvh_meets_triangle(BvhRay ray, vec3 sides, vec3 along, uint word, int slot, float t_max,
                        out float t)
{
    float sum = sides.x + sides.y + sides.z;
    // Of a triangle seen edge-on all sides are zero: 0 / 0, which no comparison lets pass.
    t = dot(sides, along) / sum;
    bool is_met = bvh_is_inside(sides.x, sides.y, sides.z) && t > 0.0 && t < t_max;
#if RAY_SINGLE_SIDED
    // Sides are positive where the triangle's front looks along the ray.
    is_met = is_met && ((word & SINGLE_SIDED_FLAG) == 0u || sum * ray.facing <= 0.0);
#endif
#if RAY_CUTOUTS
    is_met = is_met && !is_cut_out(word, slot, sides);
#endif
    return is_met;
}

// The nearer of the ray's hits of a pair of triangles, or `hit` as it is.
BvhHit bvh_meet_pair(BvhRay ray, BvhRecord pair, int record, bool is_leaf, BvhHit hit)
{
    mat4x3 corners = bvh_corners(pair);
    vec3 v0 = (corners[0] - ray.origin) * ray.axes;
    vec3 v1 = (corners[1] - ray.origin) * ray.axes;
    vec3 v2 = (corners[2] - ray.origin) * ray.axes;
    vec3 v3 = (corners[3] - ray.origin) * ray.axes;
    float side_01 = bvh_edge_side(v0, v1);
    float side_12 = bvh_edge_side(v1, v2);
    float side_20 = bvh_edge_side(v2, v0);
    float side_23 = bvh_edge_side(v2, v3);
    float side_30 = bvh_edge_side(v3, v0);
#if RAY_CUTOUTS || RAY_SINGLE_SIDED
    uvec4 words_3 = bvh_texel(record, 3);
#else
    const uvec4 words_3 = uvec4(0u);
#endif
    int slot = int(words_3.x) * 2;
    float t_1, t_2;
    bool is_in_1 = bvh_meets_triangle(ray, vec3(side_12, side_20, side_01), vec3(v0.z, v1.z, v2.z),
                                      words_3.y, slot, hit.t, t_1);
    bool is_in_2 = bvh_meets_triangle(ray, vec3(side_23, side_30, -side_20), vec3(v0.z, v2.z, v3.z),
                                      words_3.z, slot + 1, hit.t, t_2);
    is_in_2 = is_in_2 && (!is_in_1 || t_2 < t_1);
    bool is_hit = is_leaf && (is_in_1 || is_in_2);
    return BvhHit(is_hit ? (is_in_2 ? t_2 : t_1) : hit.t, is_hit ? record : hit.record,
                  is_hit ? is_in_2 : hit.is_second);
}

// Where to go next: down to the nearest child, or back to one that waits.
void bvh_go_on(BvhChildren children, inout BvhWalk walk)
{
    bool descends = children.nearest != BVH_NO_CHILD;
    bool pushes = children.list > 1u;
    uint pushed = children.first << 8 | children.inner_count << 7 | children.list;
#if BVH_STACK_IN_REGISTERS
    for (int i = BVH_LEVELS - 1; i > 0; --i) {
        walk.waiting[i] = pushes ? walk.waiting[i - 1] : walk.waiting[i];
    }
    walk.waiting[0] = pushes ? pushed : walk.waiting[0];
    uint word = walk.waiting[0];
#else
    walk.top += pushes ? 1 : 0;
    if (pushes) {
        walk.waiting[walk.top - 1] = pushed;
    }
    uint word = walk.top > 0 ? walk.waiting[walk.top - 1] : 0u;
#endif
    uint near = children.nearest & 3u;
    uint waiting = word & 3u;
    uint rest = (word & 127u) >> 2;
    bool pops = !descends && rest == 1u;
    walk.record = int(descends ? children.first + near : ((word >> 10) << 2) + waiting);
    walk.is_leaf = descends ? near >= children.inner_count : waiting >= (word >> 7 & 7u);
    walk.goes_on = descends || word != 0u;
    word = descends ? word : word & ~127u | rest;
#if BVH_STACK_IN_REGISTERS
    walk.waiting[0] = word;
    for (int i = 0; i < BVH_LEVELS - 1; ++i) {
        walk.waiting[i] = pops ? walk.waiting[i + 1] : walk.waiting[i];
    }
    walk.waiting[BVH_LEVELS - 1] = pops ? 0u : walk.waiting[BVH_LEVELS - 1];
#else
    if (walk.top > 0) {
        walk.waiting[walk.top - 1] = word;
    }
    walk.top -= pops ? 1 : 0;
#endif
}

// Nothing waits.
BvhWalk bvh_waiting(float t_max)
{
    BvhWalk walk;
    for (int i = 0; i < BVH_LEVELS; ++i) {
        walk.waiting[i] = 0u;
    }
    walk.top = 0;
    walk.hit = BvhHit(t_max, -1, false);
    return walk;
}

// Takes the root; a negative t_max goes nowhere.
BvhWalk bvh_begin(BvhRay ray, float t_max)
{
    BvhWalk walk = bvh_waiting(t_max);
    BvhRecord root = BvhRecord(u_bvh_root[0], u_bvh_root[1], u_bvh_root[2]);
    bvh_go_on(bvh_children(ray, root, false, t_max), walk);
    walk.goes_on = walk.goes_on && t_max > 0.0;
    return walk;
}

BvhRecord bvh_record(int record)
{
    ivec2 place = record_place(record, RECORD_TEXELS);
    return BvhRecord(texelFetch(t_bvh, place, 0), texelFetch(t_bvh, place + ivec2(1, 0), 0),
                     texelFetch(t_bvh, place + ivec2(2, 0), 0));
}

// Takes one record, node or primitive, and does the work of both kinds.
void bvh_step(BvhRay ray, inout BvhWalk walk)
{
    BvhRecord record = bvh_record(walk.record);
    BvhChildren children = bvh_children(ray, record, walk.is_leaf, walk.hit.t);
    walk.hit = bvh_meet_pair(ray, record, walk.record, walk.is_leaf, walk.hit);
    bvh_go_on(children, walk);
}

// The nearest hit at 0 < t < t_max.
BvhHit bvh_nearest(vec3 origin, vec3 w, float t_max)
{
    BvhRay ray = bvh_ray(origin, w);
    BvhWalk walk = bvh_begin(ray, t_max);
    if (walk.goes_on) do {
        bvh_step(ray, walk);
    } while (walk.goes_on);
    return walk.hit;
}

// Whether there is any.
bool bvh_meets_any(BvhRay ray, float t_max)
{
    BvhWalk walk = bvh_begin(ray, t_max);
    if (walk.goes_on) do {
        bvh_step(ray, walk);
        walk.goes_on = walk.goes_on && walk.hit.record < 0;
    } while (walk.goes_on);
    return walk.hit.record >= 0;
}

bool bvh_is_blocked(vec3 origin, vec3 w, float t_max)
{
    return bvh_meets_any(bvh_ray(origin, w), t_max);
}

bool bvh_light_is_blocked(vec3 origin, vec3 w, float t_max)
{
    return bvh_meets_any(bvh_ray_to_light(origin, w, SIDES_TO_LIGHT), t_max);
}

// Both for two rays: whether anything blocks the first, to a light, and what the second
// meets. One loop for both, because pixels that run in lockstep then wait once for the
// longest sum of two rays instead of twice for the longest ray.
BvhHit bvh_blocked_and_nearest(
    BvhRay ray, float t_max_1, vec3 origin_2, vec3 w_2, float t_max_2, out bool is_blocked)
{
    BvhRay ray_2 = bvh_ray(origin_2, w_2);
    BvhWalk walk = bvh_begin(ray, t_max_1);
    BvhWalk walk_2 = bvh_begin(ray_2, t_max_2);
    bool is_first = walk.goes_on;
    is_blocked = false;
    if (!is_first) {
        ray = ray_2;
        walk = walk_2;
    }
    if (walk.goes_on) do {
        bvh_step(ray, walk);
        if (is_first && (!walk.goes_on || walk.hit.record >= 0)) {
            is_blocked = walk.hit.record >= 0;
            is_first = false;
            ray = ray_2;
            walk = walk_2;
        }
    } while (walk.goes_on);
    return walk.hit;
}

// Vertices of the triangle that was hit, in the order of its winding.
void bvh_triangle(BvhHit hit, out vec3 a, out vec3 b, out vec3 c)
{
    mat4x3 corners = bvh_corners(bvh_record(hit.record));
    a = corners[0];
    b = hit.is_second ? corners[2] : corners[1];
    c = hit.is_second ? corners[3] : corners[2];
}
