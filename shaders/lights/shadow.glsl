// How much of a light reaches a point, from the shadow atlas (passes/shadow_map.py).
//
// No depth is compared with a bias. Every stored depth is turned back into the surface
// point that it came from, at its texel's centre, and blocks only if that point lies
// above the receiver's tangent plane: a plane never shadows itself, at any slope.
//
// LIGHT_FORM: as in lights/lights.glsl. BLOCKER_COUNT, FILTER_COUNT: samples of the shadow of
// one part of a rectangle; parallel light with a spread takes many times as many, see below.
// Rectangles: lights/area_shadow.glsl.
// IN_QUADS (default 0): 1 where the atlas is read from a copy of it, passes/quads.frag.
#include "lib/hash.glsl"
#include "lights/lights.glsl"

// HAS_WHOLE_MAP (default 0): 1 where the atlas without what is translucent may be asked, too.
#ifndef IN_QUADS
#define IN_QUADS 0
#endif
#ifndef HAS_WHOLE_MAP
#define HAS_WHOLE_MAP 0
#endif

#if IN_QUADS
uniform sampler2D t_shadow_quads;
#else
uniform sampler2D t_shadow_atlas;
#endif
#if HAS_WHOLE_MAP
uniform sampler2D t_whole_shadow_atlas;
#endif
uniform float u_shadow_tile_texels;   // texels along one face
uniform uvec3 u_pattern_offset;       // from the frame's seed
// From the frame's number: with each, a pixel takes the set of another pixel of its block.
// After four, all quarters of a block have looked alike; else they would stand out as a grid.
uniform int u_pattern_turn;

// Where a pixel's points begin, of which each takes `stretch`.
vec3 first_random(ivec2 pixel, int stretch)
{
    uint set = set_of_pixel(pixel) ^ uint(u_pattern_turn);
    return kronecker_point(set * uint(stretch), u_pattern_offset);
}

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
// A texel that holds a surface above the plane by more than this part of a texel, which blocks
// nothing, says nothing: where walls join it would let light into dark rooms.
const float SHADOW_SAME_PLANE = 0.02;
// What is so much nearer to the light than its receiver, two texels, stands clear of it.
const float SHADOW_CLEAR_SLACKS = 8.0;

const bool IS_PARALLEL = LIGHT_FORM == FORM_PARALLEL;

// Half of what the light measures along a unit vector.
float half_extent_along(Light light, vec3 w)
{
    bool has_area = LIGHT_FORM == FORM_AREA;
    return has_area ? abs(dot(light.axis_vs, w)) + abs(dot(light.second_axis_vs, w)) : 0.0;
}

struct ShadowMap {
    vec2 tile;            // of the first face, in tiles
    float span;           // of a face, in tiles
    int parts_per_side;   // of a rectangle, which divide each tile into squares
    float texels;         // along one such square
    int face_count;
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
                     half_size, rows[8].xyz,
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
};

// The face of a map; of a rectangle, that of its first part, at the lower left of a tile.
Face face_at(ShadowMap map, int face)
{
    vec2 scale = 0.5 * map.texels / map.half_size;
    vec2 corner = (map.tile + vec2(float(face) * map.span, 0.0)) * u_shadow_tile_texels;
    return Face(corner, map.texels, scale, 1.0 / scale);
}

// Place of a point (u, v, depth) on the face, in texels from its corner.
vec2 face_place(Face face, vec3 w)
{
    vec2 slope = IS_PARALLEL ? w.xy : w.xy / w.z;
    return slope * face.texel_from_slope + 0.5 * face.texels;
}

// The surface point (u, v, depth) at the centre of texel `t` of the face.
vec3 stored_point(Face face, vec2 t, float depth)
{
    vec2 slope = (t + 0.5 - 0.5 * face.texels) * face.slope_from_texel;
    return vec3(IS_PARALLEL ? slope : slope * depth, depth);
}

// Of a texel of the atlas.
float stored_depth(ivec2 texel)
{
#if IN_QUADS
    vec4 quad = texelFetch(t_shadow_quads, texel >> 1, 0);
    vec2 row = (texel.y & 1) == 0 ? quad.xy : quad.zw;
    return (texel.x & 1) == 0 ? row.x : row.y;
#else
    return texelFetch(t_shadow_atlas, texel, 0).x;
#endif
}

// The one that is stored in texel `t`.
vec3 face_point(Face face, vec2 t)
{
    vec2 inside = clamp(t, vec2(0.0), vec2(face.texels - 1.0));
    float depth = stored_depth(ivec2(face.corner + inside));
    return stored_point(face, inside, depth);
}

// What is stored in the 3 x 3 texels of the atlas from `corner` on, row by row; of what is `whole`
// alone, or of all.
mat3 stored_around(vec2 corner, bool whole)
{
#if HAS_WHOLE_MAP
    if (whole) {
        mat3 alone;
        for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 3; ++i) {
                alone[j][i] = texelFetch(t_whole_shadow_atlas, ivec2(corner) + ivec2(i, j), 0).x;
            }
        }
        return alone;
    }
