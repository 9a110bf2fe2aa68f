#version 330 core
// Irradiance from one light, times the part that its shadow map lets through. Drawn once
// for each light, adding up.
//
// LIGHT_KIND, LIGHT_FORM: as in lights/lights.glsl. HAS_SHADOW_MAP: look it up. IS_SOFT: its
// shadows have penumbrae. BLOCKER_COUNT, FILTER_COUNT: see lights/shadow.glsl. HAS_SHADING_NORMALS: see lights/lights.glsl.
#include "lib/gbuffer.glsl"
#include "lights/shadow.glsl"

uniform vec4 u_light[LIGHT_ROWS];

layout(location = 0) out vec4 o_irradiance;

float shadow_visibility(Light light, vec3 p_vs, vec3 m_vs, ivec2 pixel, bool is_surface)
{
    ShadowMap map = shadow_map_from_rows(u_light);
    vec3 p_ls = map.light_from_view * (p_vs - map.origin_vs);
    vec3 m_ls = map.light_from_view * m_vs;
    float rounding = SHADOW_ROUNDING * (largest_component(p_vs) + largest_component(map.origin_vs));
#if LIGHT_FORM == FORM_AREA
    vec2 half_u = (map.light_from_view * light.axis_vs).xy;
    vec2 half_v = (map.light_from_view * light.second_axis_vs).xy;
    return area_shadow_visibility(map, p_ls, m_ls, rounding, half_u, half_v, pixel,
                                       is_surface);
#elif IS_SOFT
    return disk_shadow_visibility(map, p_ls, m_ls, rounding, light.numbers.x, pixel, is_surface);
#else
    return point_shadow_visibility(map, p_ls, m_ls, rounding);
#endif
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    bool is_surface = gbuffer_z_vs(texel) > 0.0;
#if !(HAS_SHADOW_MAP && IS_SOFT)
    // Only the soft shadow needs its neighbours to go on.
    if (!is_surface) {
        o_irradiance = vec4(0.0);
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
    vec3 irradiance = unshadowed_irradiance(light, p_vs, n_vs, m_vs);
#if HAS_SHADOW_MAP
    // In a light's own plane, where it gives nothing, visibility has no meaning.
    float visibility = shadow_visibility(light, p_vs, m_vs, texel, is_surface);
    irradiance = largest_component(irradiance) > 0.0 ? irradiance * visibility : vec3(0.0);
#endif
    o_irradiance = vec4(is_surface ? irradiance : vec3(0.0), 0.0);
}
