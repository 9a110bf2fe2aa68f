// Who is lit, by rays: one where texels of a map disagree about a light without a size; to a
// light with one, a shaft to many of its points.
#include "rays/ray.glsl"

#define TRACES_PENUMBRAE IS_SOFT

#include "rays/shaft.glsl"

bool is_blocked_toward(RaySurface surface, vec3 to_light_vs)
{
    vec3 to_light = u_ns_from_vs * to_light_vs;
    float size = max(length(to_light), 1e-30);
    float reach = LIGHT_FORM == FORM_PARALLEL ? RAY_FAR : reach_toward_light(size * u_ns_per_unit);
    return light_is_blocked(surface, to_light / size, reach);
}

vec3 start_vs(RaySurface surface)
{
    return ((surface.start - u_eye_ns) / u_ns_per_unit) * u_ns_from_vs;
}

vec2 shadow_edge(Light light, ivec2 pixel, bool is_edge, vec2 visibility)
{
    if (is_edge) {
        RaySurface surface = ray_surface_at(pixel);
        vec3 to_light = light.place_vs;
#if LIGHT_FORM != FORM_PARALLEL
        to_light -= start_vs(surface);
#endif
        visibility = vec2(is_blocked_toward(surface, to_light) ? 0.0 : 1.0);
    }
    return visibility;
}

#if TRACES_PENUMBRAE
// From a surface point of `pixel`, raised along its normal by `lift`, to the light. A little off the
// surface, by what the rasterizer may be wrong: looking for it in the hierarchy takes 1.16 times
// as long.
Shaft shaft_toward(Light light, vec3 n_vs, float lift, ivec2 pixel)
{
    vec3 apex = ray_start_vs(gbuffer_position_vs(pixel), gbuffer_geometric_normal_vs(pixel));
    apex += u_ns_from_vs * (n_vs * (lift * u_ns_per_unit));
#if LIGHT_FORM == FORM_PARALLEL
    mat3 frame = u_ns_from_vs * frame_from_z(light.place_vs);
    mat3 way = mat3(frame[2], light.numbers.x * frame[0], light.numbers.x * frame[1]);
    return shaft_from(apex, way, sqrt(way[1] * way[1] + way[2] * way[2]), RAY_FAR);
#else
    vec3 middle = u_eye_ns + u_ns_from_vs * (light.place_vs * u_ns_per_unit) - apex;
    vec3 u = u_ns_from_vs * (light.axis_vs * u_ns_per_unit);
    vec3 v = u_ns_from_vs * (light.second_axis_vs * u_ns_per_unit);
    // Lines go along the longer edge, of a square along the first, however that is rounded.
    bool is_long = dot(u, u) > 0.99 * dot(v, v);
    mat3 way = mat3(middle, is_long ? u : v, is_long ? v : u);
    // Nothing that lies nearer to the light's plane blocks: it may be the lamp itself.
    vec3 normal = cross(u, v);
    float height = abs(dot(normal, middle)) / max(length(normal), 1e-30);
    float t_max = 1.0 - LIGHT_GAP - RAY_OFFSET / max(height, 1e-30);
    return shaft_from(apex, way, abs(u) + abs(v), t_max);
#endif
}

// How many bits are set of each four that follow each other.
uvec4 counts_of(uvec4 points)
{
    points -= points >> 1u & 0x55555555u;
    return (points & 0x33333333u) + (points >> 2u & 0x33333333u);
}

// How much light comes from four points, all as far from the light's plane as others: by the cosine to n
// and distance; none from below the plane across m.
vec4 weights_along(vec4 of_n, vec4 of_m, vec4 size_2)
{
    vec4 weight = max(of_n, 0.0);
#if LIGHT_FORM == FORM_AREA
    vec4 inverse = 1.0 / max(size_2, 1e-30);
    weight *= inverse * inverse;
#else
    weight *= inversesqrt(max(size_2, 1e-30));
#endif
    return weight * vec4(greaterThan(of_m, vec4(0.0)));
}

#if GLOSSY && LIGHT_FORM == FORM_PARALLEL
// Lobes are no narrower here than this part of a light: four points are counted at one place.
const float LEAST_PART = 0.125;

