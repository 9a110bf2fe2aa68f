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
uniform int u_shadow_columns;     // tiles per row of the atlas
uniform uvec3 u_pattern_offset;   // from the frame's seed

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

struct ShadowMap {
    int first_tile;
    int face_count;
    bool is_parallel;
    vec2 half_size;       // of a face, border included
    vec3 origin_vs;
    mat3 light_from_view;
    float tile_texels;
};

// A point seen from a light: the face it falls on, and its place there.
struct FacePoint {
    int face;
    vec3 position;  // (u, v, depth along the face's axis)
};

ShadowMap shadow_map_of(int light)
{
    ShadowMap map;
    vec4 head = texelFetch(t_lights, ivec2(0, light), 0);
    vec4 row_x = texelFetch(t_lights, ivec2(5, light), 0);
    vec4 row_y = texelFetch(t_lights, ivec2(6, light), 0);
    vec4 row_z = texelFetch(t_lights, ivec2(7, light), 0);
    vec4 origin = texelFetch(t_lights, ivec2(8, light), 0);
    map.first_tile = int(head.z);
    map.face_count = int(origin.w);
    map.is_parallel = row_x.w > 0.5;
    map.tile_texels = float(textureSize(t_shadow_atlas, 0).x / u_shadow_columns);
    map.half_size = vec2(texelFetch(t_lights, ivec2(3, light), 0).w,
                         texelFetch(t_lights, ivec2(4, light), 0).w)
                  * (map.tile_texels / (map.tile_texels - 2.0 * SHADOW_BORDER_TEXELS));
    map.origin_vs = origin.xyz;
    map.light_from_view = transpose(mat3(row_x.xyz, row_y.xyz, row_z.xyz));
    return map;
}

// Faces in the order +z, +x, -x, +y, -y, -z; axes as in graph/shadow_frames.py.
vec3 face_from_light(int face, vec3 q)
{
    vec3 w = face == 0 || face == 5 ? q : (face <= 2 ? q.yzx : q.zxy);
    return face == 2 || face >= 4 ? vec3(w.xy, -w.z) : w;
}

vec3 light_from_face(int face, vec3 w)
{
    vec3 s = face == 2 || face >= 4 ? vec3(w.xy, -w.z) : w;
    return face == 0 || face == 5 ? s : (face <= 2 ? s.zxy : s.yzx);
}

int face_of(ShadowMap map, vec3 q)
{
    if (map.face_count == 1) {
        return 0;
    }
    vec3 a = abs(q);
    if (a.z >= a.x && a.z >= a.y) {
        return q.z >= 0.0 ? 0 : 5;
    }
    return a.x >= a.y ? (q.x >= 0.0 ? 1 : 2) : (q.y >= 0.0 ? 3 : 4);
}

// Place on its tile, in texels from the tile's corner.
vec2 tile_place(ShadowMap map, vec3 w)
{
    vec2 slope = map.is_parallel ? w.xy : w.xy / w.z;
    return (slope / map.half_size * 0.5 + 0.5) * map.tile_texels;
}

// The surface point, in the face's axes, that is stored in a texel of a tile.
vec3 stored_point(ShadowMap map, int face, ivec2 texel)
{
    int tile = map.first_tile + face;
    ivec2 corner = ivec2(tile % u_shadow_columns, tile / u_shadow_columns) * int(map.tile_texels);
    float depth = texelFetch(t_shadow_atlas, corner + texel, 0).x;
    vec2 slope = ((vec2(texel) + 0.5) / map.tile_texels * 2.0 - 1.0) * map.half_size;
    return vec3(map.is_parallel ? slope : slope * depth, depth);
}

// Height above the receiver's tangent plane from which a point blocks.
float blocking_height(float texel_slack, float rounding, vec3 offset)
{
    return texel_slack + rounding + SHADOW_NORMAL_SLACK * length(offset);
}

// Size of a texel of the map at depth `depth`, scene units.
float texel_size(ShadowMap map, float depth)
{
    float size = 2.0 * max(map.half_size.x, map.half_size.y) / map.tile_texels;
    return map.is_parallel ? size : size * depth;
}

// A light without size: the 2 x 2 nearest texels, weighted as in bilinear filtering.
float point_light_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding)
{
    int face = face_of(map, p_ls);
    vec3 p = face_from_light(face, p_ls);
    vec3 m = face_from_light(face, m_ls);
    if (p.z <= 0.0 || face >= map.face_count) {
        return 1.0;  // behind a spot: unlit anyway
    }
    float texel_slack = SHADOW_TEXEL_SLACK * texel_size(map, p.z);
    vec2 place = tile_place(map, p) - 0.5;
    ivec2 low = ivec2(floor(place));
    vec2 t = place - vec2(low);
    int last = int(map.tile_texels) - 1;
    float blocked = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec3 o = stored_point(map, face, clamp(low + step, ivec2(0), ivec2(last)));
        bool is_blocker = o.z < p.z && dot(m, o - p) > blocking_height(texel_slack, rounding, o - p);
        vec2 weight = mix(1.0 - t, t, vec2(step));
        blocked += is_blocker ? weight.x * weight.y : 0.0;
    }
    return 1.0 - blocked;
}

