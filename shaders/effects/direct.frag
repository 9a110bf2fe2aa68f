#version 330 core
// Irradiance from one light, times the part that its shadow map lets through. Drawn once
// for each light, adding up.
//
// LIGHT_KIND, LIGHT_FORM: as in lights/lights.glsl. CASTS_SHADOW: by its map or rays. IS_SOFT: its
// shadows have penumbrae. BLOCKER_COUNT, FILTER_COUNT: see lights/area_shadow.glsl.
// HAS_SHADING_NORMALS: see lights/lights.glsl.
// HAS_LIFT: smooth surfaces are shadowed from where they would be, not from their triangles.
// <shadow_edge>: who decides where texels of a map disagree, see shadow_edges/.
// IS_OPEN: where it is drawn, nothing stands before the light.
// GLOSSY: surfaces may be glossy, and what they reflect of the light goes to a target of its own.
#include "lib/gbuffer.glsl"
#include "lights/area_shadow.glsl"
#include "lights/gloss.glsl"
#include <shadow_edge>

uniform vec4 u_light[LIGHT_ROWS];
#if HAS_LIFT
uniform sampler2D t_lift_vs;
#endif

layout(location = 0) out vec4 o_irradiance;
#if GLOSSY
layout(location = 1) out vec4 o_gloss;  // radiance; alpha 0: senders do not pass it on
#endif

// Light that grazes a triangle by less than this cosine finds its map of little use: what
// stands before it barely rises over the tangent plane.
const float GRAZING = 0.01;

// Whether any of the light is below the horizon of the plane across m, or grazes it.
bool is_partly_below(Light light, vec3 p_vs, vec3 m_vs)
{
#if LIGHT_FORM == FORM_PARALLEL
    return dot(light.place_vs, m_vs) <= light.numbers.x + GRAZING;
#else
    vec3 to_light = light.place_vs - p_vs;
    return dot(to_light, m_vs) <= GRAZING * length(to_light) + half_extent_along(light, m_vs);
#endif
}

// What is left of the light, all of which may be below the horizon of the lifted point: it
// fades from where its top is half as high over that as over the point itself.
float fade_of_lift(Light light, vec3 p_vs, vec3 n_vs, float lift)
{
#if LIGHT_FORM == FORM_PARALLEL
    return 1.0;
#else
    float top = dot(light.place_vs - p_vs, n_vs) + half_extent_along(light, n_vs);
    return clamp(2.0 * (top - lift) / max(top, 1e-30), 0.0, 1.0);
#endif
}

#if GLOSSY && LIGHT_FORM == FORM_AREA
// Low and high corner of what the lobe sees of a rectangle, from -1 to 1 along its edges.
vec4 seen_by_lobe(Brdf brdf, Light light, vec3 p_vs, vec3 n_vs)
{
    vec3 w_out = toward_camera(p_vs);
    Lobe lobe = lobe_of(n_vs, w_out, cosine_out(n_vs, w_out), alpha_of(brdf.roughness));
    return seen_of_rectangle(lobe_on_plane(lobe, light.place_vs - p_vs, light.axis_vs, light.second_axis_vs));
}

Light part_of_rectangle(Light light, vec4 corners)
{
    vec2 middle = 0.5 * (corners.xy + corners.zw);
    vec2 half_size = 0.5 * (corners.zw - corners.xy);
    light.place_vs += middle.x * light.axis_vs + middle.y * light.second_axis_vs;
    light.axis_vs *= half_size.x;
    light.second_axis_vs *= half_size.y;
    return light;
}
#endif

