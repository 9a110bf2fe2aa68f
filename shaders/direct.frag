#version 330 core
// Irradiance from the scene's lights, each times the part that its shadow map lets through.
// Lights marked "ssdo" arrive through open directions instead (directional.frag).
//
// HAS_SHADOW_MAPS: some light has one. BLOCKER_COUNT, FILTER_COUNT: see lib/shadow.glsl.
#include "lib/gbuffer.glsl"
#include "lib/shadow.glsl"

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_irradiance = vec4(0.0);
    if (gbuffer_z_vs(texel) <= 0.0) {
        return;
    }
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    vec3 m_vs = gbuffer_geometric_normal_vs(texel);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_light_count; ++i) {
        Light light = light_at(i);
        if (light.shadow == SHADOW_SSDO) {
            continue;
        }
        vec3 irradiance = unshadowed_irradiance(light, p_vs, n_vs, m_vs);
#if HAS_SHADOW_MAPS
        if (light.shadow == SHADOW_MAP && largest_component(irradiance) > 0.0) {
            irradiance *= shadow_map_visibility(i, light, p_vs, m_vs, texel);
        }
#endif
        sum += irradiance;
    }
    o_irradiance = vec4(sum, 1.0);
}
