#version 330 core
// Directional occlusion: irradiance that arrives through open directions,
//   E(P) = integral of L_in(w) V_R(w) cos(theta) dw,
// L_in = environment and the lights that arrive through SSDO.
//
// Defines: ESTIMATOR 0 march, 1 rgs09; DIRECTION_COUNT, STEP_COUNT, HAS_BACK_LAYER;
// ENVIRONMENT_KIND (see lib/environment.glsl).
#include "lib/estimator.glsl"
#include "lib/environment.glsl"

layout(location = 0) out vec4 o_directional;  // rgb irradiance, a visibility

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, DIRECTION_COUNT);
    vec3 irradiance = vec3(0.0);
    float visibility = 1.0;
    if (r.z_vs > 0.0) {
        Tangent t = tangent_at(r.position_vs, r.geometric_vs);
        bool is_open = is_radius_under_a_pixel(r.z_vs);
        float blocked = 0.0;
        vec3 open_light = vec3(0.0);     // sum of share * L_in over open directions
        vec3 all_light = vec3(0.0);      // the same over all
        for (int i = 0; i < DIRECTION_COUNT; ++i) {
            Direction d = direction_of(r, i);
            bool hit = !is_open && blocker_of(t, d, u_radius) != NO_BLOCKER;
            blocked += hit ? d.share : 0.0;
#if ENVIRONMENT_KIND > 1
            vec3 light = d.share * environment_radiance(direction_ws_of(d.w_vs));
            open_light += hit ? vec3(0.0) : light;
            all_light += light;
#endif
        }
        visibility = max(1.0 - blocked, 0.0);
        vec3 exact = environment_irradiance(direction_ws_of(r.normal_vs));
#if ENVIRONMENT_KIND > 1
        irradiance = max(PI * open_light + visibility * (exact - PI * all_light), vec3(0.0));
#else
        irradiance = exact * visibility;
#endif
    }
    o_directional = vec4(irradiance, visibility);
}