// How much a glossy surface that is looked at along w_out reflects of four points' light, over their
// irradiance: by the distribution of its facets.
vec4 facets_along(vec3 n, vec3 w_out, float alpha, mat4x3 ways, vec4 size_2)
{
    vec4 inverse = inversesqrt(max(size_2, 1e-30));
    vec4 d;
    for (int i = 0; i < 4; ++i) {
        d[i] = ggx_distribution(n, half_vector(n, w_out, ways[i] * inverse[i]), alpha);
    }
    return d;
}
#endif

// How much of the light from `points` comes from `some` of them: four points of a line count as many in
// the middle of them. y: of what the lobe of `pixel` reflects of a sun.
vec2 share_of(uvec4 some[SHAFT_GROUPS], uvec4 points[SHAFT_GROUPS], Shaft shaft, vec3 n_vs, vec3 m_vs,
              ivec2 pixel)
{
    vec3 n = u_ns_from_vs * n_vs;
    vec3 m = u_ns_from_vs * m_vs;
    // As a unit, so that nothing underflows: all points share it.
    mat3 way = shaft.way * (1.0 / max(length(shaft.way[0]), 1e-30));
    vec3 along = way * vec3(0.0, u_shaft_step);
    float along_2 = max(dot(along, along), 1e-30);
#if GLOSSY && LIGHT_FORM == FORM_PARALLEL
    Brdf brdf = brdf_at(pixel);
    vec3 w_out = u_ns_from_vs * toward_camera(gbuffer_position_vs(pixel));
    float alpha = max(alpha_of(brdf.roughness), LEAST_PART * length(way[1]));
    vec2 reflected = vec2(0.0);
#endif
    vec2 weights = vec2(0.0);
    for (int g = 0; g < SHAFT_GROUPS; ++g) {
        // Of each line: its first point, and where it comes nearest.
        mat4x3 first = mat4x3(way[0], way[0], way[0], way[0])
                     + outerProduct(way[1], u_shaft_x[g]) + outerProduct(way[2], u_shaft_y[g]);
        vec4 foot = -(along * first) / along_2;
        mat4x3 nearest = first + outerProduct(along, foot);
        vec4 nearest_2 = vec4(dot(nearest[0], nearest[0]), dot(nearest[1], nearest[1]),
                              dot(nearest[2], nearest[2]), dot(nearest[3], nearest[3]));
        vec4 of_n = n * first;
        vec4 of_m = m * first;
        uvec4 open = counts_of(some[g]);
        uvec4 asked = counts_of(points[g]);
        int i = 0;
        do {
            float place = 4.0 * float(i) + 1.5;
            vec4 from_foot = place - foot;
            vec4 weight = weights_along(of_n + place * dot(along, n), of_m + place * dot(along, m),
                                        nearest_2 + from_foot * from_foot * along_2);
            vec4 open_four = vec4(open >> (4u * uint(i)) & 15u);
            vec4 asked_four = vec4(asked >> (4u * uint(i)) & 15u);
            weights += vec2(dot(weight, open_four), dot(weight, asked_four));
#if GLOSSY && LIGHT_FORM == FORM_PARALLEL
            weight *= facets_along(n, w_out, alpha, first + outerProduct(along, vec4(place)),
                                   nearest_2 + from_foot * from_foot * along_2);
            reflected += vec2(dot(weight, open_four), dot(weight, asked_four));
#endif
        } while (++i < 8);
    }
    vec2 share = vec2(weights.y > 0.0 ? weights.x / weights.y : 1.0);
#if GLOSSY && LIGHT_FORM == FORM_PARALLEL
    share.y = reflected.y > 0.0 ? reflected.x / reflected.y : share.x;
#endif
    return share;
}

// How much of the light reaches a pixel. All pixels ask for the same points, frame after frame
// while the view moves: what is wrong then moves with the surface instead of flickering. y: as in share_of.
vec2 penumbra(Light light, vec3 n_vs, vec3 m_vs, float lift, ivec2 pixel)
{
    Shaft shaft = shaft_toward(light, n_vs, lift, pixel);
    ShaftPoints points = shaft_open_points(shaft);
    if (!shaft_is_any(points.open)) {
        return vec2(0.0);
    }
    // All or nothing, however much each of them counts.
    vec2 seen = vec2(1.0);
    if (!shaft_are_same(points.left, u_shaft_points)) {
        seen = share_of(points.left, u_shaft_points, shaft, n_vs, m_vs, pixel);
    }
    if (!shaft_are_same(points.open, points.asked)) {
        seen *= share_of(points.open, points.asked, shaft, n_vs, m_vs, pixel);
    }
    return seen;
}
#endif
