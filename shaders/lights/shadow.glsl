// How much of a light reaches a point, from the shadow atlas (passes/shadow_map.py).
//
// No depth is compared with a bias. Every stored depth is turned back into the surface
// point that it came from, at its texel's centre, and blocks only if that point lies
// above the receiver's tangent plane: a plane never shadows itself, at any slope.
//
// BLOCKER_COUNT, FILTER_COUNT: samples of the shadow of one part of a rectangle; parallel
// light with a spread takes several times as many, see below.
#include "lib/hash.glsl"
#include "lights/lights.glsl"

#ifndef GLOSSY
#define GLOSSY 0
#endif

uniform sampler2D t_shadow_atlas;
uniform float u_shadow_tile_texels;   // texels along one face
uniform uvec3 u_pattern_offset;       // from the frame's seed

const float SHADOW_BORDER_TEXELS = 2.0;  // BORDER_TEXELS of passes/shadow_map.py

// A blocker stands at least this much above the tangent plane, all added up:
// - the stored normal's own error, 6e-5 radians, times its distance, with a margin of 3;
const float SHADOW_NORMAL_SLACK = 2e-4;
// - rounding of positions in view and light space, relative to their size;
const float SHADOW_ROUNDING = 16.0 * FLOAT_EPSILON;
// - a quarter of a texel where the receiver is: below the map's resolution a curved
//   surface is not known well enough to shadow itself. (Ritschel et al. 2009 section 6.2
//   move the receiver by up to half a texel times the tangent of the slope instead.)
const float SHADOW_TEXEL_SLACK = 0.25;
// What is so much nearer to the light than its receiver, two texels, stands clear of it.
const float SHADOW_CLEAR_SLACKS = 8.0;

// The sample sequence of lib/hash.glsl, stepped in floats: a third of the integers' cost.
const vec3 KRONECKER_STEP = vec3(KRONECKER_ALPHA) / 4294967296.0;

struct ShadowMap {
    vec2 tile;            // of the first face, in tiles
    float span;           // of a face, in tiles
    int parts_per_side;   // of a rectangle, which divide each tile into squares
    float texels;         // along one such square
    int face_count;
    bool is_parallel;
    vec2 half_size;       // of a face, border included
    vec3 origin_vs;
    mat3 light_from_view;
};

ShadowMap shadow_map_from_rows(vec4 rows[LIGHT_ROWS])
{
    float texels = floor(u_shadow_tile_texels * rows[7].w / rows[0].z);
    vec2 half_size = vec2(rows[3].w, rows[4].w)
                   * (texels / (texels - 2.0 * SHADOW_BORDER_TEXELS));
    return ShadowMap(vec2(rows[5].w, rows[6].w), rows[7].w, int(rows[0].z), texels, int(rows[8].w),
                     light_form(int(rows[0].x)) == FORM_PARALLEL, half_size, rows[8].xyz,
                     transpose(mat3(rows[5].xyz, rows[6].xyz, rows[7].xyz)));
}

// Faces in the order +z, +x, -x, +y, -y, -z; axes as in graph/shadow_frames.py.
int face_of(vec3 q)
{
    vec3 a = abs(q);
    if (a.z >= a.x && a.z >= a.y) {
        return q.z >= 0.0 ? 0 : 5;
    }
    return a.x >= a.y ? (q.x >= 0.0 ? 1 : 2) : (q.y >= 0.0 ? 3 : 4);
}

// From the light's axes to a face's (u, v, depth).
vec3 face_from_light(int face, vec3 q)
{
    vec3 w = face == 0 || face == 5 ? q : (face <= 2 ? q.yzx : q.zxy);
    return face == 2 || face >= 4 ? vec3(w.xy, -w.z) : w;
}

// One face of a map, with what is needed to look a point up.
struct Face {
    vec2 corner;            // in the atlas, texels
    float texels;           // along its sides
    vec2 texel_from_slope;  // place on the face = slope * this + half a face
    vec2 slope_from_texel;
    bool is_parallel;
};

// The face of a map; of a rectangle, that of its first part, at the lower left of a tile.
Face face_at(ShadowMap map, int face)
{
    vec2 scale = 0.5 * map.texels / map.half_size;
    vec2 corner = (map.tile + vec2(float(face) * map.span, 0.0)) * u_shadow_tile_texels;
    return Face(corner, map.texels, scale, 1.0 / scale, map.is_parallel);
}

