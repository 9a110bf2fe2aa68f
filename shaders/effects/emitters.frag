#version 330 core
// Irradiance from glowing bodies that no light of the scene stands for: shadow rays to points of
// them, each chosen among all by how much of its light can arrive.
//
// Close to a body light changes within what the filter takes together. There rays agree, too, and
// all that comes from so near is kept apart from what is filtered.
//
// SUMS_PANELS: all of them are parallelograms of even light, and few. So it is known what each
// sends, and rays to those that send the most tell how much of that arrives (after Heitz, Hill,
// McGuire 2018): where nothing stands before them all rays agree.
//
// Defines: SUMS_PANELS, and as in rays/surface_data.glsl.
#include "rays/glow_that_is_met.glsl"
#include "lib/random.glsl"
#include "lib/z_curve.glsl"

uniform int u_ray_count;
uniform ivec2 u_frame_number;  // number of the frame among those of its picture, and their count
#if !SUMS_PANELS
uniform float u_near_reach;    // half of the light of a body so many pixels away is kept apart
#endif

layout(location = 0) out vec4 o_irradiance;
layout(location = 1) out vec4 o_near;
layout(location = 2) out vec2 o_light;  // of o_irradiance, all colours together, and its variance
layout(location = 3) out vec4 o_whole;  // what o_irradiance is a share of

#if SUMS_PANELS
// As SMALL_LIGHT: the relative error is some 4e-4.
const float SMALL_PANEL = 0.02;

// What a panel sends to the surface if nothing blocks it.
vec3 panel_irradiance(int entry, RaySurface surface)
{
    Emitter panel = emitter_at(entry);
    vec3 u = 0.5 * panel.edge_u.xyz;
    vec3 v = 0.5 * panel.edge_v.xyz;
    vec3 middle = panel.place + u + v - surface.start;
    // On its dark side, and in its plane.
    vec3 normal = cross(u, v);
    float height = -dot(middle, normal);
    if ((panel.two_sided ? abs(height) : height) <= COPLANAR * length(normal))
        return vec3(0.0);
    vec3 horizon = surface.is_smooth ? surface.normal : surface.geometric;
    float f;
    if (is_small_and_above(middle, u, v, surface.normal, horizon, SMALL_PANEL))
        f = integral_by_points(middle, u, v, surface.normal);
    else
        f = parallelogram_cosine_integral(middle, u, v, surface.normal, horizon);
    return panel.power.rgb * max(height > 0.0 ? f : -f, 0.0);
}

// Panels for eight rays, each the likelier the more comes from it.
const int PICKS = 8;

struct Picks {
    vec4 entry[2];
    vec4 light[2];   // of each, all colours together
    vec4 chance[2];  // what is left of as many numbers in [0, 1)
};

// What all send. `chance` spreads the picks over that.
vec3 irradiance_of_panels(RaySurface surface, float chance, out Picks picks)
{
    vec3 whole = vec3(0.0);
    float total = 0.0;
    for (int k = 0; k < 2; ++k) {
        picks.entry[k] = vec4(-1.0);
        picks.light[k] = vec4(0.0);
        picks.chance[k] = (vec4(0.0, 1.0, 2.0, 3.0) + float(4 * k) + chance) / float(min(u_ray_count, PICKS));
    }
    int number = 0;
    do {
        int entry = texelFetch(t_glow_order, row_address(number), 0).x;
        vec3 sent = panel_irradiance(entry, surface);
        float more = dot(sent, vec3(1.0));
        whole += sent;
        total += more;
        float part = more / max(total, 1e-30);
        for (int k = 0; k < 2; ++k) {
            bvec4 takes = lessThan(picks.chance[k], vec4(part));
            picks.entry[k] = mix(picks.entry[k], vec4(entry), takes);
            picks.light[k] = mix(picks.light[k], vec4(more), takes);
            // What is left of each number is one again.
            vec4 other = (picks.chance[k] - part) / max(1.0 - part, 1e-7);
            picks.chance[k] = mix(other, picks.chance[k] / max(part, 1e-30), takes);
            picks.chance[k] = clamp(picks.chance[k], 0.0, 1.0 - FLOAT_EPSILON);
        }
    } while (++number < u_tree_count);
    return whole;
}

// A point of the panel that ray i goes to.
LightSample picked_light(Picks picks, int i, vec3 whole, vec2 u, vec3 p)
{
    int lane = i & 3;
    int pick = i >> 2 & 1;
    int entry = int(picks.entry[pick][lane]);
    if (entry < 0)
        return NO_LIGHT;
    LightSample light = sample_surface_emitter(emitter_at(entry), entry, u, p);
    light.radiance *= dot(whole, vec3(1.0)) / max(picks.light[pick][lane], 1e-30);
    return light;
}
#else
// Spacings of pixels up to which rays spread by the cosine look for a body, too, where a point that was
// drawn is as close; and how large its triangles are at most, as squares of such spacings: of a larger
// one points are drawn by the solid angle.
const float NEAR_SPACINGS = 4.0;
const float SMALL_AREA = 0.25;

