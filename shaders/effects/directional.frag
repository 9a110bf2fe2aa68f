#version 330 core
// Directional occlusion: irradiance that arrives through open directions,
//   E(P) = integral of L_in(w) V_R(w) cos(theta) dw,
// L_in = environment and the lights that arrive through SSDO.
//
// Defines: DIRECTION_COUNT, STEP_COUNT, HAS_BACK_LAYER; SUMS_OPEN_LIGHT 1 for the paper's
// estimator, which adds up what arrives instead of correcting the exact light;
// ENVIRONMENT_KIND (see lib/environment.glsl); SSDO_AREA_COUNT, SSDO_POINT_COUNT,
// LIGHT_STEP_COUNT (depth reads towards each light without an area);
// NEEDS_HEMISPHERE 0 if neither environment nor visibility are called for;
// CONTROL_VARIATE 0 sum the open light (the paper), 1 correct it by the exact total as far
// as the environment seems to be open, 2 subtract the blocked light from the exact total;
// HAS_BAKED_OCCLUSION: images say how much of the environment some surfaces see;
// GATHERED 1: light that per-pixel rays have gathered takes the march's place, which tells visibility alone;
// IS_OPEN (see screen_space/estimator.glsl); KEPT_TEXTURE_COUNT (see screen_space/kept_directions.glsl).
#define GATHERS_SENDERS 0
#include "screen_space/estimator.glsl"
#define TAKES_DIRECTIONS 0
#include "screen_space/kept_directions.glsl"
#include "lib/environment.glsl"
#include "lights/ssdo_lights.glsl"

#if GATHERED
uniform sampler2D t_gathered_far;  // as rays/shared_rays.glsl says
#endif
#if HAS_BAKED_OCCLUSION
uniform sampler2D t_finish;  // g: baked visibility of the environment
#endif

layout(location = 0) out vec4 o_directional;  // rgb irradiance, a visibility

// The environment is sampled unless it is constant: then visibility says it all. The
// paper's estimator samples it all the same.
#define SAMPLES_ENVIRONMENT (!GATHERED && (ENVIRONMENT_KIND > 1 || (ENVIRONMENT_KIND == 1 && SUMS_OPEN_LIGHT)))

// Where nothing blocks, the sampled light that corrects the exact one is what it corrects.
const int HEMISPHERE_COUNT = IS_OPEN == 1 && CONTROL_VARIATE > 0 ? 0 : DIRECTION_COUNT;

// Sums over directions; pi times a sum of share * radiance is an irradiance.
struct Gathered {
    float blocked;         // share of directions
    vec3 open;             // share * radiance of the environment, open directions
    vec3 all;              // the same, all directions
    vec3 areas;            // rgs09: share * radiance of lights with an area, open directions
};

#if FINDS_SECTORS
// Light from beyond the blockers is looked up in this many directions of a slice.
const int SKY_COUNT = 4;

// Adds what arrives in slice `i`; `share` is that of a direction of weight 1.
void gather_slice(inout Gathered g, Receiver r, Tangent t, vec3 view, int i, float share, bool is_open)
{
    Sectors s = estimator_sectors(r, view, i);
    vec3 sent = vec3(0.0);
    uint hidden = is_open ? 0u : estimator_hidden(s, t, view, sample_point(r, i).z, sent);
    share *= sector_weight(s);
    g.blocked += share * float(bit_count(hidden));
#if SAMPLES_ENVIRONMENT
    float width = PI / float(SKY_COUNT);
    float start = s.slice.normal_angle - HALF_PI;
    float before = 0.0;
    for (int k = 0; k < SKY_COUNT; ++k) {
        float angle = start + (float(k) + 1.0) * width;
        bool is_last = k == SKY_COUNT - 1;
        float after = is_last ? 1.0 : share_before(s, vec2(sin(angle), cos(angle)));
        uint bits = lowest_bits(sectors_before(s, after)) & ~lowest_bits(sectors_before(s, before));
        float open = 1.0 - float(bit_count(hidden & bits)) / float(max(bit_count(bits), 1));
        float part = share * SECTOR_COUNT * (after - before);
        before = after;
        // Anywhere between the edges; the four of a slice move apart from each other.
        float jitter = fract(s.jitter + 0.61803399 * float(k));
        angle += (jitter - 1.0) * width;
        vec3 w_vs = sin(angle) * s.slice.along_vs + cos(angle) * view;
        vec3 sky = part * environment_radiance(direction_ws_of(w_vs));
        g.all += sky;
        g.open += open * sky;
    }
#endif
}
#else
// Adds what arrives along direction `d`, number `i`.
void gather(inout Gathered g, Tangent t, Direction d, Blocker b)
{
    g.blocked += is_blocked(b) ? d.share : 0.0;
#if SAMPLES_ENVIRONMENT
    vec3 sky = d.share * environment_radiance(direction_ws_of(d.w_vs));
    g.all += sky;
    g.open += is_blocked(b) ? vec3(0.0) : sky;
#endif
#if SSDO_AREA_COUNT > 0 && SUMS_OPEN_LIGHT
    // A light that stands nearer than what blocks the direction is seen all the same.
    for (int i = 0; i < SSDO_AREA_COUNT; ++i) {
        Light light = ssdo_light(i);
        bool meets = area_distance(light, t.position_vs, d.w_vs) < b.distance;
        g.areas += meets ? d.share * light.power : vec3(0.0);
    }
#endif
}
#endif