// Place of a point (u, v, depth) on the face, in texels from its corner.
vec2 face_place(Face face, vec3 w)
{
    vec2 slope = face.is_parallel ? w.xy : w.xy / w.z;
    return slope * face.texel_from_slope + 0.5 * face.texels;
}

// The surface point (u, v, depth) that is stored in texel `t` of the face.
vec3 face_point(Face face, vec2 t)
{
    vec2 inside = clamp(t, vec2(0.0), vec2(face.texels - 1.0));
    float depth = texelFetch(t_shadow_atlas, ivec2(face.corner + inside), 0).x;
    vec2 slope = (inside + 0.5 - 0.5 * face.texels) * face.slope_from_texel;
    return vec3(face.is_parallel ? slope : slope * depth, depth);
}

// Size of a texel at depth `depth`, scene units.
float face_texel_size(Face face, float depth)
{
    float size = max(face.slope_from_texel.x, face.slope_from_texel.y);
    return face.is_parallel ? size : size * depth;
}

// Whether a point at `offset` from the receiver lies above its tangent plane.
bool is_above_plane(vec3 offset, vec3 normal, float slack)
{
    // The sum is at most 1.73 times the length, and cheaper.
    vec3 a = abs(offset);
    return dot(offset, normal) > slack + SHADOW_NORMAL_SLACK * (a.x + a.y + a.z);
}

// A texel that a surface falls away from below the receiver's tangent plane says nothing
// about what stands before it. Unless it is this many texels nearer to the light: then
// that is another surface, over which light grazes the receiver.
const float SHADOW_FAR_TEXELS = 64.0;

// A light without size: the 3 x 3 nearest texels, weighted by a quadratic B-spline, which
// hides the texels' grid better than bilinear weights do.
// `far_texels`: SHADOW_FAR_TEXELS, or FLOAT_MAX for a point above the facets that it stands
// for, which are no other surface.
float point_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding, float far_texels)
{
    int number = map.face_count == 1 ? 0 : face_of(p_ls);
    vec3 p = face_from_light(number, p_ls);
    vec3 m = face_from_light(number, m_ls);
    Face face = face_at(map, number);
    float texel = face_texel_size(face, p.z);
    float slack = rounding + SHADOW_TEXEL_SLACK * texel;
    vec2 place = face_place(face, p);
    vec2 middle = floor(place);
    vec2 t = place - middle;
    mat3x2 weights = mat3x2(0.5 * (1.0 - t) * (1.0 - t), 0.75 - (t - 0.5) * (t - 0.5), 0.5 * t * t);
    float blocked = 0.0;
    float counted = 0.0;
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
            vec3 o = face_point(face, middle + vec2(float(i), float(j)) - 1.0);
            bool is_below = is_above_plane(p - o, m, slack);
            bool is_far = p.z - o.z > far_texels * texel;
            bool is_blocker = is_below ? is_far : o.z < p.z && is_above_plane(o - p, m, slack);
            float weight = weights[i].x * weights[j].y;
            counted += is_below && !is_far ? 0.0 : weight;
            blocked += is_blocker ? weight : 0.0;
        }
    }
    // Behind a spot, or off its only face: unlit anyway.
    bool is_seen = p.z > 0.0 && number < map.face_count;
    return is_seen && counted > 0.0 ? 1.0 - blocked / counted : 1.0;
}

#ifdef BLOCKER_COUNT
// Sum over the 2 x 2 pixels that are shaded together; without control flow around it.
// Where derivatives are coarse it is only near the sum, hence at least the pixel's own.
vec2 quad_sum(vec2 own, ivec2 pixel)
{
    vec2 toward = 1.0 - 2.0 * vec2(pixel & 1);
    vec2 row = 2.0 * own + toward.x * dFdx(own);
    return max(2.0 * row + toward.y * dFdy(row), own);
}

// One map has to do for the whole disk, so it is read as often as those of so many parts.
// What hides less than a twentieth of the disk may still be missed by the search.
const int DISK_SEARCH_PARTS = 16;
const int DISK_FILTER_PARTS = 8;

