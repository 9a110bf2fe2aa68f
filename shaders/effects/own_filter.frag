#version 330 core
// The far light of per-pixel rays, averaged over pixels around, twice: where light comes from few
// directions, a few rays for each pixel are too few for the edge-aware filter. The second time over
// pixels whose light differs by no more than its noise, as rays of the tiles about tell.
//
// Defines: IS_SECOND; BRIGHT_PIECES, OPENINGS (see rays/arriving.glsl); PROBE_TILE, PROBE_SIDE (see
// lib/far_probes.glsl).
#include "rays/guide.glsl"

#if IS_SECOND
uniform sampler2D t_own_near;       // as effects/own_rays.frag writes it
#else
uniform sampler2D t_own_pixels;  // column and row of the pixel in the frame; -1: none
#endif
uniform isampler2D t_own_places;  // as rays/shared_rays.glsl says
uniform sampler2D t_own_far;
#if BRIGHT_PIECES
uniform sampler2D t_own_aimed;      // of aimed rays; the second time as the first has averaged it
#endif
uniform sampler2D t_own_rare;       // a: as effects/own_rays.frag writes it
#if OPENINGS && IS_SECOND
uniform sampler2D t_own_light;      // b: as effects/own_rays.frag writes it
#endif
uniform sampler2D t_spread;         // as effects/own_spread.frag writes it
uniform int u_stride;            // pixels from one that has rays to the next
uniform int u_many_rays;         // as in effects/own_rays.frag
uniform int u_few_rays;
uniform int u_many_count;

// The second time for each pixel of the frame, as rays/shared_rays.glsl says.
layout(location = 0) out vec4 o_far;
#if IS_SECOND
layout(location = 1) out vec4 o_near;
#elif BRIGHT_PIECES
layout(location = 1) out vec4 o_aimed;
#endif

// Pixels from one of 5 x 5 taps to the next: the first time closes the gaps of the second.
#if IS_SECOND
const int STEP = 4;
#else
const int STEP = 1;
#endif
const int REACH = 2 * STEP;
const float TAPS = 25.0;
// Of the variance: where it is more pixels are averaged, and wholly from twice as much on.
const float MOST_EVEN = 0.2;
// Of heights above a pixel's plane, pixels.
const float HEIGHT = 2.0;
// Squared differences of what two pixels gather, in its variance, from which on they are in other
// light.
const float TOLERANCE = 3.0;
// Of what aimed rays bring, once averaged: of four two fifths meet what they are aimed at. By .02 it is
// as far off (RMS), and mottled.
const float AIMED_VARIANCE = 0.05;

ivec2 place_of(int number)
{
    int index = abs(number) - 1;
    int columns = textureSize(t_own_far, 0).x;
    return ivec2(index % columns, index / columns);
}

// What was rare among pixels far about, and their variance, between the tiles' middles.
vec4 rare_at(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    ivec2 tiles = probe_tiles();
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-p_vs.z));
    vec2 place = (vec2(texel) + 0.5) / float(PROBE_TILE) - 0.5;
    vec2 f = fract(place);
    vec4 sum = vec4(0.0);
    float weights = 1e-6;
    for (int i = 0; i < 8; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1 & 1);
        ivec2 tile = clamp(ivec2(floor(place)) + corner, ivec2(0), tiles - 1);
        vec2 near = mix(1.0 - f, f, vec2(corner));
        ivec2 probe = tile + ivec2(0, (i >> 2) * tiles.y);
        vec4 point = texelFetch(t_far_probe_points, probe, 0);
        float weight = (near.x * near.y + 1e-3) * on_surface(point, p_vs, n_vs, inv_extent);
        sum += weight * texelFetch(t_spread, probe, 0);
        weights += weight;
    }
    return sum / weights;
}

bool is_in_more_light(ivec2 place)
{
    return texelFetch(t_own_rare, place, 0).a == IN_MORE_LIGHT;
}

// How much two pixels can be in the same light: 1 as far as the noise of their rays tells, and less
// beyond (after Sakai et al. 2024). `variance`: relative, of what they have gathered.
float same_light(vec4 a, vec4 b, float variance)
{
    vec4 mean = vec4(vec3(1.0 / 3.0), u_sky);
    vec2 light = vec2(dot(a, mean), dot(b, mean));
    float apart = light.x - light.y;
    float noise = TOLERANCE * variance * dot(light, light) + 1e-15;
    float beyond = max(apart * apart - noise, 0.0) / noise;
    return 1.0 / (1.0 + beyond * beyond);
}

