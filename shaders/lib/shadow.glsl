// How much of a light reaches a point, from the shadow atlas (passes/shadow_map.py).
//
// No depth is compared with a bias. Every stored depth is turned back into the surface
// point that it came from, at its texel's centre, and blocks only if that point lies
// above the receiver's tangent plane: a plane never shadows itself, at any slope.
//
// BLOCKER_COUNT, FILTER_COUNT: samples of a rectangle light's shadow.
#include "lib/hash.glsl"
#include "lib/lights.glsl"

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

// The sample sequence of lib/hash.glsl, stepped in floats: a third of the integers' cost.
const vec3 KRONECKER_STEP = vec3(KRONECKER_ALPHA) / 4294967296.0;

struct ShadowMap {
    vec2 tile;            // of the first face, in tiles
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
    float texels = u_shadow_tile_texels * rows[7].w / rows[0].z;
    vec2 half_size = vec2(rows[3].w, rows[4].w)
                   * (texels / (texels - 2.0 * SHADOW_BORDER_TEXELS));
    return ShadowMap(vec2(rows[5].w, rows[6].w), int(rows[0].z), texels, int(rows[8].w),
                     int(rows[0].x) == LIGHT_DIRECTIONAL, half_size, rows[8].xyz,
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

Face face_at(ShadowMap map, int face, ivec2 part)
{
    vec2 scale = 0.5 * map.texels / map.half_size;
    // A face of several tiles is the only one; a tile of several parts has parts_per_side^2.
    vec2 corner = (map.tile + vec2(float(face), 0.0)) * u_shadow_tile_texels;
    return Face(corner + vec2(part) * map.texels, map.texels, scale, 1.0 / scale, map.is_parallel);
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
float point_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding)
{
    int number = map.face_count == 1 ? 0 : face_of(p_ls);
    vec3 p = face_from_light(number, p_ls);
    vec3 m = face_from_light(number, m_ls);
    Face face = face_at(map, number, ivec2(0));
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
            bool is_far = p.z - o.z > SHADOW_FAR_TEXELS * texel;
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
// What a part of a rectangle contributes to a receiver at the origin, up to a constant:
// cos cos / distance^2. `height` is the receiver's over the light, as a unit.
float part_weight(vec3 to_light, vec3 normal, float height)
{
    vec3 d = to_light / height;
    return max(dot(normal, d), 0.0) / (dot(d, d) * dot(d, d));
}

// Sum over the 2 x 2 pixels that are shaded together; without control flow around it.
// Where derivatives are coarse it is only near the sum, hence at least the pixel's own.
vec2 quad_sum(vec2 own, ivec2 pixel)
{
    vec2 toward = 1.0 - 2.0 * vec2(pixel & 1);
    vec2 row = 2.0 * own + toward.x * dFdx(own);
    return max(2.0 * row + toward.y * dFdy(row), own);
}

// Soft shadow of one part of a rectangle, given by its centre and half edges, from its
// own map: percentage-closer soft shadows (Fernando 2005) in which search and filter work
// on the light's points themselves instead of on circles in the map. The segment from the
// receiver p to the light's point y passes p + s (y - p); seen from the part's centre its
// texels hold what may block it. `p` is relative to that centre. Loops of no rounds skip
// pixels without a surface: branches would not, in software, nor may derivatives be inside.
float part_visibility(ShadowMap map, ivec2 part, vec3 p_ls, vec3 m_ls, float rounding,
                      vec2 half_u, vec2 half_v, ivec2 pixel, bool is_surface)
{
    // Everything in the axes of the face that the receiver falls on; the dark side of a
    // two-sided light is a mirror image.
    int number = face_of(p_ls);
    float side = p_ls.z < 0.0 ? -1.0 : 1.0;
    float determinant = half_u.x * half_v.y - half_u.y * half_v.x;
    vec3 p = face_from_light(number, p_ls);
    vec3 m = face_from_light(number, m_ls);
    vec3 axis = face_from_light(number, vec3(0.0, 0.0, side));
    vec3 u = face_from_light(number, vec3(half_u, 0.0));
    vec3 v = face_from_light(number, vec3(half_v, 0.0));
    // Dual to u and v: dot products with these are coordinates on the light, -1..1.
    vec3 dual_u = face_from_light(number, vec3(half_v.y, -half_v.x, 0.0)) / determinant;
    vec3 dual_v = face_from_light(number, vec3(-half_u.y, half_u.x, 0.0)) / determinant;
    vec2 p_on_light = vec2(dot(p, dual_u), dot(p, dual_v));
    float height = dot(p, axis);
    Face face = face_at(map, number, part);
    float slack = rounding + SHADOW_TEXEL_SLACK * face_texel_size(face, p.z);

    vec2 blockers = vec2(0.0);  // sum of their s, number
    int blocker_rounds = is_surface ? BLOCKER_COUNT : 0;
    // Another stretch of the sequence for each pixel of a block and each part.
    uint set = uint((part.y * map.parts_per_side + part.x) * BLOCK_SIZE * BLOCK_SIZE)
             + set_of_pixel(pixel);
    vec3 start = kronecker_point(set * uint(BLOCKER_COUNT), u_pattern_offset);
    for (int i = 0; i < blocker_rounds; ++i) {
        vec3 r = fract(start + float(i) * KRONECKER_STEP);
        // Squared: what touches the receiver covers few texels, near its own.
        float s = r.z * r.z;
        vec3 q = p + s * ((2.0 * r.x - 1.0) * u + (2.0 * r.y - 1.0) * v - p);
        vec3 offset = face_point(face, floor(face_place(face, q))) - p;
        // The line from the receiver through the stored point meets the light's plane.
        float rise = -dot(offset, axis);
        vec2 hit = p_on_light + height / max(rise, 1e-6 * height)
                              * vec2(dot(offset, dual_u), dot(offset, dual_v));
        bool is_blocker = q.z > 0.0 && rise > 0.0
            && max(abs(hit.x), abs(hit.y)) <= 1.0 && is_above_plane(offset, m, slack);
        blockers += is_blocker ? vec2(rise / height, 1.0) : vec2(0.0);
    }
    // Four pixels search together: a third less error in penumbrae, for nothing.
    blockers = quad_sum(blockers, pixel);

    int filter_rounds = is_surface && blockers.y > 0.0 ? FILTER_COUNT : 0;
    float s = blockers.x / max(blockers.y, 1.0);
    float open = 0.0;
    float total = 0.0;
    start = kronecker_point(set * uint(FILTER_COUNT), u_pattern_offset);
    for (int i = 0; i < filter_rounds; ++i) {
        vec3 r = fract(start + float(i) * KRONECKER_STEP);
        vec3 to_light = (2.0 * r.x - 1.0) * u + (2.0 * r.y - 1.0) * v - p;
        vec3 q = p + s * to_light;
        vec3 offset = face_point(face, floor(face_place(face, q))) - p;
        float rise = -dot(offset, axis);
        bool is_blocker = q.z > 0.0 && rise > 0.0
            && is_above_plane(offset, m, slack);
        float weight = part_weight(to_light, m, height);
        total += weight;
        open += is_blocker ? 0.0 : weight;
    }
    return total > 0.0 ? open / total : 1.0;
}

// Soft shadow of a rectangle: its parts, weighted by what each contributes.
float rectangle_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding,
                                  vec2 half_u, vec2 half_v, ivec2 pixel, bool is_surface)
{
    float inverse = 1.0 / float(map.parts_per_side);
    float open = 0.0;
    float total = 0.0;
    for (int j = 0; j < map.parts_per_side; ++j) {
        for (int i = 0; i < map.parts_per_side; ++i) {
            vec2 place = (vec2(float(i), float(j)) * 2.0 + 1.0) * inverse - 1.0;
            vec3 p = p_ls - vec3(place.x * half_u + place.y * half_v, 0.0);
            float weight = part_weight(-p, m_ls, abs(p.z));
            open += weight * part_visibility(map, ivec2(i, j), p, m_ls, rounding,
                                             half_u * inverse, half_v * inverse, pixel,
                                             is_surface);
            total += weight;
        }
    }
    return total > 0.0 ? open / total : 1.0;
}
#endif