// Of light from so far away the part that is kept apart from what is filtered.
float share_of_near(float distance, float reach)
{
    float far = distance / max(reach, 1e-30);
    return 1.0 / (1.0 + far * far * far * far);
}

// How far apart on the surface neighbouring pixels lie, normalised frame.
float pixel_spacing(ivec2 texel, RaySurface surface)
{
    float z = gbuffer_z_vs(texel);
    return pixel_height_at(z) * u_ns_per_unit / max(dot(surface.geometric, surface.w_out), 0.05);
}
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_irradiance = o_near = vec4(0.0, 0.0, 0.0, 1.0);
    o_whole = vec4(1.0);
    o_light = vec2(0.0);
    if (gbuffer_z_vs(texel) <= 0.0)
        return;
    RaySurface surface = ray_surface_at(texel);
    uint first = first_point(texel, u_ray_count * u_frame_number.y)
               + uint(u_ray_count * u_frame_number.x);
#if SUMS_PANELS
    Picks picks;
    o_whole.rgb = irradiance_of_panels(surface, random_2d(first, u_stream, 0u, false).x, picks);
#else
    float spacing = pixel_spacing(texel, surface);
    float reach_of_near = u_near_reach * spacing;
    float near_reach = NEAR_SPACINGS * spacing;
    float most_area = SMALL_AREA * spacing * spacing;
    bool is_close = false;
#endif
    vec3 sent = vec3(0.0);
    vec3 sum = vec3(0.0);
    vec3 near = vec3(0.0);
    vec2 squares = vec2(0.0);  // of what arrives, and of what is sent
    int i = 0;
    do {
        vec2 u = random_2d(first + uint(i), u_stream, 1u, false);
#if SUMS_PANELS
        LightSample light = picked_light(picks, i, o_whole.rgb, u, surface.start);
#else
        vec2 choice = random_2d(first + uint(i), u_stream, 0u, false);
        float area;
        LightSample light = sample_tree(lit_point(surface.start, surface.normal), choice, u, area);
#endif
        vec3 arriving = unblocked_irradiance(surface, light);
#if !SUMS_PANELS
        bool is_near = light.density > 0.0 && light.distance < near_reach && area <= most_area;
        is_close = is_close || is_near;
#endif
        float reach = is_dark(arriving) ? -1.0 : reach_toward_light(light.distance);
#if SUMS_PANELS
        sent += arriving;
        squares.y += dot(arriving, vec3(1.0)) * dot(arriving, vec3(1.0));
        arriving = light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
#else
        float share = is_near ? share_of_drawn(surface, light, near_reach) : 1.0;
        arriving = arriving_light(surface, light.w, reach, share * arriving, arriving);
        vec3 kept = share_of_near(light.distance, reach_of_near) * arriving;
        near += kept;
        arriving -= kept;
#endif
        float found = dot(arriving, vec3(1.0));
        squares.x += found * found;
        sum += arriving;
    } while (++i < u_ray_count);
    float n = float(u_ray_count);
    float all = dot(sum, vec3(1.0));
#if SUMS_PANELS
    float of_all = 1.0 / max(dot(sent, vec3(1.0)), 1e-30);
    float share = all * of_all;
    o_irradiance.rgb = mix(vec3(share), sum / max(sent, 1e-30), greaterThan(sent, vec3(0.0)));
    // Each ray brings all or nothing of its light.
    float variance = dot(squares * of_all * of_all, vec2(1.0 - 2.0 * share, share * share));
    // Where a few of them bring most of it, they agree by chance.
    float uneven = max(squares.y * of_all * of_all - 1.0 / n, 0.0);
    o_light = vec2(share, max(variance, 0.0) * n / (n - 1.0) + uneven);
#else
    float spread = max(squares.x - all * all / n, 0.0);
    for (int j = 0; j < (is_close ? u_ray_count : 0); ++j) {
        vec3 w = frame_from_z(surface.normal) * cosine_hemisphere(random_2d(first + uint(j), u_stream, 2u, false));
        if (dot(w, surface.geometric) <= 0.0)
            continue;
        float distance;
        vec3 met = glow_nearby(surface, w, near_reach, most_area, distance);
        vec3 kept = share_of_near(distance, reach_of_near) * met;
        near += kept;
        sum += met - kept;
        float found = dot(met - kept, vec3(1.0));
        spread += found * found;
    }
    o_irradiance.rgb = sum / n;
    o_near.rgb = near / n;
    o_light = vec2(dot(sum, vec3(1.0)) / n, spread / (n * (n - 1.0)));
#endif
    // Of one ray nothing is known.
    o_light.g = u_ray_count > 1 ? o_light.g : 1e30;
}
