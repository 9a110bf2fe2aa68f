// Who is lit, by rays: one where texels of a map disagree about a light without a size; to a
// light with one, a shaft to many of its points.
#include "rays/ray.glsl"

#define TRACES_PENUMBRAE IS_SOFT

#define SHAFT_IS_ROUND (LIGHT_FORM == FORM_PARALLEL)
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
// Of a light with a size: where its points begin, and from the 32 of one shaft to those of the next.
uniform vec2 u_edge_begin;
uniform vec2 u_edge_next;
// How many; and how many suffice where all of them agree, or rays have to tell.
uniform ivec2 u_edge_points;

// From a surface point of `pixel`, raised along its normal by `lift`, to the light. A little off the
// surface, by what the rasterizer may be wrong: looking for it in the hierarchy takes 1.16 times
// as long.
Shaft shaft_toward(Light light, vec3 n_vs, float lift, ivec2 pixel)
{
    vec3 to_surface = u_ns_from_vs * (gbuffer_position_vs(pixel) * u_ns_per_unit);
    vec3 apex = ray_start(u_eye_ns + to_surface, u_ns_from_vs * gbuffer_geometric_normal_vs(pixel),
                          viewing_direction(to_surface, u_ns_from_vs * AHEAD_VS),
                          GBUFFER_ERROR * length(to_surface) + RAY_OFFSET);
    apex += u_ns_from_vs * (n_vs * (lift * u_ns_per_unit));
#if LIGHT_FORM == FORM_PARALLEL
    mat3 frame = u_ns_from_vs * frame_from_z(light.place_vs);
    mat3 way = mat3(frame[2], light.numbers.x * frame[0], light.numbers.x * frame[1]);
    return shaft_from(apex, way, sqrt(way[1] * way[1] + way[2] * way[2]), RAY_FAR);
#else
    vec3 middle = u_eye_ns + u_ns_from_vs * (light.place_vs * u_ns_per_unit) - apex;
    vec3 u = u_ns_from_vs * (light.axis_vs * u_ns_per_unit);
    vec3 v = u_ns_from_vs * (light.second_axis_vs * u_ns_per_unit);
    // Nothing that lies nearer to the light's plane blocks: it may be the lamp itself.
    vec3 normal = cross(u, v);
    float height = abs(dot(normal, middle)) / max(length(normal), 1e-30);
    float t_max = 1.0 - LIGHT_GAP - RAY_OFFSET / max(height, 1e-30);
    return shaft_from(apex, mat3(middle, u, v), abs(u) + abs(v), t_max);
#endif
}

// How much light comes along `way`, by the cosines to n and to the light's own normal; none from
// below the plane across m.
float weight_of(vec3 way, vec3 n, vec3 m, vec3 of_light)
{
    float size_2 = max(dot(way, way), 1e-30);
    float weight = max(dot(way, n), 0.0);
#if LIGHT_FORM == FORM_AREA
    weight *= abs(dot(way, of_light)) / (size_2 * size_2);
#else
    weight *= inversesqrt(size_2);
#endif
    return dot(way, m) > 0.0 ? weight : 0.0;
}

// What is open of points of the light, and all, as weights.
vec2 weights_of(uint open, Shaft shaft, vec3 n_vs, vec3 m_vs, vec2 begin, int count)
{
    vec3 n = u_ns_from_vs * n_vs;
    vec3 m = u_ns_from_vs * m_vs;
    // As a unit, so that nothing underflows: all points share it.
    float unit = 1.0 / max(length(shaft.way[0]), 1e-30);
    vec3 of_light = cross(shaft.way[1], shaft.way[2]);
    of_light /= max(length(of_light), 1e-30);
    vec2 weights = vec2(0.0);
    int i = 0;
    do {
        vec3 way = shaft_way(shaft, shaft_points(begin, i), 0);
        weights += weight_of(unit * way, n, m, of_light) * vec2(open >> uint(i) & 1u, 1u);
    } while (++i < count);
    return weights;
}

// How much of the light reaches a pixel. All pixels ask for the same points, frame after frame
// while the view moves: what is wrong then moves with the surface instead of flickering.
float penumbra(Light light, vec3 n_vs, vec3 m_vs, float lift, ivec2 pixel)
{
    Shaft shaft = shaft_toward(light, n_vs, lift, pixel);
    vec2 seen = vec2(0.0);
    vec2 begin = u_edge_begin;
    int left = u_edge_points.x;
    bool goes_on = true;
    do {
        int count = min(left, 32);
        ShaftPoints points = shaft_open_points(shaft, begin, count);
        bool is_enough = u_edge_points.x - left + count >= u_edge_points.y;
        bool is_first = left == u_edge_points.x;
        bool is_even = points.open == 0u || points.open == shaft_all_points(count);
        if (is_first && is_enough && is_even) {
            // All or nothing, however much each of them counts.
            return points.open == 0u ? 0.0 : 1.0;
        }
        seen += weights_of(points.open, shaft, n_vs, m_vs, begin, count);
        begin += u_edge_next;
        left -= count;
        goes_on = left > 0 && !(is_enough && points.by_rays);
    } while (goes_on);
    return seen.y > 0.0 ? seen.x / seen.y : 1.0;
}
#endif
