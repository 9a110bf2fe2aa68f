// How much of a rectangle reaches a point, from the shadow atlas: see lights/shadow.glsl.
//
// BLOCKER_COUNT, FILTER_COUNT: samples of the shadow of one part. GLOSSY: of what a glossy lobe
// sees of the light, too.
#include "lights/shadow.glsl"

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

// One after the other, the samples of each part of a rectangle, part after part: in software
// a loop costs two rounds more than it runs, and at least one, so there is one for all parts,
// which tests at its end whether it goes on.
struct PartWalk {
    vec2 part;    // column and row
    int number;   // of the sample within the part
    vec3 random;  // in [0, 1)
};

// Each pixel of a block has its own stretch of the sequence, each part its own block.
const int STRETCH = BLOCKER_COUNT > FILTER_COUNT ? BLOCKER_COUNT : FILTER_COUNT;

PartWalk next_sample(PartWalk walk, float columns, int count)
{
    bool is_over = walk.number + 1 == count;
    vec2 beside = walk.part + vec2(1.0, 0.0);
    vec2 next_part = beside.x < columns ? beside : vec2(0.0, beside.y + 1.0);
    float step = is_over ? float(BLOCK_SIZE * BLOCK_SIZE * STRETCH - count + 1) : 1.0;
    return PartWalk(is_over ? next_part : walk.part, is_over ? 0 : walk.number + 1,
                    fract(walk.random + step * KRONECKER_STEP));
}

// A sample of a part: the receiver relative to the part's centre, and from there to a point
// of the part.
struct ToPart {
    vec3 p;
    vec3 to_light;
};

// `y`: the point, from -1 to 1 along the part's edges.
ToPart way_to_part(SoftShadow shadow, vec2 part, float columns, vec2 y)
{
    vec2 place = part * 2.0 + 1.0 - columns;
    vec3 p = shadow.p - (place.x * shadow.half_u + place.y * shadow.half_v);
    return ToPart(p, y.x * shadow.half_u + y.y * shadow.half_v - p);
}

// Weights of the quarters of the light that the part belongs to: 1 for one of them.
vec4 quarter_of(PartWalk walk, float columns)
{
    vec2 upper = step(columns, 2.0 * walk.part);
    vec2 lower = 1.0 - upper;
    return vec4(lower.x, upper.x, lower.x, upper.x) * vec4(lower.y, lower.y, upper.y, upper.y);
}

// The part whose own texel of the receiver this pixel looks up in its search, so that what
// lies in the shadow of its centre is never missed: another for each of the four pixels that
// search together, but where some of the light is below the horizon, the part that is highest.
vec2 part_of_pixel(SoftShadow shadow, float columns, ivec2 pixel)
{
    vec2 up = vec2(dot(shadow.half_u, shadow.m), dot(shadow.half_v, shadow.m));
    bool is_partly_below = -dot(shadow.p, shadow.m) < columns * (abs(up.x) + abs(up.y));
    return is_partly_below ? step(0.0, up) * (columns - 1.0) : vec2(pixel & 1);
}

// How high over the receiver, of the light's height, there is what blocks the way to the part
// at `s` of it; 0: nothing. The line through what the map stores there must meet the part no
// farther from `middle` than `shaft`, from -1 to 1 along the part's edges.
float blocker_at(SoftShadow shadow, Face face, ToPart way, float s, vec2 middle, vec2 shaft)
{
    vec3 q = way.p + s * way.to_light;
    vec3 offset = face_point(face, floor(face_place(face, q))) - way.p;
    float rise = -dot(offset, shadow.axis);
    float reach = shadow.height / max(rise, 1e-6 * shadow.height);
    vec3 on_light = way.p + reach * offset;
    vec2 hit = vec2(dot(on_light, shadow.dual_u), dot(on_light, shadow.dual_v));
    // The shaft to a small light fits in between the centres of texels: there any texel
    // that it passes through is in its way. Close to the receiver its neighbours are.
    bool is_clear = rise > SHADOW_CLEAR_SLACKS * shadow.slack;
    vec2 widest = max(shaft, is_clear ? reach * q.z * shadow.texel : vec2(0.0));
    // Calls first, here and below: behind `&&` or `?` each would be a branch.
    bool is_met = all(lessThanEqual(abs(hit - middle), widest));
    bool is_above = is_above_plane(offset, shadow.m, shadow.slack);
    return q.z > 0.0 && rise > 0.0 && is_met && is_above ? rise / shadow.height : 0.0;
}