// Soft shadow of parallel light that strays by `spread`: search and filter as in
// part_visibility below. The map has the whole scene at one scale, so what stands a depth d
// nearer to the light blocks part of it within spread * d around the receiver.
float disk_shadow_visibility(ShadowMap map, vec3 p, vec3 m, float rounding, float spread,
                             ivec2 pixel, bool is_surface)
{
    Face face = face_at(map, 0);
    float texel = face_texel_size(face, p.z);
    float slack = rounding + SHADOW_TEXEL_SLACK * texel;
    const int search_count = DISK_SEARCH_PARTS * BLOCKER_COUNT;
    const int filter_count = DISK_FILTER_PARTS * FILTER_COUNT;
    const int stretch = search_count > filter_count ? search_count : filter_count;
    vec3 start = kronecker_point(set_of_pixel(pixel) * uint(stretch), u_pattern_offset);
    vec2 blockers = vec2(0.0);  // sum of their heights over the receiver, number
    int search_rounds = is_surface ? search_count : 0;
    for (int i = 0; i < search_rounds; ++i) {
        vec3 r = fract(start + float(i) * KRONECKER_STEP);
        float reach = max(r.z * p.z, 0.0);
        vec2 q = p.xy + reach * disk_point(spread, r.xy);
        vec3 offset = face_point(face, floor(face_place(face, vec3(q, p.z)))) - p;
        bool is_blocker = offset.z < 0.0 && length(offset.xy) <= texel - spread * offset.z
            && is_above_plane(offset, m, slack);
        blockers += is_blocker ? vec2(-offset.z, 1.0) : vec2(0.0);
    }
    // Four pixels search together, as for rectangles.
    blockers = quad_sum(blockers, pixel);

    int filter_rounds = is_surface && blockers.y > 0.0 ? filter_count : 0;
    // No narrower than a texel, whose grid would show.
    float height = max(blockers.x / max(blockers.y, 1.0), texel / spread);
    float open = 0.0;
    float total = 0.0;
    for (int i = 0; i < filter_rounds; ++i) {
        vec2 d = disk_point(spread, fract(start + float(i) * KRONECKER_STEP).xy);
        vec3 q = vec3(p.xy + height * d, p.z);
        vec3 offset = face_point(face, floor(face_place(face, q))) - p;
        bool is_blocker = offset.z < 0.0 && is_above_plane(offset, m, slack);
        // Light from below the horizon brings nothing.
        float weight = max(dot(vec3(d, -1.0), m), 0.0);
        total += weight;
        open += is_blocker ? 0.0 : weight;
    }
    return total > 0.0 ? open / total : 1.0;
}

// What a part of a rectangle contributes to a receiver at the origin, up to a constant:
// cos cos / distance^2. `height` is the receiver's over the light, as a unit.
float part_weight(vec3 to_light, vec3 normal, float height)
{
    vec3 d = to_light / height;
    return max(dot(normal, d), 0.0) / (dot(d, d) * dot(d, d));
}

// A rectangle light and a receiver, in the axes of the face that the receiver falls on;
// the dark side of a two-sided light is a mirror image. Edges are those of one part.
struct SoftShadow {
    vec3 p;        // receiver, relative to the light's centre
    vec3 m;        // its geometric normal
    vec3 axis;     // from the light towards the receiver's side
    vec3 half_u;
    vec3 half_v;
    vec3 dual_u;   // dot products with these are coordinates on the part, -1..1
    vec3 dual_v;
    float height;  // of the receiver over the light
    float slack;   // height above its tangent plane from which something blocks
    vec2 texel;    // half of a texel at depth 1, in coordinates on the part
};

SoftShadow soft_shadow(ShadowMap map, int face, vec3 p_ls, vec3 m_ls, float rounding,
                       vec2 half_u, vec2 half_v)
{
    float side = p_ls.z < 0.0 ? -1.0 : 1.0;
    vec2 dual = vec2(1.0) / (half_u.x * half_v.y - half_u.y * half_v.x);
    vec3 p = face_from_light(face, p_ls);
    float texel = 2.0 * max(map.half_size.x, map.half_size.y) / map.texels;
    vec3 dual_u = face_from_light(face, vec3(vec2(half_v.y, -half_v.x) * dual, 0.0));
    vec3 dual_v = face_from_light(face, vec3(vec2(-half_u.y, half_u.x) * dual, 0.0));
    vec2 across = vec2(abs(dual_u.x) + abs(dual_u.y), abs(dual_v.x) + abs(dual_v.y));
    return SoftShadow(p, face_from_light(face, m_ls),
                      face_from_light(face, vec3(0.0, 0.0, side)),
                      face_from_light(face, vec3(half_u, 0.0)),
                      face_from_light(face, vec3(half_v, 0.0)), dual_u, dual_v,
                      p_ls.z * side, rounding + SHADOW_TEXEL_SLACK * texel * p.z,
                      0.5 * texel * across);
}

