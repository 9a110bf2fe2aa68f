#version 330 core
// Directional occlusion: irradiance that arrives through open directions,
//   E(P) = integral of L_in(w) V_R(w) cos(theta) dw,
// L_in = environment and the lights that arrive through SSDO.
//
// Defines: ESTIMATOR 0 march, 1 rgs09; DIRECTION_COUNT, STEP_COUNT, HAS_BACK_LAYER;
// ENVIRONMENT_KIND (see lib/environment.glsl); SSDO_RECTANGLE_COUNT, SSDO_POINT_COUNT,
// LIGHT_STEP_COUNT (depth reads towards each point, spot or directional light);
// CONTROL_VARIATE 0 sum the open light (the paper), 1 correct it by the exact total,
// 2 subtract the blocked light from the exact total.
#include "lib/estimator.glsl"
#include "lib/environment.glsl"
#include "lib/ssdo_lights.glsl"

layout(location = 0) out vec4 o_directional;  // rgb irradiance, a visibility

// Light that arrives from afar can be tinted only if it differs between directions.
#define HAS_DIRECTIONS (ENVIRONMENT_KIND > 1 || SSDO_RECTANGLE_COUNT > 0)

// pi times these are irradiances: sums of share * L_in over directions.
struct Gathered {
    vec3 open;
    vec3 all;
    float blocked;  // share of directions
};

// Adds what arrives along direction `d`. The light of a rectangle that stands nearer
// than what blocks the direction arrives all the same.
void gather(inout Gathered g, Tangent t, Direction d, Blocker b)
{
    g.blocked += is_blocked(b) ? d.share : 0.0;
#if ENVIRONMENT_KIND > 1 || (ENVIRONMENT_KIND == 1 && CONTROL_VARIATE == 0)
    vec3 sky = d.share * environment_radiance(direction_ws_of(d.w_vs));
    g.all += sky;
    g.open += is_blocked(b) ? vec3(0.0) : sky;
#endif
#if SSDO_RECTANGLE_COUNT > 0
    // Light from below the geometric horizon does not count, as in `direct`.
    if (dot(d.w_vs, t.normal_vs) > 0.0) {
        for (int i = 0; i < SSDO_RECTANGLE_COUNT; ++i) {
            float distance = distance_to_rectangle(rectangle_target(i, t.position_vs), d.w_vs);
            vec3 light = distance < FLOAT_MAX ? d.share * u_rectangle_radiance[i] : vec3(0.0);
            g.all += light;
            g.open += distance < b.distance ? light : vec3(0.0);
        }
    }
#endif
}

// Unoccluded irradiance of everything that `gather` samples.
vec3 exact_irradiance(Receiver r)
{
    vec3 e = environment_irradiance(direction_ws_of(r.normal_vs));
#if SSDO_RECTANGLE_COUNT > 0
    for (int i = 0; i < SSDO_RECTANGLE_COUNT; ++i)
        e += rectangle_irradiance_at(i, r.position_vs, r.normal_vs, r.geometric_vs);
#endif
    return e;
}

vec3 arrived(Receiver r, Gathered g, float visibility)
{
#if CONTROL_VARIATE == 0
    return PI * g.open;
#elif CONTROL_VARIATE == 1
    // The exact total corrects the sampled one, S_open + c (E - S_all), with a weight c
    // that suits both ends: where all is open, c = 1 gives E without noise; where little
    // is, c = 0 leaves the little that was sampled, and no noise of what is blocked.
    return max(PI * g.open + visibility * (exact_irradiance(r) - PI * g.all), vec3(0.0));
#else
    return max(exact_irradiance(r) - PI * (g.all - g.open), vec3(0.0));
#endif
}

#if SSDO_POINT_COUNT > 0
// A point, spot or directional light: RGS09 section 5 puts its samples on the one segment
// of length R towards the light.
vec3 point_lights(Receiver r, Tangent t)
{
    vec3 e = vec3(0.0);
    for (int i = 0; i < SSDO_POINT_COUNT; ++i) {
        Light light = point_light(i);
        vec3 unshadowed = unshadowed_irradiance(light, r.position_vs, r.normal_vs, r.geometric_vs);
        vec3 to_light = light.place_vs - r.position_vs;
        float distance = length(to_light);
        bool is_distant = light.kind == LIGHT_DIRECTIONAL;
        vec3 w = is_distant ? light.place_vs : to_light / max(distance, 1e-37);
        float reach = is_distant ? u_radius : min(u_radius, distance);
        bool is_lit = unshadowed != vec3(0.0);
        if (is_lit && !is_blocked(march(t, w, reach, sample_point(r, i).z, LIGHT_STEP_COUNT)))
            e += unshadowed;
    }
    return e;
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, DIRECTION_COUNT);
    vec3 irradiance = vec3(0.0);
    float visibility = 1.0;
    if (r.z_vs > 0.0) {
        Tangent t = tangent_at(r.position_vs, r.geometric_vs);
        bool is_open = is_radius_under_a_pixel(r.z_vs);
        Gathered g = Gathered(vec3(0.0), vec3(0.0), 0.0);
        for (int i = 0; i < DIRECTION_COUNT; ++i) {
            Direction d = direction_of(r, i);
            Blocker b = NO_BLOCKER;
            if (!is_open)
                b = blocker_of(t, d);
            gather(g, t, d, b);
        }
        visibility = max(1.0 - g.blocked, 0.0);
#if HAS_DIRECTIONS || CONTROL_VARIATE == 0
        irradiance = arrived(r, g, visibility);
#else
        irradiance = visibility * exact_irradiance(r);
#endif
#if SSDO_POINT_COUNT > 0
        irradiance += point_lights(r, t);
#endif
    }
    o_directional = vec4(irradiance, visibility);
}
