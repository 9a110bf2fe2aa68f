#version 330 core
// Averages images with what earlier frames saw of the same surfaces.
//
// Defines: IMAGE_COUNT 1 or 2; HAS_PAST 0: there is nothing before this frame;
// UNFILTERED: which image, from 1 on, is known as it was before the filter, too; 0: none;
// HAS_CONTACTS 1: it is known which pixels trace many rays.
#include "lib/finite.glsl"
#include "lib/past_surfaces.glsl"

uniform sampler2D t_value_0;
#if IMAGE_COUNT > 1
uniform sampler2D t_value_1;
#endif
#if UNFILTERED
uniform sampler2D t_unfiltered;
uniform float u_unfiltered_share;  // of the image where averages are long
#endif
#if HAS_PAST
uniform sampler2D t_past_0;
#if IMAGE_COUNT > 1
uniform sampler2D t_past_1;
#endif
uniform float u_most_frames;     // averaged at most
#if HAS_CONTACTS
uniform sampler2D t_gathered_near;  // a negative: the pixel traces many rays
#endif

#if HAS_CONTACTS
// Pixels with many rays need fewer frames; light changes from one to the next there, and
// the more often it is resampled, the more it is blurred.
const float MOST_FRAMES_AT_CONTACTS = 6.0;
#endif

float most_frames(ivec2 texel)
{
#if HAS_CONTACTS
    if (texelFetch(t_gathered_near, texel, 0).a < 0.0)
        return min(u_most_frames, MOST_FRAMES_AT_CONTACTS);
#endif
    return u_most_frames;
}
#else
uniform float u_frames;          // that the image itself is as good as
#endif

layout(location = 0) out vec4 o_value_0;
#if IMAGE_COUNT > 1
layout(location = 1) out vec4 o_value_1;
layout(location = 2) out vec4 o_surface;  // z, frames averaged, code of the shading normal
#else
layout(location = 1) out vec4 o_surface;
#endif

#if UNFILTERED
// An average needs no filter against the noise that it takes out itself: from three frames on
// ever more of the unfiltered image enters, from seven on the whole share.
const float FRAMES_OF_FILTER = 2.0;
const float FRAMES_OF_CHANGE = 5.0;

vec3 less_filtered(vec3 value, ivec2 texel, float frames)
{
    vec3 unfiltered = texelFetch(t_unfiltered, texel, 0).rgb;
    bool is_light = is_finite(unfiltered) && all(greaterThanEqual(unfiltered, vec3(0.0)));
    float share = clamp((frames - FRAMES_OF_FILTER) / FRAMES_OF_CHANGE, 0.0, 1.0);
    return is_light ? mix(value, unfiltered, u_unfiltered_share * share) : value;
}
#endif

struct Past {
    vec4 values[IMAGE_COUNT];
    float frames;
    float weight;
    vec2 aside;  // of the point, texels: where on average lies what is known
};

#if HAS_PAST
void add_tap(inout Past past, Place place, ivec2 step_px)
{
    ivec2 tap = place.base + step_px;
    vec4 surface = past_surface(tap);
    float weight = tap_weight(place, step_px) * same_surface(place, step_px, surface);
    if (weight <= 0.0)
        return;
    past.values[0] += weight * texelFetch(t_past_0, tap, 0);
#if IMAGE_COUNT > 1
    past.values[1] += weight * texelFetch(t_past_1, tap, 0);
#endif
    past.frames += weight * surface.y;
    past.weight += weight;
    past.aside += weight * (vec2(step_px) - place.f);
}

#if HAS_CONTACTS
// What lies less far aside, texels, is taken for the point.
const float LEAST_ASIDE = 0.1;
// In footprints of a pixel off its plane: light changes beside what stands closer. A wall seen between
// bars is lit evenly, and little but noise would come in.
const float CLOSE = 3.0;