// Of the light's irradiance, and of what the glossy lobe sees of the light. Of a light without a
// size `whole` leaves out what is translucent.
vec2 shadow_visibility(Light light, vec3 p_vs, vec3 m_vs, vec3 n_vs, ivec2 pixel,
                       bool is_surface, bool is_lifted, bool whole)
{
    ShadowMap map = shadow_map_from_rows(u_light);
    vec3 p_ls = map.light_from_view * (p_vs - map.origin_vs);
    vec3 m_ls = map.light_from_view * m_vs;
    float rounding = SHADOW_ROUNDING * (largest_component(p_vs) + largest_component(map.origin_vs));
#if LIGHT_FORM == FORM_AREA
    vec2 half_u = (map.light_from_view * light.axis_vs).xy;
    vec2 half_v = (map.light_from_view * light.second_axis_vs).xy;
    vec4 seen = vec4(0.0);
    bool is_reflecting = false;
#if GLOSSY
    Brdf brdf = brdf_at(pixel);
    is_reflecting = is_surface && is_glossy(brdf);
    seen = seen_by_lobe(brdf, light, p_vs, n_vs);
#endif
    return area_shadow_visibility(map, p_ls, m_ls, rounding, half_u, half_v, pixel, is_surface,
                                  is_reflecting, seen);
#elif IS_SOFT
    return vec2(
        disk_shadow_visibility(map, p_ls, m_ls, rounding, light.numbers.x, pixel, is_surface));
#else
    float far_texels = is_lifted ? FLOAT_MAX : SHADOW_FAR_TEXELS;
    return vec2(point_shadow_visibility(map, p_ls, m_ls, rounding, far_texels, whole));
#endif
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    bool is_surface = gbuffer_z_vs(texel) > 0.0;
#if !(CASTS_SHADOW && IS_SOFT) || IS_OPEN || TRACES_PENUMBRAE
    // Only the soft shadow of a map needs its neighbours to go on.
    if (!is_surface) {
        o_irradiance = vec4(0.0);
#if GLOSSY
        o_gloss = vec4(0.0);
#endif
        return;
    }
#endif
    Light light = light_from_rows(vec4[](u_light[0], u_light[1], u_light[2], u_light[3], u_light[4]));
    light.kind = LIGHT_KIND;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 m_vs = gbuffer_geometric_normal_vs(texel);
#if HAS_SHADING_NORMALS
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
#else
    vec3 n_vs = m_vs;
#endif
    vec3 horizon_vs = n_vs;
#if CASTS_SHADOW
    // The triangle's own horizon would cut a smooth surface off facet by facet. Beyond it,
    // what bulges is lit as the surface would be that lies above; what does not is in the
    // triangle's own shadow, which no map shows.
    horizon_vs = m_vs;
    vec3 shadowed_vs = p_vs;
    bool is_lifted = false;
    float lift = 0.0;
#if HAS_LIFT
    lift = texelFetch(t_lift_vs, texel, 0).x;
    is_lifted = lift > 0.0 && is_partly_below(light, p_vs, m_vs);
    horizon_vs = is_lifted ? n_vs : m_vs;
    shadowed_vs += is_lifted ? lift * n_vs : vec3(0.0);
#endif
#endif
    vec3 irradiance = unshadowed_irradiance(light, p_vs, n_vs, horizon_vs);
    vec2 visibility = vec2(1.0);
#if CASTS_SHADOW && !IS_OPEN
    // In a light's own plane, where it gives nothing, visibility has no meaning.
    bool is_lit = is_surface && largest_component(irradiance) > 0.0;
#if TRACES_PENUMBRAE
    visibility = is_lit ? penumbra(light, n_vs, horizon_vs, lift, texel) : vec2(1.0);
#if GLOSSY && LIGHT_FORM == FORM_AREA
    // Where all or nothing of a rectangle is open, so is what the lobe sees of it.
    Brdf brdf = brdf_at(texel);
    if (is_glossy(brdf) && visibility.x > 0.0 && visibility.x < 1.0) {
        Light seen = part_of_rectangle(light, seen_by_lobe(brdf, light, p_vs, n_vs));
        visibility.y = penumbra(seen, n_vs, horizon_vs, lift, texel).x;
    }
#endif
#else
    visibility = shadow_visibility(
        light, shadowed_vs, horizon_vs, n_vs, texel, is_surface, is_lifted, false);
    bool is_edge = visibility.x > 0.0 && visibility.x < 1.0 && is_lit;
#if HAS_WHOLE_MAP
    // Texels of what lets light by disagree by chance: only together they say how much of it. Rays in
    // place of those that do would leave .06 of the light behind an alpha of .9.
    if (is_edge) {
        float alone = shadow_visibility(
            light, shadowed_vs, horizon_vs, n_vs, texel, is_surface, is_lifted, true).x;
        is_edge = alone > 0.0 && alone < 1.0;
    }
#endif
    visibility = shadow_edge(light, texel, is_edge, visibility);
#endif
#if HAS_LIFT
    visibility *= is_lifted ? fade_of_lift(light, p_vs, n_vs, lift) : 1.0;
#endif
    irradiance = largest_component(irradiance) > 0.0 ? irradiance * visibility.x : vec3(0.0);
#endif
#if GLOSSY
    LightGloss reflected = gloss_of_light(
        brdf_at(texel), light, p_vs, n_vs, irradiance, visibility);
    irradiance = reflected.irradiance;
    o_gloss = vec4(is_surface ? reflected.radiance : vec3(0.0), 0.0);
#endif
    o_irradiance = vec4(is_surface ? irradiance : vec3(0.0), 0.0);
}