// Soft shadow of a rectangle: percentage-closer soft shadows (Fernando 2005) in which
// search and filter work on the light's points themselves instead of on circles in the
// map. The segment from the receiver p to the light's point y passes p + s (y - p); seen
// from the light's centre its texels hold what may block it.
float rectangle_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding,
                           vec2 half_u, vec2 half_v, ivec2 pixel)
{
    // The dark side of a two-sided light is a mirror image.
    float side = p_ls.z < 0.0 ? -1.0 : 1.0;
    float height = p_ls.z * side;
    float texel_slack = SHADOW_TEXEL_SLACK * texel_size(map, largest_component(p_ls));
    // Inverse of (a, b) -> a half_u + b half_v.
    float determinant = half_u.x * half_v.y - half_u.y * half_v.x;
    vec2 dual_u = vec2(half_v.y, -half_v.x) / determinant;
    vec2 dual_v = vec2(-half_u.y, half_u.x) / determinant;
    int last = int(map.tile_texels) - 1;

    float blocker_sum = 0.0;
    float blocker_count = 0.0;
    uint first = set_of_pixel(pixel) * uint(BLOCKER_COUNT);
    for (int i = 0; i < BLOCKER_COUNT; ++i) {
        vec3 u = kronecker_point(first + uint(i), u_pattern_offset);
        vec2 y = (2.0 * u.x - 1.0) * half_u + (2.0 * u.y - 1.0) * half_v;
        // Squared: what touches the receiver covers few texels, near its own.
        float s = u.z * u.z;
        vec3 q = p_ls + s * (vec3(y, 0.0) - p_ls);
        int face = face_of(map, q);
        vec3 w = face_from_light(face, q);
        ivec2 texel = clamp(ivec2(floor(tile_place(map, w))), ivec2(0), ivec2(last));
        vec3 o = light_from_face(face, stored_point(map, face, texel));
        float o_height = o.z * side;
        // The line from the receiver through the stored point meets the light's plane.
        float reach = height / max(height - o_height, 1e-6 * height);
        vec2 hit = p_ls.xy + reach * (o.xy - p_ls.xy);
        bool is_blocker = face < map.face_count
            && o_height > 0.0 && o_height < height
            && dot(m_ls, o - p_ls) > blocking_height(texel_slack, rounding, o - p_ls)
            && abs(dot(hit, dual_u)) <= 1.0 && abs(dot(hit, dual_v)) <= 1.0;
        blocker_sum += is_blocker ? 1.0 - o_height / height : 0.0;
        blocker_count += is_blocker ? 1.0 : 0.0;
    }
    if (blocker_count == 0.0) {
        return 1.0;
    }

    float s = blocker_sum / blocker_count;
    float open = 0.0;
    float total = 0.0;
    first = set_of_pixel(pixel) * uint(FILTER_COUNT);
    for (int i = 0; i < FILTER_COUNT; ++i) {
        vec3 u = kronecker_point(first + uint(i), u_pattern_offset);
        vec3 to_light = vec3((2.0 * u.x - 1.0) * half_u + (2.0 * u.y - 1.0) * half_v, 0.0) - p_ls;
        vec3 q = p_ls + s * to_light;
        int face = face_of(map, q);
        vec3 w = face_from_light(face, q);
        ivec2 texel = clamp(ivec2(floor(tile_place(map, w))), ivec2(0), ivec2(last));
        vec3 o = light_from_face(face, stored_point(map, face, texel));
        bool is_blocker = face < map.face_count
            && o.z * side > 0.0 && o.z * side < height
            && dot(m_ls, o - p_ls) > blocking_height(texel_slack, rounding, o - p_ls);
        // What this part of the light would contribute: cos cos / distance^2.
        vec3 d = to_light / height;
        float weight = max(dot(m_ls, d), 0.0) / (dot(d, d) * dot(d, d));
        total += weight;
        open += is_blocker ? 0.0 : weight;
    }
    return total > 0.0 ? open / total : 1.0;
}

// Part of light number `index` that reaches p, 0..1; `m` is the geometric normal.
float shadow_map_visibility(int index, Light light, vec3 p_vs, vec3 m_vs, ivec2 pixel)
{
    ShadowMap map = shadow_map_of(index);
    vec3 p_ls = map.light_from_view * (p_vs - map.origin_vs);
    vec3 m_ls = map.light_from_view * m_vs;
    float rounding = SHADOW_ROUNDING * (largest_component(p_vs) + largest_component(map.origin_vs));
    if (light.kind == LIGHT_RECTANGLE) {
        vec2 half_u = (map.light_from_view * light.axis_vs).xy;
        vec2 half_v = (map.light_from_view * light.half_edge_v_vs).xy;
        return rectangle_visibility(map, p_ls, m_ls, rounding, half_u, half_v, pixel);
    }
    return point_light_visibility(map, p_ls, m_ls, rounding);
}