// Takes off how light changes from the point at `texel` to where the past is known, as far as the next
// pixel tells, if it shows the same surface. Frame after frame light would else creep on along it.
void bring_back(inout Past past, ivec2 texel, float z)
{
    vec4 codes = texelFetch(t_normals_vs, texel, 0);
    vec3 rate = plane_rate(uv_of_texel(texel), oct_decode(codes.zw))
              / (u_plane_tolerance * pixel_height_at(z));
    float offset = plane_height(rate, vec2(0.0), z);
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 step_px = ivec2(0);
        step_px[axis] = past.aside[axis] < 0.0 ? -1 : 1;
        // Beyond the frame's edge is the pixel itself, which tells nothing.
        ivec2 other = clamp(texel + step_px, ivec2(0), textureSize(t_value_0, 0) - 1);
        float other_z = gbuffer_z_vs(other);
        vec2 turn = 2.0 * (texelFetch(t_normals_vs, other, 0).xy - codes.xy);
        bool is_same = other_z > 0.0 && dot(turn, turn) < NORMAL_TOLERANCE * NORMAL_TOLERANCE
                    && abs(plane_height(rate, vec2(other - texel), other_z) - offset) < 1.0;
        ivec2 across = clamp(texel - step_px, ivec2(0), textureSize(t_value_0, 0) - 1);
        float height = plane_height(rate, vec2(across - texel), gbuffer_z_vs(across)) - offset;
        bool is_close = abs(height) * u_plane_tolerance < CLOSE;
        float share = is_same && is_close ? abs(past.aside[axis]) : 0.0;
        vec3 change = texelFetch(t_value_0, other, 0).rgb - texelFetch(t_value_0, texel, 0).rgb;
        past.values[0].rgb -= is_finite(change) ? share * change : vec3(0.0);
#if IMAGE_COUNT > 1
        change = texelFetch(t_value_1, other, 0).rgb - texelFetch(t_value_1, texel, 0).rgb;
        past.values[1].rgb -= is_finite(change) ? share * change : vec3(0.0);
#endif
    }
    for (int i = 0; i < IMAGE_COUNT; ++i)
        past.values[i].rgb = max(past.values[i].rgb, vec3(0.0));
}
#endif

// What the last frame saw of the surface at `texel`, between the four texels around it.
Past past_of(ivec2 texel, float z)
{
    Past past;
    for (int i = 0; i < IMAGE_COUNT; ++i)
        past.values[i] = vec4(0.0);
    past.frames = past.weight = 0.0;
    past.aside = vec2(0.0);
    Place place = place_of(texel, z);
    if (!place.is_seen)
        return past;
    add_tap(past, place, ivec2(0, 0));
    add_tap(past, place, ivec2(1, 0));
    add_tap(past, place, ivec2(0, 1));
    add_tap(past, place, ivec2(1, 1));
    if (past.weight > 0.0) {
        for (int i = 0; i < IMAGE_COUNT; ++i)
            past.values[i] /= past.weight;
        past.aside /= past.weight;
#if HAS_CONTACTS
        // Where few of the four show the surface, the others lie to one side of the point: what they
        // know is of another place, and counts the less for that. The pixel traces the more rays.
        if (max(abs(past.aside.x), abs(past.aside.y)) > LEAST_ASIDE)
            bring_back(past, texel, z);
#else
        past.frames /= past.weight;
#endif
    }
    return past;
}
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float z = gbuffer_z_vs(texel);
    vec4 values[IMAGE_COUNT];
    values[0] = texelFetch(t_value_0, texel, 0);
#if IMAGE_COUNT > 1
    values[1] = texelFetch(t_value_1, texel, 0);
#endif
#if HAS_PAST
    float frames = 1.0;
    if (z > 0.0) {
        Past past = past_of(texel, z);
        frames = min(past.frames, most_frames(texel) - 1.0) + 1.0;
#if UNFILTERED
        values[UNFILTERED - 1].rgb = less_filtered(values[UNFILTERED - 1].rgb, texel, frames);
#endif
        for (int i = 0; i < IMAGE_COUNT; ++i) {
            vec4 average = past.values[i] + (values[i] - past.values[i]) / frames;
            // What is no number is left out of the average.
            values[i] = is_finite(values[i]) ? average : past.values[i];
        }
    }
#else
    float frames = u_frames;
#endif
    for (int i = 0; i < IMAGE_COUNT; ++i)
        values[i] = is_finite(values[i]) ? values[i] : vec4(0.0);
    o_value_0 = values[0];
#if IMAGE_COUNT > 1
    o_value_1 = values[1];
#endif
    o_surface = vec4(z, frames, texelFetch(t_normals_vs, texel, 0).xy);
}
