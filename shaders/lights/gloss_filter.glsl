// The highlight of a small light, averaged over a pixel: its neighbours say how the slope of the
// half vector runs across it. GLOSSY, LIGHT_FORM: as in lights/gloss.glsl; FILTERS_GLOSS (default
// 0) chooses it.
#include "lights/gloss_along.glsl"
#include "lights/lights.glsl"
#include "lib/gbuffer.glsl"

#ifndef FILTERS_GLOSS
#define FILTERS_GLOSS 0
#endif

#if LIGHT_FORM != FORM_AREA
vec3 toward_light(Light light, vec3 p_vs)
{
    return LIGHT_FORM == FORM_PARALLEL ? light.place_vs : normalize(light.place_vs - p_vs);
}
#endif

#if GLOSSY && FILTERS_GLOSS && LIGHT_FORM != FORM_AREA
uniform float u_gloss_footprint;  // how much of the way to its neighbours a pixel reaches, px

// Parts along each side of the pixel. The distribution is widened by what is left within one
// (Tokuyoshi and Kaplanyan 2021, in the projected space of half vectors); by the whole pixel
// at once, its tails would be too bright.
const int PARTS = 2;
// Change of the slope, relative to the cosine at which it is seen, from which on a neighbour
// says nothing of what lies between: at silhouettes.
const float MOST_CHANGE = 0.5;
// Sine of the angle with the tangent plane at which a neighbour is another surface's.
const float STEEPEST = 0.7;

// The slope of the half vector at a point, in the plane of its normal.
vec3 half_slope(Light light, vec3 p_vs, vec3 n_vs)
{
    vec3 h = half_vector(n_vs, toward_camera(p_vs), toward_light(light, p_vs));
    return h / max(dot(n_vs, h), 0.1) - n_vs;
}

// By how much the slope at a neighbour differs, in the frame of the normal; 0 where the neighbour
// shows another surface.
vec2 change_of_slope(ivec2 step, Light light, vec3 p_vs, mat3 frame, vec3 slope)
{
    ivec2 own = ivec2(gl_FragCoord.xy);
    ivec2 texel = own + step;
    bool is_outside = any(lessThan(texel, ivec2(0)))
                   || any(greaterThanEqual(texel, ivec2(u_frame_size_px)));
    if (is_outside || !(gbuffer_z_vs(texel) > 0.0)) {
        return vec2(0.0);
    }
    vec3 q_vs = gbuffer_position_vs(texel);
    vec3 m_vs = gbuffer_geometric_normal_vs(own);
    // Between flat faces lies an edge.
    bool is_one = gbuffer_is_smooth(own) && gbuffer_is_smooth(texel)
               || dot(m_vs, gbuffer_geometric_normal_vs(texel)) > 0.999;
    if (!is_one || abs(dot(q_vs - p_vs, m_vs)) > STEEPEST * length(q_vs - p_vs)) {
        return vec2(0.0);
    }
    vec3 change = half_slope(light, q_vs, gbuffer_shading_normal_vs(texel)) - slope;
    vec2 d = vec2(dot(frame[0], change), dot(frame[1], change));
    float most = MOST_CHANGE * cosine_out(frame[2], toward_camera(p_vs));
    return length(d) < most ? d * u_gloss_footprint : vec2(0.0);
}

// GGX of a slope, up to pi and the cosine's fourth power; `a` is its squared width, a symmetric
// matrix of xx, xy and yy.
float ggx_of_slope(vec2 s, vec3 a)
{
    float det = max(a.x * a.z - a.y * a.y, 1e-30);
    float q = 1.0 + (a.z * s.x * s.x - 2.0 * a.y * s.x * s.y + a.x * s.y * s.y) / det;
    return 1.0 / (sqrt(det) * q * q);
}

float distribution_over_pixel(Light light, vec3 p_vs, vec3 n_vs, float alpha)
{
    mat3 frame = frame_from_z(n_vs);
    vec3 slope = half_slope(light, p_vs, n_vs);
    vec2 right = change_of_slope(ivec2(1, 0), light, p_vs, frame, slope);
    vec2 left = change_of_slope(ivec2(-1, 0), light, p_vs, frame, slope);
    vec2 above = change_of_slope(ivec2(0, 1), light, p_vs, frame, slope);
    vec2 below = change_of_slope(ivec2(0, -1), light, p_vs, frame, slope);
    vec2 s = vec2(dot(frame[0], slope), dot(frame[1], slope));
    // Twice the variance of what is spread evenly over a part.
    float spread = 1.0 / (6.0 * float(PARTS * PARTS));
    float sum = 0.0;
    for (int i = 0; i < PARTS * PARTS; ++i) {
        vec2 at = (vec2(i % PARTS, i / PARTS) + 0.5) / float(PARTS) - 0.5;
        vec2 x = at.x > 0.0 ? right : -left;
        vec2 y = at.y > 0.0 ? above : -below;
        vec3 widening = vec3(x.x * x.x + y.x * y.x, x.x * x.y + y.x * y.y, x.y * x.y + y.y * y.y);
        vec3 own = alpha * alpha * vec3(1.0, 0.0, 1.0);
        sum += ggx_of_slope(s + at.x * x + at.y * y, own + spread * widening);
    }
    float per_cosine = 1.0 + dot(s, s);
    return sum * per_cosine * per_cosine * INV_PI / float(PARTS * PARTS);
}
#endif