struct Light {
    vec4 far;
    vec4 aimed;  // a: 0
};

Light light_at(ivec2 place)
{
#if BRIGHT_PIECES
    return Light(texelFetch(t_own_far, place, 0), texelFetch(t_own_aimed, place, 0));
#else
    return Light(texelFetch(t_own_far, place, 0), vec4(0.0));
#endif
}

// Averaged over pixels about that are in the same light.
Light averaged(ivec2 texel, Light centre, vec3 p_vs, vec3 n_vs, float variance)
{
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
    int own = texelFetch(t_own_places, texel, 0).x;
    bool is_lit = is_in_more_light(place_of(own));
    float inv_pixel = 1.0 / (float(u_stride) * pixel_height_at(-p_vs.z));
    ivec2 size = textureSize(t_own_places, 0);
    Light sum = Light(vec4(0.0), vec4(0.0));
    vec2 weights = vec2(0.0);
    for (int y = -REACH; y <= REACH; y += STEP) {
        for (int x = -REACH; x <= REACH; x += STEP) {
            ivec2 other = texel + u_stride * ivec2(x, y);
            bool exists = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
            int number = exists ? texelFetch(t_own_places, other, 0).x : 0;
            if (sign(number) != sign(own))
                continue;
            // A pixel beside a distant one, or on a surface seen along itself, is farther away.
            vec3 d = (gbuffer_position_vs(other) - p_vs) * inv_pixel;
            float height = dot(d, geometric_vs) / HEIGHT;
            float near = (1.0 + height * height) * (1.0 + dot(d, d) / float(REACH * REACH));
            float alike = max(dot(gbuffer_shading_normal_vs(other), n_vs), 0.0);
            alike *= alike;
            float weight = alike * alike * alike * alike / (near * near);
            ivec2 place = place_of(number);
            weight *= is_in_more_light(place) == is_lit ? 1.0 : 0.0;
            Light light = light_at(place);
            vec2 of_each = vec2(weight);
#if IS_SECOND
            of_each.x *= same_light(light.far, centre.far, variance);
#if BRIGHT_PIECES
            of_each.y *= same_light(light.aimed, centre.aimed, AIMED_VARIANCE);
#endif
#endif
            sum.far += of_each.x * light.far;
            sum.aimed += of_each.y * light.aimed;
            weights += of_each;
        }
    }
    return Light(sum.far / weights.x, sum.aimed / weights.y);
}

void main()
{
    o_far = vec4(0.0);
#if IS_SECOND
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_near = vec4(0.0);
    int number = texelFetch(t_own_places, texel, 0).x;
    if (number == 0)
        return;
    ivec2 place = place_of(number);
    o_near = texelFetch(t_own_near, place, 0);
    o_near.a = number < 0 ? -o_near.a : o_near.a;
#else
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 texel = ivec2(texelFetch(t_own_pixels, place, 0).xy);
#if BRIGHT_PIECES
    o_aimed = vec4(0.0);
#endif
    if (texel.x < 0)
        return;
#endif
    Light own = light_at(place);
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    vec4 about = rare_at(texel, p_vs, n_vs);
    float share = smoothstep(MOST_EVEN, 2.0 * MOST_EVEN, about.a);
    bool has_many = place.y * textureSize(t_own_far, 0).x + place.x < u_many_count;
    float variance = about.a / (TAPS * float(has_many ? u_many_rays : u_few_rays));
    if (share > 0.0) {
        Light around = averaged(texel, own, p_vs, n_vs, variance);
        own = Light(mix(own.far, around.far, share), mix(own.aimed, around.aimed, share));
    }
    o_far = own.far;
#if IS_SECOND
    o_far.rgb += is_in_more_light(place) ? vec3(0.0) : about.rgb;
    o_far.rgb += own.aimed.rgb;
#if OPENINGS
    o_far.a += texelFetch(t_own_light, place, 0).b;
#endif
#elif BRIGHT_PIECES
    o_aimed = own.aimed;
#endif
}
