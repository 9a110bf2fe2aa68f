#version 330 core
// The far light of per-pixel rays, averaged over pixels around: where light comes from few
// directions, a few rays for each pixel are too few for the edge-aware filter, which spreads what
// this leaves out between its steps.
//
// Defines: PROBE_TILE, PROBE_SIDE (see lib/far_probes.glsl).
#include "rays/guide.glsl"

uniform sampler2D t_own_pixels;  // column and row of the pixel in the frame; -1: none
uniform isampler2D t_own_places;  // as lib/own_rays.glsl says
uniform sampler2D t_own_far;
uniform sampler2D t_own_rare;       // a: as effects/own_rays.frag writes it
uniform sampler2D t_spread_first;   // radiance to add, by the tiles' first probes
uniform sampler2D t_spread_second;
uniform int u_stride;            // pixels from one that has rays to the next

layout(location = 0) out vec4 o_far;

// Pixels to either side, and from one tap to the next: 25 taps, whose gaps the edge-aware filter
// closes, or 81 where light comes from the fewest directions. 25 there, too: .0008 for .0004 in the
// cellar.
const int REACH = 8;
const int STEP = 4;
const int FINE_STEP = 2;
// Of the guide's variance: where it is more pixels are averaged, and wholly from twice as much on. 0.3
// to 0.6 in rooms with a lamp, 4 in a cellar under a grating. The taps reach as many pixels in any
// frame, and so blur less of what a larger one shows: from 180 lines on the bound falls, down to a
// third. With a ninth, courtyard's contacts blur: .0028 for .0022 at 640x360.
const float MOST_EVEN = 0.9;
const float LEAST_EVEN = 0.3;
const float EVEN_LINES = 180.0;

float even_variance()
{
    float smaller = EVEN_LINES / float(textureSize(t_own_places, 0).y);
    return clamp(MOST_EVEN * smaller * smaller, LEAST_EVEN, MOST_EVEN);
}

ivec2 place_of(int number)
{
    int index = abs(number) - 1;
    int columns = textureSize(t_own_far, 0).x;
    return ivec2(index % columns, index / columns);
}

// What was rare among pixels far about, between the tiles' middles.
vec3 rare_at(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    ivec2 tiles = textureSize(t_far_first_probes, 0);
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-p_vs.z));
    vec2 place = (vec2(texel) + 0.5) / float(PROBE_TILE) - 0.5;
    vec2 f = fract(place);
    vec3 sum = vec3(0.0);
    float weights = 1e-6;
    for (int i = 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        ivec2 tile = clamp(ivec2(floor(place)) + corner, ivec2(0), tiles - 1);
        vec2 near = mix(1.0 - f, f, vec2(corner));
        float share = near.x * near.y + 1e-3;
        vec4 point = texelFetch(t_far_first_probes, tile, 0);
        float weight = share * on_surface(point, p_vs, n_vs, inv_extent);
        sum += weight * texelFetch(t_spread_first, tile, 0).rgb;
        weights += weight;
        point = texelFetch(t_far_second_probes, tile, 0);
        weight = share * on_surface(point, p_vs, n_vs, inv_extent);
        sum += weight * texelFetch(t_spread_second, tile, 0).rgb;
        weights += weight;
    }
    return sum / weights;
}

bool is_in_more_light(ivec2 place)
{
    return texelFetch(t_own_rare, place, 0).a == IN_MORE_LIGHT;
}

// Averaged over pixels about that are in the same light.
vec4 averaged_far(ivec2 texel, int step, vec3 p_vs, vec3 n_vs, bool is_lit)
{
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
    int own = texelFetch(t_own_places, texel, 0).x;
    float inv_reach = 1.0 / (float(FINE_STEP * u_stride) * pixel_height_at(-p_vs.z));
    float taps = float(REACH / FINE_STEP);
    ivec2 size = textureSize(t_own_places, 0);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int y = -REACH; y <= REACH; y += step) {
        for (int x = -REACH; x <= REACH; x += step) {
            ivec2 other = texel + u_stride * ivec2(x, y);
            bool exists = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
            int number = exists ? texelFetch(t_own_places, other, 0).x : 0;
            if (sign(number) != sign(own))
                continue;
            // A pixel beside a distant one, or on a surface seen along itself, is farther away.
            vec3 d = (gbuffer_position_vs(other) - p_vs) * inv_reach;
            float height = dot(d, geometric_vs);
            float near = 1.0 / ((1.0 + height * height) * (1.0 + dot(d, d) / (taps * taps)));
            float alike = max(dot(gbuffer_shading_normal_vs(other), n_vs), 0.0);
            alike *= alike;
            float weight = near * near * alike * alike * alike * alike;
            ivec2 place = place_of(number);
            weight *= is_in_more_light(place) == is_lit ? 1.0 : 0.0;
            sum += weight * texelFetch(t_own_far, place, 0);
            weights += weight;
        }
    }
    return sum / weights;
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 texel = ivec2(texelFetch(t_own_pixels, place, 0).xy);
    o_far = texelFetch(t_own_far, place, 0);
    if (texel.x < 0)
        return;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    bool is_lit = is_in_more_light(place);
    float even = even_variance();
    float variance = guide_at(texel, p_vs, n_vs).variance;
    float averaged = smoothstep(even, 2.0 * even, variance);
    int step = variance < MOST_EVEN ? STEP : FINE_STEP;
    if (averaged > 0.0)
        o_far = mix(o_far, averaged_far(texel, step, p_vs, n_vs, is_lit), averaged);
    o_far.rgb += is_lit ? vec3(0.0) : rare_at(texel, p_vs, n_vs);
}
