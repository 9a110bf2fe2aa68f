// Where the last frame of a view that moves saw a surface point, and how much its texels show the
// same surface.
#include "lib/gbuffer.glsl"

uniform sampler2D t_past_surfaces;  // r: z_vs, ba: code of the shading normal
uniform mat3 u_last_from_view;      // rotation of the eye, ...
uniform vec3 u_last_offset_vs;      // ... and where it is now, in the view of the last frame
uniform vec2 u_jitter_uv;           // this frame's jitter less that of the last one
// A tap of the last frame shows the same surface up to this many footprints of a pixel off
// its plane, if it faces about the same way.
uniform float u_plane_tolerance;

// A point and its surface as the last frame saw them; `rate` as in lib/edge_aware_filter.glsl.
struct Place {
    ivec2 base;  // of the four texels around it
    vec2 f;      // how far it lies from there, texels
    vec3 rate;
    float offset;
    vec2 shading_code;
    bool is_seen;
};

Place place_of(ivec2 texel, float z)
{
    Place place;
    vec3 p = u_last_from_view * position_vs_at(uv_of_texel(texel), z) + u_last_offset_vs;
    place.is_seen = p.z < 0.0;
    vec2 texels = (uv_of_position_vs(p) + u_jitter_uv) * u_frame_size_px - 0.5;
    // A view that has not moved meets its texels exactly.
    vec2 nearest = floor(texels + 0.5);
    texels = all(lessThan(abs(texels - nearest), vec2(1e-3))) ? nearest : texels;
    place.base = ivec2(floor(texels));
    place.f = texels - vec2(place.base);
    vec3 plane = u_last_from_view * gbuffer_geometric_normal_vs(texel);
    place.rate = plane_rate(uv_of_texel(place.base) - u_jitter_uv, plane)
               / (u_plane_tolerance * pixel_height_at(max(z, -p.z)));
    place.offset = plane_height(place.rate, place.f, -p.z);
    place.shading_code = oct_project(u_last_from_view * gbuffer_shading_normal_vs(texel));
    return place;
}

// The bilinear weight of the texel `step_px` from the place's base.
float tap_weight(Place place, ivec2 step_px)
{
    vec2 parts = mix(1.0 - place.f, place.f, vec2(step_px));
    return parts.x * parts.y;
}

bool is_in_past(ivec2 tap)
{
    return all(greaterThanEqual(tap, ivec2(0))) && all(lessThan(tap, textureSize(t_past_surfaces, 0)));
}

// What the last frame kept of the surface there.
vec4 past_surface(ivec2 tap)
{
    return texelFetch(t_past_surfaces, is_in_past(tap) ? tap : ivec2(0), 0);
}

// How much that shows the same surface, 0 to 1.
float same_surface(Place place, ivec2 step_px, vec4 surface)
{
    float off_plane = plane_height(place.rate, vec2(step_px), surface.x) - place.offset;
    // Compared as they are stored, which spares decoding them.
    vec2 turn = surface.zw * (1.0 / OCT_HALF_RANGE) - 1.0 - place.shading_code;
    float agree = max(1.0 - dot(turn, turn) / (NORMAL_TOLERANCE * NORMAL_TOLERANCE), 0.0);
    bool is_known = is_in_past(place.base + step_px) && surface.x > 0.0 && abs(off_plane) < 1.0;
    return is_known ? agree : 0.0;
}