// Soft shadow of a rectangle, each of whose parts has a map of its own: percentage-closer soft
// shadows (Fernando 2005) in which search and filter work on the light's points themselves
// instead of on circles in the map. The way from the receiver p to the light's point y passes
// p + s (y - p); seen from its part's centre, texels there hold what may block it.
// Pixels without a surface run one round: branches would not save it, in software, nor may
// derivatives be inside.
float diffuse_visibility(ShadowMap map, SoftShadow shadow, Face face, vec3 start, ivec2 pixel,
                         bool is_surface)
{
    float columns = float(map.parts_per_side);
    int parts = map.parts_per_side * map.parts_per_side;
    vec2 first_corner = face.corner;
    vec4 heights = vec4(0.0);  // of blockers before each quarter of the light, added up
    vec4 found = vec4(0.0);    // their number
    int rounds = is_surface ? parts * BLOCKER_COUNT : 0;
    int round = 0;
    vec2 own_part = part_of_pixel(shadow, columns, pixel);
    PartWalk walk = PartWalk(vec2(0.0), 0, start);
    do {
        face.corner = first_corner + walk.part * map.texels;
        // What is near the receiver covers few texels, near its own; what is farther off, whose
        // penumbrae are wide, every other sample looks for.
        float r = walk.random.z * 2.0 - 1.0;
        float far = r * r;
        float s = (walk.number & 1) == 1 ? far : far * abs(r);
        s = walk.number == 0 && walk.part == own_part ? 0.0 : s;
        ToPart way = way_to_part(shadow, walk.part, columns, walk.random.xy * 2.0 - 1.0);
        float height = blocker_at(shadow, face, way, s, vec2(0.0), vec2(1.0));
        vec4 quarter = quarter_of(walk, columns) * (height > 0.0 ? 1.0 : 0.0);
        heights += quarter * height;
        found += quarter;
        walk = next_sample(walk, columns, BLOCKER_COUNT);
    } while (++round < rounds);
    // Four pixels search together: less error in penumbrae, for nothing.
    heights = quad_sum(is_surface ? heights : vec4(0.0), pixel);
    found = quad_sum(is_surface ? found : vec4(0.0), pixel);

    float found_in_all = dot(found, vec4(1.0));
    bool is_shadowed = is_surface && found_in_all > 0.0;
    float mean_height = dot(heights, vec4(1.0)) / max(found_in_all, 1.0);
    rounds = is_shadowed ? parts * FILTER_COUNT : 0;
    round = 0;
    vec2 of_light = vec2(0.0);  // what is open, and all, as weights
    vec2 of_part = vec2(0.0);
    walk = PartWalk(vec2(0.0), 0, start);
    do {
        face.corner = first_corner + walk.part * map.texels;
        ToPart way = way_to_part(shadow, walk.part, columns, walk.random.xy * 2.0 - 1.0);
        // Where nothing was found before a quarter, what stands before others counts if it is
        // not far beside the part, too.
        vec4 quarter = quarter_of(walk, columns);
        float here = dot(quarter, found);
        float sum = dot(quarter, heights);
        float s = here > 0.0 ? sum / here : mean_height;
        vec2 shaft = vec2(here > 0.0 ? FLOAT_MAX : 2.0);
        bool is_open = blocker_at(shadow, face, way, s, vec2(0.0), shaft) == 0.0;
        float weight = part_weight(way.to_light, shadow.m, shadow.height);
        of_part += weight * vec2(is_open ? 1.0 : 0.0, 1.0);
        float whole = part_weight(-way.p, shadow.m, shadow.height);
        float share = walk.number + 1 == FILTER_COUNT ? whole : 0.0;
        of_light += share * vec2(of_part.y > 0.0 ? of_part.x / of_part.y : 1.0, 1.0);
        of_part = walk.number + 1 == FILTER_COUNT ? vec2(0.0) : of_part;
        walk = next_sample(walk, columns, FILTER_COUNT);
    } while (++round < rounds);
    return is_shadowed && of_light.y > 0.0 ? of_light.x / of_light.y : 1.0;
}

