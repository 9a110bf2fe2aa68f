// What lobes reflect of glowing bodies: by shadow rays to points of them, and by rays of the lobe
// that meet them. Both count, weighted against each other by the balance heuristic (Veach 1997):
// rays of a narrow lobe find its image, points chosen from a tree find small bodies in a wide one.
//
// Where all of them are panels of even light, and few, it is known what the lobe reflects of them if
// nothing stands before them, and rays to points that it sees of them tell how much does.
//
// SAMPLE_COUNT: rays of the lobe. GLOW_IS_DIRECT 0: there are none. SUMS_PANELS 1: they are such panels.
#include "rays/glow_that_is_met.glsl"
#include "lights/gloss_of_rectangle.glsl"
#include "lib/z_curve.glsl"

#if GLOW_IS_DIRECT
uniform int u_glow_rays;

LitPoint lit_point_of_lobe(vec3 p, ivec2 texel)
{
    vec3 normal = u_ns_from_vs * gbuffer_shading_normal_vs(texel);
    vec3 w_out = u_ns_from_vs * toward_camera(gbuffer_position_vs(texel));
    vec3 mirrored = 2.0 * cosine_out(normal, w_out) * normal - w_out;
    return LitPoint(p, normal, w_out, normalize(mirrored), alpha_of(brdf_at(texel).roughness));
}

#if SUMS_PANELS
// A panel as seen from a surface: its centre and half of its edges. `is_lit`: by its bright side.
struct Panel {
    vec3 middle;
    vec3 u;
    vec3 v;
    vec3 radiance;
    bool is_lit;
};

Panel panel_before(int entry, LitPoint r)
{
    Emitter e = emitter_at(entry);
    vec3 u = 0.5 * e.edge_u.xyz;
    vec3 v = 0.5 * e.edge_v.xyz;
    vec3 middle = e.place + u + v - r.p;
    vec3 normal = cross(u, v);
    float height = -dot(middle, normal);
    float top = dot(middle, r.normal) + abs(dot(u, r.normal)) + abs(dot(v, r.normal));
    bool faces = (e.two_sided ? abs(height) : height) > COPLANAR * length(normal);
    return Panel(middle, u, v, e.power.rgb, faces && top > 0.0);
}

// A lobe is even over a panel from so many times its half width on, beside it or around it.
const float BESIDE = 4.0;
const float AROUND = 2.0;
// Panels as large as this, half an edge over the distance, are never so seen.
const float LARGE = 0.5;

bool is_evenly_seen(Panel panel, LobeOnPlane lobe)
{
    bool is_beside = !lobe.is_met || any(greaterThan(abs(lobe.middle), 1.0 + BESIDE * lobe.half_size));
    bool is_within = lobe.is_met && all(greaterThan(lobe.half_size, vec2(AROUND)));
    float size_2 = max(dot(panel.u, panel.u), dot(panel.v, panel.v));
    return (is_beside || is_within) && size_2 < LARGE * LARGE * dot(panel.middle, panel.middle);
}

// What a lobe reflects of a panel that it sees evenly.
vec3 gloss_of_four_points(Brdf brdf, LitPoint r, Panel panel)
{
    vec3 uv = cross(panel.u, panel.v);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 place = vec2(ivec2(i, i >> 1) & 1) * 2.0 - 1.0;
        vec3 p = panel.middle + GAUSS_POINT * (place.x * panel.u + place.y * panel.v);
        float inverse = inversesqrt(max(dot(p, p), 1e-30));
        float solid_angle = abs(dot(uv, p)) * inverse * inverse * inverse;
        sum += gloss_times_cosine(brdf, r.normal, r.w_out, p * inverse) * solid_angle;
    }
    return sum;
}