// The environment's exact irradiance E corrects the sampled one: S_open + c (E - S_all).
// Where everything is open that is E without noise, whatever c.
// c = 1 subtracts the blocked light from E: right on average but for the cut at 0. Best
// where radiance changes little between directions (relative RMSE over three scenes with
// gradients, 1 direction of 8 steps: .073 against .091; no difference from 2 on).
// c = S_open / S_all gives E times the open part: never below 0 and never above E, so a
// sun that one direction in a hundred meets cannot blacken a pixel. One direction's share
// is added to both sums, open as far as the hemisphere is, so that 0 / 0 cannot happen.
vec3 environment_arrived(Receiver r, Gathered g, float visibility)
{
    vec3 exact = environment_irradiance(direction_ws_of(r.normal_vs));
#if !SAMPLES_ENVIRONMENT
    return exact * visibility;
#elif CONTROL_VARIATE == 0
    return PI * g.open;
#else
#if CONTROL_VARIATE == 1
    float one_direction = dot(exact, vec3(INV_PI)) / float(DIRECTION_COUNT);
    float c = (dot(g.open, vec3(1.0)) + one_direction * visibility)
            / max(dot(g.all, vec3(1.0)) + one_direction, 1e-37);
#else
    const float c = 1.0;
#endif
    return max(c * exact + PI * (g.open - c * g.all), vec3(0.0));
#endif
}

#if SSDO_AREA_COUNT > 0 && !SUMS_OPEN_LIGHT
// Lights with an area: the exact irradiance times the part of it that arrives.
// Directions are aimed at points of the light instead of drawn from the hemisphere,
// of which it may fill little: with 2, 4, 8 of 8 steps, relative RMSE in a room lit
// through a window .073, .063, .061; hemisphere directions that subtract what they find
// blocked .133, .088, .085.
vec3 area_arrived(Receiver r, Tangent t, Light light, uint first_point)
{
    vec3 exact = area_irradiance(light, r.position_vs, r.normal_vs, r.geometric_vs);
    float open = 0.0;
    float all = 0.0;
    vec3 normal = area_normal(light, r.position_vs);
    Tangent aimed = with_end_plane(t, normal, dot(light.place_vs, normal));
    // Where nothing blocks, all / all is left of the ratio below.
    bool is_dark = IS_OPEN == 1 || exact == vec3(0.0);
    for (int k = 0; k < DIRECTION_COUNT && !is_dark; ++k) {
        vec3 u = kronecker_point(first_point + uint(k), u_pattern_offset);
        vec3 to_light = area_point(light, u.xy) - r.position_vs;
        float distance = max(length(to_light), 1e-18);
        vec3 w = to_light / distance;
        // Points are uniform over the area: each stands for cos cos' / d^2 of irradiance.
        bool above = dot(w, r.geometric_vs) > 0.0;
        float weight = above ? max(dot(w, r.normal_vs), 0.0) * -dot(normal, w) : 0.0;
        weight /= distance * distance;
        float reach = min(u_radius, distance);
        bool blocked = weight > 0.0 && is_blocked(march(aimed, w, reach, u.z, STEP_COUNT, 0));
        all += weight;
        open += blocked ? 0.0 : weight;
    }
    return all > 0.0 ? exact * (open / all) : exact;
}
#endif