#if GLOSSY
// A lobe may see little of a part: more of the way there is searched, and what passes beside it
// by this share of half of the part counts, because searched texels lie before or behind.
const int LOBE_SEARCH_COUNT = 8;
const float LEAST_SHAFT = 0.15;

// The share of what a lobe sees of a rectangle that nothing blocks. `seen_by_lobe`: its low and
// high corner, from -1 to 1 along the light's edges.
float lobe_visibility(ShadowMap map, SoftShadow shadow, Face face, vec3 start, ivec2 pixel,
                      bool is_glossy, vec4 seen_by_lobe)
{
    float columns = float(map.parts_per_side);
    vec2 first_corner = face.corner;
    float open = 0.0;
    float total = 0.0;
    for (int number = 0; number < map.parts_per_side * map.parts_per_side; ++number) {
        vec2 part = vec2(float(number % map.parts_per_side), float(number / map.parts_per_side));
        vec2 place = part * 2.0 + 1.0 - columns;
        face.corner = first_corner + part * map.texels;
        vec4 seen = clamp(seen_by_lobe * columns - place.xyxy, -1.0, 1.0);
        vec2 size = seen.zw - seen.xy;
        vec2 shaft = max(0.5 * size, LEAST_SHAFT);
        bool is_seen = is_glossy && size.x * size.y > 0.0;
        vec2 blockers = vec2(0.0);
        int rounds = is_seen ? LOBE_SEARCH_COUNT : 0;
        for (int i = 0; i < rounds; ++i) {
            vec3 r = fract(start + float(i) * KRONECKER_STEP);
            ToPart way = way_to_part(shadow, part, columns, seen.xy + r.xy * size);
            float s = (r.z * 2.0 - 1.0) * (r.z * 2.0 - 1.0);
            float height = blocker_at(shadow, face, way, s, 0.5 * (seen.xy + seen.zw), shaft);
            blockers += height > 0.0 ? vec2(height, 1.0) : vec2(0.0);
        }
        blockers = quad_sum(vec4(blockers, 0.0, 0.0), pixel).xy;
        rounds = is_seen && blockers.y > 0.0 ? FILTER_COUNT : 0;
        float s = blockers.x / max(blockers.y, 1.0);
        float share = rounds > 0 ? 0.0 : 1.0;
        for (int i = 0; i < rounds; ++i) {
            vec2 r = fract(start + float(i) * KRONECKER_STEP).xy;
            ToPart way = way_to_part(shadow, part, columns, seen.xy + r * size);
            bool is_open = blocker_at(shadow, face, way, s, vec2(0.0), vec2(FLOAT_MAX)) == 0.0;
            share += is_open ? 1.0 / float(FILTER_COUNT) : 0.0;
        }
        open += size.x * size.y * share;
        total += size.x * size.y;
        start = fract(start + float(BLOCK_SIZE * BLOCK_SIZE * STRETCH) * KRONECKER_STEP);
    }
    return total > 0.0 ? open / total : 1.0;
}
#endif

// Soft shadow of a rectangle; y: of what a lobe sees of it.
vec2 area_shadow_visibility(ShadowMap map, vec3 p_ls, vec3 m_ls, float rounding,
                            vec2 half_u, vec2 half_v, ivec2 pixel, bool is_surface,
                            bool is_glossy, vec4 seen_by_lobe)
{
    float inverse = 1.0 / float(map.parts_per_side);
    int number = face_of(p_ls);
    SoftShadow shadow =
        soft_shadow(map, number, p_ls, m_ls, rounding, half_u * inverse, half_v * inverse);
    Face face = face_at(map, number);
    vec3 start = first_random(pixel, STRETCH);
    vec2 visibility = vec2(diffuse_visibility(map, shadow, face, start, pixel, is_surface), 1.0);
#if GLOSSY
    visibility.y = lobe_visibility(map, shadow, face, start, pixel, is_glossy, seen_by_lobe);
#endif
    return visibility;
}