// A lobe may see little of a part: more of the way there is searched, and what passes beside it
// by this share of half of the part counts, because searched texels lie before or behind.
const int LOBE_SEARCH_COUNT = 8;
const float LEAST_SHAFT = 0.15;

// What stands before the points from `low` to `high` of a part, seen from p: sum of the fractions
// of the way at which it does, and how often it was met.
vec2 blockers_of(SoftShadow shadow, Face face, vec3 p, vec2 low, vec2 high, vec3 start, int rounds)
{
    vec2 p_on_part = vec2(dot(p, shadow.dual_u), dot(p, shadow.dual_v));
    vec2 middle = 0.5 * (low + high);
    vec2 blockers = vec2(0.0);
    for (int i = 0; i < rounds; ++i) {
        vec3 r = fract(start + float(i) * KRONECKER_STEP);
        vec2 y = low + r.xy * (high - low);
        // Squared: what touches the receiver covers few texels, near its own.
        float s = (r.z * 2.0 - 1.0) * (r.z * 2.0 - 1.0);
        vec3 q = p + s * (y.x * shadow.half_u + y.y * shadow.half_v - p);
        vec3 offset = face_point(face, floor(face_place(face, q))) - p;
        // The line from the receiver through the stored point meets the light's plane.
        float rise = -dot(offset, shadow.axis);
        float reach = shadow.height / max(rise, 1e-6 * shadow.height);
        vec2 hit = p_on_part + reach * vec2(dot(offset, shadow.dual_u), dot(offset, shadow.dual_v));
        // The shaft to a small light fits in between the centres of texels: there any texel
        // that it passes through is in its way. Close to the receiver its neighbours are.
        bool is_clear = rise > SHADOW_CLEAR_SLACKS * shadow.slack;
        vec2 narrowest = is_clear ? reach * q.z * shadow.texel : vec2(0.0);
        vec2 shaft = max(max(0.5 * (high - low), LEAST_SHAFT), narrowest);
        bool is_blocker = q.z > 0.0 && rise > 0.0 && all(lessThanEqual(abs(hit - middle), shaft))
            && is_above_plane(offset, shadow.m, shadow.slack);
        blockers += is_blocker ? vec2(rise / shadow.height, 1.0) : vec2(0.0);
    }
    return blockers;
}

// Whether something blocks the segment `to_light` from p at about the fraction s of it.
bool is_blocked_at(SoftShadow shadow, Face face, vec3 p, vec3 to_light, float s)
{
    vec3 q = p + s * to_light;
    vec3 offset = face_point(face, floor(face_place(face, q))) - p;
    return q.z > 0.0 && dot(offset, shadow.axis) < 0.0
        && is_above_plane(offset, shadow.m, shadow.slack);
}

// Soft shadow of one part of the light, whose centre is at `centre`, from its own map:
// percentage-closer soft shadows (Fernando 2005) in which search and filter work on the
// light's points themselves instead of on circles in the map. The segment from the
// receiver p to the light's point y passes p + s (y - p); seen from the part's centre its
// texels hold what may block it. Loops of no rounds skip pixels without a surface:
// branches would not, in software, nor may derivatives be inside.
float part_visibility(SoftShadow shadow, Face face, vec3 centre, vec3 start, ivec2 pixel,
                      bool is_surface)
{
    vec3 p = shadow.p - centre;
    vec2 blockers = blockers_of(
        shadow, face, p, vec2(-1.0), vec2(1.0), start, is_surface ? BLOCKER_COUNT : 0);
    // Four pixels search together: a third less error in penumbrae, for nothing.
    blockers = quad_sum(blockers, pixel);

    int filter_rounds = is_surface && blockers.y > 0.0 ? FILTER_COUNT : 0;
    float s = blockers.x / max(blockers.y, 1.0);
    float open = 0.0;
    float total = 0.0;
    for (int i = 0; i < filter_rounds; ++i) {
        vec3 r = fract(start + float(i) * KRONECKER_STEP) * 2.0 - 1.0;
        vec3 to_light = r.x * shadow.half_u + r.y * shadow.half_v - p;
        float weight = part_weight(to_light, shadow.m, shadow.height);
        total += weight;
        open += is_blocked_at(shadow, face, p, to_light, s) ? 0.0 : weight;
    }
    return total > 0.0 ? open / total : 1.0;
}

