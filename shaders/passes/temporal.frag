#version 330 core
// Averages images with what earlier frames saw of the same surfaces.
//
// Defines: IMAGE_COUNT 1 or 2; HAS_PAST 0: there is nothing before this frame;
// UNFILTERED: which image, from 1 on, is known as it was before the filter, too; 0: none;
// HAS_CONTACTS 1: it is known which pixels trace many rays.
#include "lib/finite.glsl"
#include "lib/gbuffer.glsl"

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
uniform sampler2D t_past_surfaces;
uniform mat3 u_last_from_view;   // rotation of the eye, ...
uniform vec3 u_last_offset_vs;   // ... and where it is now, in the view of the last frame
uniform vec2 u_jitter_uv;        // this frame's jitter less that of the last one
uniform float u_most_frames;     // averaged at most
#if HAS_CONTACTS
uniform isampler2D t_own_places;  // negative: the pixel traces many rays
uniform bool u_has_own_rays;
#endif
// A tap of the last frame shows the same surface up to this many footprints of a pixel off
// its plane, and ...
uniform float u_plane_tolerance;

// ... this distance of octahedral codes (2 across the square): 25 degrees.
const float NORMAL_TOLERANCE = 0.43;

#if HAS_CONTACTS
// Pixels with many rays need fewer frames; light changes from one to the next there, and
// the more often it is resampled, the more it is blurred.
const float MOST_FRAMES_AT_CONTACTS = 6.0;
#endif

float most_frames(ivec2 texel)
{
#if HAS_CONTACTS
    if (u_has_own_rays && texelFetch(t_own_places, texel, 0).x < 0)
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
};

#if HAS_PAST
// A point and its surface as the last frame saw them; `rate` as in passes/edge_aware_filter.frag.
struct Place {
    ivec2 base;
    vec3 rate;
    float offset;
    vec2 shading_code;
};

void add_tap(inout Past past, Place place, ivec2 step_px, float weight)
{
    ivec2 tap = place.base + step_px;
    bool is_inside = all(greaterThanEqual(tap, ivec2(0)))
                  && all(lessThan(tap, textureSize(t_past_surfaces, 0)));
    vec4 surface = texelFetch(t_past_surfaces, is_inside ? tap : ivec2(0), 0);
    float off_plane = plane_height(place.rate, vec2(step_px), surface.x) - place.offset;
    // Compared as they are stored, which spares decoding them.
    vec2 turn = surface.zw * (1.0 / OCT_HALF_RANGE) - 1.0 - place.shading_code;
    bool is_same = is_inside && surface.x > 0.0 && abs(off_plane) < 1.0
                && dot(turn, turn) < NORMAL_TOLERANCE * NORMAL_TOLERANCE;
    if (!is_same || weight <= 0.0)
        return;
    past.values[0] += weight * texelFetch(t_past_0, tap, 0);
#if IMAGE_COUNT > 1
    past.values[1] += weight * texelFetch(t_past_1, tap, 0);
#endif
    past.frames += weight * surface.y;
    past.weight += weight;
}

// What the last frame saw of the surface at `texel`, between the four texels around it.
Past past_of(ivec2 texel, float z)
{
    Past past;
    for (int i = 0; i < IMAGE_COUNT; ++i)
        past.values[i] = vec4(0.0);
    past.frames = past.weight = 0.0;
    vec3 p = u_last_from_view * position_vs_at(uv_of_texel(texel), z) + u_last_offset_vs;
    if (p.z >= 0.0)
        return past;
    vec2 texels = (uv_of_position_vs(p) + u_jitter_uv) * u_frame_size_px - 0.5;
    // A view that has not moved meets its texels exactly.
    vec2 nearest = floor(texels + 0.5);
    texels = all(lessThan(abs(texels - nearest), vec2(1e-3))) ? nearest : texels;
    Place place;
    place.base = ivec2(floor(texels));
    vec2 f = texels - vec2(place.base);
    vec3 plane = u_last_from_view * gbuffer_geometric_normal_vs(texel);
    place.rate = plane_rate(uv_of_texel(place.base) - u_jitter_uv, plane)
               / (u_plane_tolerance * pixel_height_at(max(z, -p.z)));
    place.offset = plane_height(place.rate, f, -p.z);
    place.shading_code = oct_project(u_last_from_view * gbuffer_shading_normal_vs(texel));
    add_tap(past, place, ivec2(0, 0), (1.0 - f.x) * (1.0 - f.y));
    add_tap(past, place, ivec2(1, 0), f.x * (1.0 - f.y));
    add_tap(past, place, ivec2(0, 1), (1.0 - f.x) * f.y);
    add_tap(past, place, ivec2(1, 1), f.x * f.y);
    if (past.weight > 0.0) {
        for (int i = 0; i < IMAGE_COUNT; ++i)
            past.values[i] /= past.weight;
        past.frames /= past.weight;
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
