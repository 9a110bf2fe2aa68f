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

#if GLOSSY && LIGHT_FORM != FORM_AREA
// The slope of the half vector at a point, in the plane of its normal.
vec3 half_slope(Light light, vec3 p_vs, vec3 n_vs)
{
    vec3 h = half_vector(n_vs, toward_camera(p_vs), toward_light(light, p_vs));
    return h / max(dot(n_vs, h), 0.1) - n_vs;
}

// Mean of (1 + s^2)^-2 over a disk of this radius at s, a form factor as well.
float mean_over_disk(vec2 s, float radius)
{
    float radius_2 = radius * radius;
    float p = 1.0 + dot(s, s) - radius_2;
    float r = sqrt(p * p + 4.0 * radius_2);
    return p > 0.0 ? 2.0 / (r * (r + p)) : (r - p) / (2.0 * r * radius_2);
}

// Slopes of the half vectors to a disk of light, in widths of the distribution: two half diameters of
// an ellipse. A mirrored disk is as round as it is, but where it grazes, facets that lean to the side turn
// light by less than those that lean forth.
mat2 half_disk(Light light, vec3 p_vs, mat3 frame, float alpha)
{
    mat2 axes = mat2(0.0);
#if LIGHT_FORM == FORM_PARALLEL
    vec3 h = transpose(frame) * (toward_camera(p_vs) + light.place_vs);
    float inverse = 1.0 / max(0.1 * length(h), max(h.z, 1e-6));
    mat3 across = transpose(frame) * frame_from_z(light.place_vs) * (light.numbers.x * inverse / alpha);
    axes = mat2(across[0].xy - h.xy * (across[0].z * inverse),
                across[1].xy - h.xy * (across[1].z * inverse));
#endif
    return axes;
}

// The radius of a disk that spreads as far as an ellipse, on average.
float mean_radius(mat2 axes)
{
    return sqrt(0.5 * (dot(axes[0], axes[0]) + dot(axes[1], axes[1])));
}

// Parts of a pixel that are smaller than this, in widths of the distribution, or so much nearer
// to each other than to its middle, have the value of their own middle.
const float SMALL = 0.5;
const float FAR = 8.0;
// Ellipses narrower than this count as disks.
const float LEAST_ELLIPSE = 0.25;

// Share of the sphere's half that the edge from a to b of a polygon at height 1 adds: Lambert's
// formula, of which GGX of width 1 is the integrand, since both are 1 / (1 + s^2)^2.
float edge_share(vec2 a, vec2 b)
{
    vec3 across = cross(vec3(a, 1.0), vec3(b, 1.0));
    float sine = length(across);
    return atan(sine, dot(a, b) + 1.0) * across.z / max(sine, 1e-30);
}

const int SIDES = 16;
// Of a regular polygon's corners from its middle, where a disk of the same area has a radius of 1.
const float CORNER = 1.0130;

// Mean of (1 + s^2)^-2 over an ellipse about s with these half diameters: of a polygon as large.
float mean_over_ellipse(vec2 s, mat2 axes)
{
    float radius = mean_radius(axes);
    bool is_large = radius > LEAST_ELLIPSE && length(s) < FAR * radius;
    float sum = 0.0;
    vec2 corner = s + CORNER * axes[0];
    for (int i = is_large ? 1 : SIDES + 1; i <= SIDES; ++i) {
        float turn = TWO_PI / float(SIDES) * float(i);
        vec2 next = s + CORNER * (axes * vec2(cos(turn), sin(turn)));
        sum += edge_share(corner, next);
        corner = next;
    }
    float area = max(PI * abs(determinant(axes)), 1e-30);
    return is_large ? 0.5 * abs(sum) / area : mean_over_disk(s, radius);
}

#if FILTERS_GLOSS
uniform float u_gloss_footprint;  // how much of the way to its neighbours a pixel reaches, px

// Parallelograms are at least as wide.
const float THIN = 0.25;
// Change of the slope, relative to the cosine at which it is seen, from which on a neighbour
// says nothing of what lies between: at silhouettes.
const float MOST_CHANGE = 0.5;
// Sine of the angle with the tangent plane at which a neighbour is another surface's.
const float STEEPEST = 0.7;

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

// Mean of (1 + s^2)^-2 over the parallelogram that x and y span at s.
float mean_over_part(vec2 s, vec2 x, vec2 y)
{
    vec2 middle = s + 0.5 * (x + y);
    float size = max(max(length(x), length(y)), 1e-10);
    vec2 along = length(x) > length(y) ? x : y;
    y = x + y - along;
    x = along;
    float area = x.x * y.y - x.y * y.x;
    // What is as wide as THIN, however thin it was.
    float wider = max(THIN - abs(area) / size, 0.0) * (area < 0.0 ? -1.0 : 1.0);
    y += vec2(-x.y, x.x) * (wider / size);
    area += wider * size;
    vec2 start = middle - 0.5 * (x + y);
    float sum = edge_share(start, start + x) + edge_share(start + x, start + x + y)
              + edge_share(start + x + y, start + y) + edge_share(start + y, start);
    return max(0.5 * sum / area, 0.0);
}

#endif

// The distribution of the microfacets that mirror the light, as one pixel shows it.
float distribution_of_light(Light light, vec3 p_vs, vec3 n_vs, float alpha)
{
    mat3 frame = frame_from_z(n_vs);
    vec3 slope = half_slope(light, p_vs, n_vs);
    vec2 s = vec2(dot(frame[0], slope), dot(frame[1], slope));
    mat2 disk = half_disk(light, p_vs, frame, alpha);
#if FILTERS_GLOSS
    float to_half = 0.5 / alpha;
    vec2 right = to_half * change_of_slope(ivec2(1, 0), light, p_vs, frame, slope);
    vec2 left = to_half * change_of_slope(ivec2(-1, 0), light, p_vs, frame, slope);
    vec2 above = to_half * change_of_slope(ivec2(0, 1), light, p_vs, frame, slope);
    vec2 below = to_half * change_of_slope(ivec2(0, -1), light, p_vs, frame, slope);
    vec2 start = s / alpha;
    float size = max(max(length(right), length(left)), max(length(above), length(below)));
    bool is_even = size < max(SMALL, mean_radius(disk)) || length(start) > FAR * size;
    float mean = 0.0;
    // Software rasterizers leave loops where they would go through a branch that is not taken.
    for (int i = is_even ? 4 : 0; i < 4; ++i) {
        mean += 0.25 * mean_over_part(start, (i & 1) == 0 ? right : left, i < 2 ? above : below);
    }
    vec2 middle = start + 0.25 * (right + left + above + below);
    vec2 x = 0.25 * (right - left);
    vec2 y = 0.25 * (above - below);
    float apart = mean_over_ellipse(middle + x + y, disk) + mean_over_ellipse(middle + x - y, disk)
                + mean_over_ellipse(middle - x + y, disk) + mean_over_ellipse(middle - x - y, disk);
    mean = is_even ? 0.25 * apart : mean;
#else
    float mean = mean_over_ellipse(s / alpha, disk);
#endif
    float per_cosine = (1.0 + dot(s, s)) / alpha;
    return mean * per_cosine * per_cosine * INV_PI;
}
#endif
