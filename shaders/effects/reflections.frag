#version 330 core
// What glossy surfaces reflect: the mean radiance that their lobe takes in,
//   L = integral of gloss(w_out, w) cos L_in(w) dw / integral of gloss(w_out, w) cos dw,
// L_in = what a march through the depth layers meets along w, else the environment. Without
// the surface's own reflectance, images on surfaces stay sharp when noise is filtered.
//
// Smooth surfaces march as far as the picture goes; rough ones within R, as visibility is
// defined: there the open directions that SSDO finds are weighted by the lobe. Where there are
// rays all trace them.
//
// Defines: SAMPLE_COUNT, STEP_COUNT, REFINE_COUNT, HAS_BACK_LAYER; GATHERS_SENDERS 0: what
// blocks a direction is black; <beyond_screen>: rays, or that there are none; ENVIRONMENT_KIND:
// as in lib/environment.glsl.
#define GLOSSY 1
#define IS_OPEN 0
#include "lib/brdf.glsl"
#include "screen_space/receiver.glsl"
#include "screen_space/march.glsl"
#include "lib/finite.glsl"
#include "lib/environment_lobes.glsl"

uniform float u_max_roughness;  // of surfaces that reflect what lies beyond R

#include <beyond_screen>

#if GATHERS_SENDERS
// Depth, relative to itself, up to which what a texel shows is one surface.
const float MET_DEPTH = 0.02;

uniform sampler2D t_sender_radiance;
uniform float u_hidden_senders;
uniform float u_sender_bound;
#endif
layout(location = 0) out vec4 o_reflections;  // mean radiance; alpha: z, 0 where nothing is glossy

// Where a lobe is brightest: rough ones lean from the mirrored direction to the normal
// (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listing 22).
vec3 lobe_axis(vec3 normal, vec3 mirrored, float alpha)
{
    float smoothness = 1.0 - alpha;
    return normalize(mix(normal, mirrored, smoothness * (sqrt(smoothness) + alpha)));
}

#if GATHERS_SENDERS
vec3 sent_from(ivec2 texel, vec3 to_receiver)
{
    vec3 radiance = texelFetch(t_sender_radiance, texel, 0).rgb;
    float largest = max(radiance.r, max(radiance.g, radiance.b));
    float factor = largest > u_sender_bound ? u_sender_bound / largest : 1.0;
    bool is_light = is_finite(radiance) && all(greaterThanEqual(radiance, vec3(0.0)));
    bool faces = gbuffer_faces(texel, to_receiver);
    return is_light ? radiance * factor * (faces ? 1.0 : u_hidden_senders) : vec3(0.0);
}

// Whether a ray meets the surface that the texel shows, and does not pass behind it: the
// picture shows that surface where the ray crosses its plane, too.
bool is_met(vec3 p_vs, vec3 w, ivec2 texel)
{
    vec3 m = gbuffer_geometric_normal_vs(texel);
    float rate = dot(w, m);
    float t = abs(rate) > 1e-6 ? dot(gbuffer_position_vs(texel) - p_vs, m) / rate : -1.0;
    vec3 crossing = p_vs + t * w;
    vec2 px = px_of_position_vs(crossing);
    bool is_shown = t > 0.0 && all(greaterThanEqual(px, vec2(0.0))) && all(lessThan(px, u_frame_size_px));
    float z = is_shown ? gbuffer_z_vs(ivec2(px)) : 0.0;
    return abs(z + crossing.z) < MET_DEPTH * z;
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, SAMPLE_COUNT);
    Brdf brdf = brdf_at(receiver_texel(pixel));
    o_reflections = vec4(0.0);
    if (!(r.z_vs > 0.0) || !is_glossy(brdf)) {
        return;
    }
    vec3 w_out = toward_camera(r.position_vs);
    float alpha = alpha_of(brdf.roughness);
    bool is_smooth = brdf.roughness <= u_max_roughness;
    float reach = is_smooth ? FAR_REACH * r.z_vs : u_radius;
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    // Samples share the lobe: each stands for a narrower one.
    float share_alpha = alpha * inversesqrt(float(SAMPLE_COUNT));
    vec3 all = vec3(0.0);
    vec3 open = vec3(0.0);
    vec3 sent = vec3(0.0);
    vec3 whole = vec3(0.0);
    // Tested at its end: in software other loops cost two rounds more than they run.
    int i = 0;
    do {
        vec3 u = sample_point(r, i);
        BrdfSample facet = gloss_sample(brdf, r.normal_vs, w_out, u.xy);
        vec3 w = facet.w_in;
        vec3 weight = facet.weight;
        // Facets of what stands for a smooth surface do not hide each other.
        w -= min(2.0 * dot(w, r.geometric_vs), 0.0) * r.geometric_vs;
        vec3 sky = weight * lobe_radiance(direction_ws_of(w), share_alpha);
        Blocker b = NO_BLOCKER;
        if (!(TRACES_SMOOTH && is_smooth))
            b = march(t, w, reach, u.z, STEP_COUNT, REFINE_COUNT);
        all += sky;
        whole += weight;
        bool is_near = is_blocked(b);
#if GATHERS_SENDERS
        if (is_near && weight != vec3(0.0)) {
            vec3 found = sent_from(b.texel, r.position_vs - gbuffer_position_vs(b.texel));
            sent += weight * found;
            // Lamps send nothing, because lights deliver it: seen behind one, the ray goes on.
            is_near = !is_smooth || found != vec3(0.0) || is_met(r.position_vs, w, b.texel);
        }
#endif
        vec3 beyond = vec3(0.0);
        bool is_far = TRACES_SMOOTH && is_smooth && weight != vec3(0.0)
                   && meets_by_ray(r.position_vs, r.geometric_vs, w, facet.density, brdf.roughness, uint(i), beyond);
        sent += weight * beyond;
        open += is_near || is_far ? vec3(0.0) : sky;
    } while (++i < SAMPLE_COUNT);
    vec3 mirrored = reflect(-w_out, r.normal_vs);
    vec3 axis = direction_ws_of(lobe_axis(r.normal_vs, mirrored, alpha));
    // The exact light, as far as the sampled one arrives: without noise where all is open.
    vec3 arrived = lobe_radiance(axis, alpha) * (open / max(all, vec3(1e-30)));
    // Few directions do not weigh together what all do: it is the mean that matters.
    vec3 met = sent / max(whole, vec3(1e-4));
    met += glow_in_lobe(receiver_texel(pixel), brdf, TRACES_SMOOTH && is_smooth);
    o_reflections = vec4(arrived + met, r.z_vs);
}