#if GLOSSY
// The share of the points from `low` to `high`, which a lobe sees, that nothing blocks.
float part_visibility_to_lobe(SoftShadow shadow, Face face, vec3 centre, vec3 start, ivec2 pixel,
                              bool is_glossy, vec2 low, vec2 high)
{
    vec3 p = shadow.p - centre;
    vec2 blockers =
        blockers_of(shadow, face, p, low, high, start, is_glossy ? LOBE_SEARCH_COUNT : 0);
    blockers = quad_sum(blockers, pixel);
    int filter_rounds = is_glossy && blockers.y > 0.0 ? FILTER_COUNT : 0;
    float s = blockers.x / max(blockers.y, 1.0);
    float open = filter_rounds > 0 ? 0.0 : 1.0;
    for (int i = 0; i < filter_rounds; ++i) {
        vec2 y = low + fract(start + float(i) * KRONECKER_STEP).xy * (high - low);
        vec3 to_light = y.x * shadow.half_u + y.y * shadow.half_v - p;
        open += is_blocked_at(shadow, face, p, to_light, s) ? 0.0 : 1.0 / float(FILTER_COUNT);
    }
    return open;
}
#endif

// Soft shadow of a rectangle: its parts, weighted by what each contributes. `seen_by_lobe`: low
// and high corner of what a lobe sees of it, from -1 to 1 along its edges; y of the result.
vec2 area_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding,
                            vec2 half_u, vec2 half_v, ivec2 pixel, bool is_surface,
                            bool is_glossy, vec4 seen_by_lobe)
{
    float inverse = 1.0 / float(map.parts_per_side);
    int number = face_of(p_ls);
    SoftShadow shadow =
        soft_shadow(map, number, p_ls, m_ls, rounding, half_u * inverse, half_v * inverse);
    Face face = face_at(map, number);
    vec2 first_corner = face.corner;
    // Each pixel of a block has its own stretch of the sequence, each part its own block.
    const int stretch = BLOCKER_COUNT > FILTER_COUNT ? BLOCKER_COUNT : FILTER_COUNT;
    vec3 start = kronecker_point(set_of_pixel(pixel) * uint(stretch), u_pattern_offset);
    vec2 open = vec2(0.0);
    vec2 total = vec2(0.0);
    for (int j = 0; j < map.parts_per_side; ++j) {
        for (int i = 0; i < map.parts_per_side; ++i) {
            vec2 part = vec2(float(i), float(j));
            vec2 place = part * 2.0 + 1.0 - float(map.parts_per_side);
            vec3 centre = place.x * shadow.half_u + place.y * shadow.half_v;
            face.corner = first_corner + part * map.texels;
            float weight = part_weight(centre - shadow.p, shadow.m, shadow.height);
            open.x += weight * part_visibility(shadow, face, centre, start, pixel, is_surface);
            total.x += weight;
#if GLOSSY
            vec4 seen = clamp(seen_by_lobe * float(map.parts_per_side) - place.xyxy, -1.0, 1.0);
            float area = (seen.z - seen.x) * (seen.w - seen.y);
            open.y += area * part_visibility_to_lobe(
                shadow, face, centre, start, pixel, is_glossy && area > 0.0, seen.xy, seen.zw);
            total.y += area;
#endif
            start = fract(start + float(BLOCK_SIZE * BLOCK_SIZE * stretch) * KRONECKER_STEP);
        }
    }
    return mix(vec2(1.0), open / max(total, 1e-30), greaterThan(total, vec2(0.0)));
}
#endif
