// McGuire, Mara and Luebke 2012, "Scalable Ambient Obscurance" (SAO), with the falloff,
// strength and curve that Filament gives it: taps on a spiral in the picture, each counting
// its height above the tangent plane over the square of its distance. A measure of crowding
// that looks like occlusion, not an integral over directions.
//
// Departures. The spiral turns by the golden angle, which is even for any number of taps, in
// place of a table of turns. Depths are read at full resolution, without a pyramid: all
// estimators here read the same texels. What must be cleared is the tangent plane's own
// height, in place of a bias times depth. A radius without end is what the frame shows.
#include "screen_space/occlusion.glsl"

#define FINDS_BLOCKERS 0

const float GOLDEN_TURN = 0.61803398875;
// Nearer than this, relative to R, height over squared distance stops to grow.
const float SAO_PEAK = 0.1;

float estimator_visibility(Receiver r, ivec2 centre)
{
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    float pixel = pixel_height_at(r.z_vs);
    float radius = min(u_radius, max(u_frame_size_px.x, u_frame_size_px.y) * pixel);
    float radius_px = radius / pixel;
    float peak = SAO_PEAK * radius;
    vec2 noise = sample_point(r, 0).xy;
    float obscured = 0.0;
    int i = 0;
    do {
        float turn = 2.0 * PI * fract(float(i) * GOLDEN_TURN + noise.x);
        float share = (float(i) + noise.y) / float(DIRECTION_COUNT);
        float away = max(share * share * radius_px, 1.0);
        ivec2 texel = centre + ivec2(floor(away * vec2(cos(turn), sin(turn)) + 0.5));
        ivec2 inside = clamp(texel, ivec2(0), ivec2(u_frame_size_px) - 1);
        float z = gbuffer_z_vs(inside);
        vec3 to_q = position_vs_at(uv_of_texel(inside), z) - t.position_vs;
        float d2 = dot(to_q, to_q);
        float window = max(1.0 - d2 / (radius * radius), 0.0);
        bool counts = texel == inside && z > 0.0 && is_above(t, vec2(inside) + 0.5, z);
        float tap = window * window * dot(to_q, t.normal_vs) / (d2 + peak * peak);
        obscured += counts ? tap : 0.0;
    } while (++i < DIRECTION_COUNT);
    float root = sqrt(2.0 * PI * peak * obscured / float(DIRECTION_COUNT));
    float left = max(1.0 - root, 0.0);
    return left * left;
}