// If nothing stands before them. `picked`: four entries, each the likelier the more comes from it, by
// as many numbers in [0, 1).
vec3 gloss_of_panels(Brdf brdf, LitPoint r, Lobe lobe, vec4 chance, out vec4 picked)
{
    vec3 sum = vec3(0.0);
    float total = 0.0;
    picked = vec4(-1.0);
    for (int i = 0; i < u_tree_count; ++i) {
        int entry = texelFetch(t_glow_order, row_address(i), 0).x;
        Panel panel = panel_before(entry, r);
        bool is_even = is_evenly_seen(panel, lobe_on_plane(lobe, panel.middle, panel.u, panel.v));
        vec3 reflected = vec3(0.0);
        // Loops, because a software renderer goes through branches that none of its pixels take.
        for (int k = panel.is_lit && is_even ? 1 : 0; k > 0; --k)
            reflected = panel.radiance * gloss_of_four_points(brdf, r, panel);
        for (int k = panel.is_lit && !is_even ? 1 : 0; k > 0; --k)
            reflected = panel.radiance * gloss_of_rectangle(brdf, panel.middle, panel.u, panel.v, r.normal, r.w_out);
        sum += reflected;
        float more = dot(reflected, vec3(1.0));
        total += more;
        float part = more / max(total, 1e-30);
        bvec4 takes = lessThan(chance, vec4(part));
        picked = mix(picked, vec4(entry), takes);
        // What is left of each number is one again.
        chance = mix((chance - part) / max(1.0 - part, 1e-7), chance / max(part, 1e-30), takes);
        chance = clamp(chance, 0.0, 1.0 - FLOAT_EPSILON);
    }
    return sum;
}

// Mean radiance that the lobe of a pixel takes in from panels: all that it reflects of them, as far as
// it arrives.
vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    RaySurface surface = ray_surface_at(texel);
    LitPoint r = lit_point_of_lobe(surface.start, texel);
    vec3 whole = layer_reflectance(brdf, cosine_out(r.normal, r.w_out));
    Lobe lobe = lobe_of(r.normal, r.w_out, cosine_out(r.normal, r.w_out), r.alpha);
    uint first = first_point(texel, u_glow_rays);
    vec4 picked;
    vec4 chance = vec4(0.0, 1.0, 2.0, 3.0) + random_2d(first, u_stream, 2u, false).x;
    chance /= float(min(u_glow_rays, 4));
    vec3 sum = gloss_of_panels(brdf, r, lobe, chance, picked);
    vec3 sent = vec3(0.0);
    vec3 arriving = vec3(0.0);
    for (int i = 0; i < u_glow_rays; ++i) {
        int entry = int(picked[i & 3]);
        if (entry < 0)
            continue;
        Panel panel = panel_before(entry, r);
        vec4 seen = seen_of_rectangle(lobe_on_plane(lobe, panel.middle, panel.u, panel.v));
        vec2 u = random_2d(first + uint(i), u_stream, 3u, false);
        vec2 place = mix(seen.xy, seen.zw, u);
        vec3 to_point = panel.middle + place.x * panel.u + place.y * panel.v;
        float distance = length(to_point);
        vec3 w = to_point / max(distance, 1e-30);
        bool is_above = surface.is_smooth || dot(w, surface.geometric) > 0.0;
        vec3 light = is_above && dot(w, r.normal) > 0.0 ? panel.radiance : vec3(0.0);
        light /= max(dot(light, vec3(1.0)), 1e-30);
        sent += light;
        float reach = is_dark(light) ? -1.0 : reach_toward_light(distance);
        arriving += light_is_blocked(surface, w, reach) ? vec3(0.0) : light;
    }
    return sum * (arriving / max(sent, vec3(1e-30))) / max(whole, vec3(1e-4));
}
#else
// Mean radiance that the lobe of a pixel takes in from points of glowing bodies. `is_met`: rays of
// the lobe meet them, too.
vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    RaySurface surface = ray_surface_at(texel);
    LitPoint r = lit_point_of_lobe(surface.start, texel);
    vec3 whole = layer_reflectance(brdf, cosine_out(r.normal, r.w_out));
    uint first = first_point(texel, u_glow_rays);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_glow_rays; ++i) {
        vec2 choice = random_2d(first + uint(i), u_stream, 2u, false);
        vec2 u = random_2d(first + uint(i), u_stream, 3u, false);
        LightSample light = sample_tree(r, choice, u);
        float found = gloss_density(brdf, r.normal, r.w_out, light.w) * float(SAMPLE_COUNT);
        float chosen = light.density * float(u_glow_rays);
        float share = is_met ? chosen / max(chosen + found, 1e-30) : 1.0;
        vec3 response = gloss_times_cosine(brdf, r.normal, r.w_out, light.w);
        vec3 reflected = unblocked_light(surface, light, response);
        float reach = is_dark(reflected) ? -1.0 : reach_toward_light(light.distance);
        sum += arriving_light(surface, light.w, reach, share * reflected, reflected);
    }
    return sum / max(whole, vec3(1e-4)) / float(max(u_glow_rays, 1));
}
#endif
#else
vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    return vec3(0.0);
}
#endif
