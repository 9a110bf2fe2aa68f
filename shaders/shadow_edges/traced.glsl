// Who is lit, by rays: one where texels of a map disagree about a light without a size; to a
// light with one RAYS_ALL and two to its rim from every pixel, more where those of four pixels
// disagree.
#include "rays/ray.glsl"

#define TRACES_PENUMBRAE IS_SOFT

// How far within the light its rim is asked for, of its extent: not where a neighbour begins.
const float RIM = 0.02;
const int RIM_FIRST = 1 << 16;

uniform vec2 u_edge_points;  // where the points of a light begin
uniform int u_edge_rays;     // where four pixels disagree

// From `p_vs` towards the light, or its point at u; w: how much of the light comes from there.
vec4 toward_light(Light light, vec2 u, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
#if LIGHT_FORM == FORM_PARALLEL
    vec3 to_light = light.place_vs;
#if IS_SOFT
    to_light = normalize(frame_from_z(to_light) * vec3(disk_point(light.numbers.x, u), 1.0));
#endif
    float weight = 1.0;
#elif LIGHT_FORM == FORM_AREA
    vec3 to_light = area_point(light, u) - p_vs;
    // As a unit, so that nothing underflows: all points share the light's.
    vec3 d = to_light / length(light.place_vs - p_vs);
    float size_2 = max(dot(d, d), 1e-30);
    float weight = abs(dot(d, area_normal(light, p_vs))) / (size_2 * size_2);
#else
    vec3 to_light = light.place_vs - p_vs;
    float weight = 1.0;
#endif
    weight *= max(dot(normalize(to_light), n_vs), 0.0);
    return vec4(to_light, dot(to_light, m_vs) > 0.0 ? weight : 0.0);
}

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
// A corner of a rectangle, or a point of the edge of a disk.
vec2 rim_point(int i)
{
    vec2 corner = mix(vec2(RIM), vec2(1.0 - RIM), vec2(i & 1, i >> 1));
    return LIGHT_FORM == FORM_PARALLEL ? vec2(1.0 - RIM, 0.25 * float(i) + 0.125) : corner;
}

// What is open of points `first` to `last` of the light, and all, as weights. Those from RIM_FIRST on
// are of its rim. Those before `moved` lie RAYS_ALL back.
vec2 open_points(Light light, RaySurface surface, vec3 n_vs, vec3 m_vs, int first, int last,
                 int moved)
{
    vec3 p_vs = start_vs(surface);
    vec2 open = vec2(0.0);
    int i = first;
    do {
        int number = i < moved ? i - RAYS_ALL : i;
        vec2 u = number < RIM_FIRST ? fract(u_edge_points + float(number) * KRONECKER_STEP.xy)
                                    : rim_point(number - RIM_FIRST);
        vec4 way = toward_light(light, u, p_vs, n_vs, m_vs);
        bool is_open = way.w > 0.0 && !is_blocked_toward(surface, way.xyz);
        open += vec2(is_open ? way.w : 0.0, way.w);
    } while (++i < last);
    return open;
}

// How much of the light reaches a pixel. All pixels ask for the same points, frame after frame
// while the view moves: what is wrong then moves with the surface instead of flickering. Points
// within the light alone would find a penumbra late, and make its outline a step.
float penumbra(Light light, vec3 n_vs, vec3 m_vs, ivec2 pixel, bool is_lit)
{
    RaySurface surface;
    vec2 own = vec2(0.0);
    vec2 rim = vec2(0.0);
    // Of the points that are asked for first pixels beside each other take a half.
    int turn = (pixel.x ^ pixel.y) & 1;
    if (is_lit) {
        int first = turn * RAYS_ALL;
        int first_of_rim = RIM_FIRST + 2 * turn;
        surface = ray_surface_at(pixel);
        own = open_points(light, surface, n_vs, m_vs, first, first + RAYS_ALL, 0);
        rim = open_points(light, surface, n_vs, m_vs, first_of_rim, first_of_rim + 2, 0);
    }
    vec2 open = own + rim;
    bvec2 found = bvec2(open.x > 0.0, open.x < open.y);  // light, shadow
    vec4 around = quad_sum(vec4(found, 0.0, 0.0), pixel);
    if (is_lit && min(around.x, around.y) > 0.0) {
        // All points but the own half, and that.
        int moved = 2 * RAYS_ALL * turn;
        open = own + open_points(light, surface, n_vs, m_vs, RAYS_ALL, u_edge_rays, moved);
    }
    return open.y > 0.0 ? open.x / open.y : 1.0;
}
#endif