#if SSDO_POINT_COUNT > 0
// How much of parallel light arrives that strays: directions aimed at all of its disk.
float open_part_of_disk(Receiver r, Tangent t, Light light)
{
    const int step_count = LIGHT_STEP_COUNT < 16 ? LIGHT_STEP_COUNT : 16;
    mat3 frame = frame_from_z(light.place_vs);
    float open = 0.0;
    float all = 0.0;
    for (int k = 0; k < DIRECTION_COUNT; ++k) {
        vec3 u = kronecker_point(r.first_point + uint(k), u_pattern_offset);
        vec3 toward = frame * vec3(disk_point(light.numbers.x, u.xy), 1.0);
        bool above = dot(toward, r.geometric_vs) > 0.0;
        float weight = above ? max(dot(toward, r.normal_vs), 0.0) : 0.0;
        bool blocked = weight > 0.0
            && is_blocked(march(t, normalize(toward), u_radius, u.z, step_count, 0));
        all += weight;
        open += blocked ? 0.0 : weight;
    }
    return all > 0.0 ? open / all : 1.0;
}

// A light without an area: RGS09 section 5 puts its samples on the one segment
// of length R towards the light.
vec3 point_lights(Receiver r, Tangent t)
{
    vec3 e = vec3(0.0);
    for (int i = 0; i < SSDO_POINT_COUNT; ++i) {
        Light light = ssdo_light(SSDO_AREA_COUNT + i);
        vec3 unshadowed = unshadowed_irradiance(light, r.position_vs, r.normal_vs, r.geometric_vs);
        vec3 to_light = light.place_vs - r.position_vs;
        float distance = max(length(to_light), 1e-18);
        bool is_distant = light_form(light.kind) == FORM_PARALLEL;
        vec3 w = is_distant ? light.place_vs : to_light / distance;
        float reach = is_distant ? u_radius : min(u_radius, distance);
        bool is_lit = unshadowed != vec3(0.0);
        // Of all lights: it is not to change where another is left out, and with four lights
        // one for each was as noisy (.0512 of the mean).
        float jitter = sample_point(r, 0).z;
        if (is_lit && is_distant && light.numbers.x > 0.0)
            e += unshadowed * open_part_of_disk(r, t, light);
        else if (is_lit && !is_blocked(march(t, w, reach, jitter, LIGHT_STEP_COUNT, 0)))
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
#if KEPT_TEXTURE_COUNT > 0
    keep_nothing();
#endif
    if (r.z_vs > 0.0) {
        Tangent t = tangent_at(r.position_vs, r.geometric_vs);
#if NEEDS_HEMISPHERE
        bool is_open = is_radius_under_a_pixel(r.z_vs);
        Gathered g = Gathered(0.0, vec3(0.0), vec3(0.0), vec3(0.0));
#if FINDS_SECTORS
        vec3 view = toward_camera(r.position_vs);
        float share = estimator_sector_share(r, view);
        for (int i = 0; i < HEMISPHERE_COUNT; ++i)
            gather_slice(g, r, t, view, i, share, is_open);
#else
        // Tested at its end: in software other loops cost two rounds more than they run.
        int i = 0;
        if (HEMISPHERE_COUNT > 0) do {
            Direction d[TOGETHER];
            Blocker b[TOGETHER];
            blockers_of(r, t, i, d, b);
            for (int k = 0; k < TOGETHER; ++k) {
                if (is_open)
                    b[k] = NO_BLOCKER;
                gather(g, t, d[k], b[k]);
#if KEPT_TEXTURE_COUNT > 0
                keep_direction(b[k]);
#endif
            }
        } while ((i += TOGETHER) < HEMISPHERE_COUNT);
#endif
        visibility = max(1.0 - g.blocked, 0.0);
        vec3 sky = environment_arrived(r, g, visibility);
        irradiance = PI * g.areas;
#else
        vec3 sky = vec3(0.0);
#endif
#if GATHERED
        vec4 found = texelFetch(t_gathered_far, receiver_texel(pixel), 0);
        sky = found.a * environment_irradiance(direction_ws_of(r.normal_vs));
        irradiance = PI * found.rgb;
#endif
#if HAS_BAKED_OCCLUSION
        // What an image says of finer things counts where it hides more than was found.
        float baked = texelFetch(t_finish, receiver_texel(pixel), 0).g;
        sky *= min(baked / max(visibility, 1e-3), 1.0);
#endif
        irradiance += sky;
#if SSDO_AREA_COUNT > 0 && !SUMS_OPEN_LIGHT
        for (int i = 0; i < SSDO_AREA_COUNT; ++i)
            irradiance += area_arrived(r, t, ssdo_light(i), r.first_point);
#endif
#if SSDO_POINT_COUNT > 0
        irradiance += point_lights(r, t);
#endif
    }
    o_directional = vec4(irradiance, visibility);
#if KEPT_TEXTURE_COUNT > 0
    write_kept_directions();
#endif
}