#endif
#if IN_QUADS
    ivec2 first = ivec2(corner);
    ivec2 quad = first >> 1;
    vec4 a = texelFetch(t_shadow_quads, quad, 0);
    vec4 b = texelFetch(t_shadow_quads, quad + ivec2(1, 0), 0);
    vec4 c = texelFetch(t_shadow_quads, quad + ivec2(0, 1), 0);
    vec4 d = texelFetch(t_shadow_quads, quad + 1, 0);
    bool is_odd = (first.x & 1) == 1;
    vec3 row_0 = is_odd ? vec3(a.y, b.xy) : vec3(a.xy, b.x);
    vec3 row_1 = is_odd ? vec3(a.w, b.zw) : vec3(a.zw, b.z);
    vec3 row_2 = is_odd ? vec3(c.y, d.xy) : vec3(c.xy, d.x);
    vec3 row_3 = is_odd ? vec3(c.w, d.zw) : vec3(c.zw, d.z);
    return (first.y & 1) == 1 ? mat3(row_1, row_2, row_3) : mat3(row_0, row_1, row_2);
#else
    mat3 stored;
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
            stored[j][i] = stored_depth(ivec2(corner) + ivec2(i, j));
        }
    }
    return stored;
#endif
}

// Size of a texel at depth `depth`, scene units.
float face_texel_size(Face face, float depth)
{
    float size = max(face.slope_from_texel.x, face.slope_from_texel.y);
    return IS_PARALLEL ? size : size * depth;
}

// How far above the receiver's tangent plane a point at `offset` from it blocks.
float least_height(vec3 offset, float slack)
{
    // The sum is at most 1.73 times the length, and cheaper.
    vec3 a = abs(offset);
    return slack + SHADOW_NORMAL_SLACK * (a.x + a.y + a.z);
}

bool is_above_plane(vec3 offset, vec3 normal, float slack)
{
    return dot(offset, normal) > least_height(offset, slack);
}

// A texel that a surface falls away from below the receiver's tangent plane says nothing
// about what stands before it. Unless it is this many texels nearer to the light: then
// that is another surface, over which light grazes the receiver.
const float SHADOW_FAR_TEXELS = 64.0;

// A light without size: the 3 x 3 nearest texels, weighted by a quadratic B-spline, which
// hides the texels' grid better than bilinear weights do.
// `far_texels`: SHADOW_FAR_TEXELS, or FLOAT_MAX for a point above the facets that it stands
// for, which are no other surface. `whole`: as in stored_around.
float point_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding, float far_texels,
                              bool whole)
{
    int number = map.face_count == 1 ? 0 : face_of(p_ls);
    vec3 p = face_from_light(number, p_ls);
    vec3 m = face_from_light(number, m_ls);
    Face face = face_at(map, number);
    float texel = face_texel_size(face, p.z);
    float slack = rounding + SHADOW_TEXEL_SLACK * texel;
    float above = (SHADOW_TEXEL_SLACK - SHADOW_SAME_PLANE) * texel;
    vec2 place = face_place(face, p);
    vec2 middle = floor(place);
    vec2 t = place - middle;
    mat3x2 weights = mat3x2(0.5 * (1.0 - t) * (1.0 - t), 0.75 - (t - 0.5) * (t - 0.5), 0.5 * t * t);
    vec2 first = clamp(middle - 1.0, vec2(0.0), vec2(face.texels - 3.0));
    mat3 depths = stored_around(face.corner + first, whole);
    float blocked = 0.0;
    float counted = 0.0;
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
            vec3 offset = stored_point(face, first + vec2(float(i), float(j)), depths[j][i]) - p;
            float height = dot(offset, m);
            float least = least_height(offset, slack);
            bool is_below = -height > least;
            bool is_far = -offset.z > far_texels * texel;
            bool is_blocker = is_below ? is_far : offset.z < 0.0 && height > least;
            float weight = weights[i].x * weights[j].y;
            bool is_off_plane = is_below || height > least - above;
            counted += is_off_plane && !is_blocker ? 0.0 : weight;
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
vec4 quad_sum(vec4 own, ivec2 pixel)
{
    vec2 toward = 1.0 - 2.0 * vec2(pixel & 1);
    vec4 row = 2.0 * own + toward.x * dFdx(own);
    return max(2.0 * row + toward.y * dFdy(row), own);
}

// One map has to do for the whole disk, so it is read as often as those of so many parts.
// What hides less than a twentieth of the disk may still be missed by the search.
const int DISK_SEARCH_PARTS = 24;
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
    float above = (SHADOW_TEXEL_SLACK - SHADOW_SAME_PLANE) * texel;
    const int search_count = DISK_SEARCH_PARTS * BLOCKER_COUNT;
    const int filter_count = DISK_FILTER_PARTS * FILTER_COUNT;
    const int stretch = search_count > filter_count ? search_count : filter_count;
    vec3 start = first_random(pixel, stretch);
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
    blockers = quad_sum(vec4(blockers, 0.0, 0.0), pixel).xy;

    int filter_rounds = is_surface && blockers.y > 0.0 ? filter_count : 0;
    // No narrower than a texel, whose grid would show.
    float height = max(blockers.x / max(blockers.y, 1.0), texel / spread);
    float open = 0.0;
    float total = 0.0;
    for (int i = 0; i < filter_rounds; ++i) {
        vec2 d = disk_point(spread, fract(start + float(i) * KRONECKER_STEP).xy);
        vec3 q = vec3(p.xy + height * d, p.z);
        vec3 offset = face_point(face, floor(face_place(face, q))) - p;
        float rise = dot(offset, m) - least_height(offset, slack);
        bool is_blocker = offset.z < 0.0 && rise > 0.0;
        bool is_joint = rise > -above && rise <= 0.0;
        // Light from below the horizon brings nothing.
        float weight = is_joint ? 0.0 : max(dot(vec3(d, -1.0), m), 0.0);
        total += weight;
        open += is_blocker ? 0.0 : weight;
    }
    return total > 0.0 ? open / total : 1.0;
}
#endif
