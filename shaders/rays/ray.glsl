// Where rays start: the surface points of the G-buffer, in the normalised frame.
#include "lib/gbuffer.glsl"
#include "lib/sampling.glsl"
#include "rays/bvh.glsl"

uniform mat3 u_ns_from_vs;     // rotation only: the frame has the axes of the world
uniform vec3 u_eye_ns;
uniform float u_ns_per_unit;   // 1 / half-diagonal of the scene

// Rays start this far off their surface, along its geometric normal. Hits are exact to
// some 4e-7 (4 roundings of coordinates up to 1 and of t up to 2); ten times that keeps a
// ray at 89 degrees from its own plane, and is 4e-6 of the scene's half-diagonal.
// They also start as far back along the ray that found the surface, where nothing is in
// the way: rounding may put a point on an edge outside the other wall of a corner, from
// where rays escape, but both walls turn towards that ray.
const float RAY_OFFSET = 4e-6;
// How far the position that the G-buffer gives may be off, relative to the distance from
// the eye: rasterizers interpolate z with some 80 roundings.
const float GBUFFER_ERROR = 2e-5;
// Longer than any ray that starts within the scene's bounds, whose diagonal is 2.
const float RAY_FAR = 4.0;

// Rays towards light end this share, and an offset, before it, so as not to hit the lamp
// itself: some ten roundings of the distance.
const float LIGHT_GAP = 1e-6;

float reach_toward_light(float distance)
{
    return distance * (1.0 - LIGHT_GAP) - RAY_OFFSET;
}

struct RaySurface {
    vec3 position;    // ns
    vec3 normal;      // shading normal, on the side of the geometric one
    vec3 geometric;   // of the triangle, on the side that the ray came from
    vec3 start;       // ns: of rays that leave it, a little off the surface
    vec3 lift;        // from there onto the smooth surface: for rays to lights
    bool is_smooth;   // its triangle stands for a smooth surface
    vec3 w_out;       // unit, back along the ray that found it
};

bool ray_is_blocked(RaySurface surface, vec3 w, float t_max)
{
    return bvh_is_blocked(surface.start, w, t_max);
}

// A ray from the surface to a point of a light, or far away.
struct LightRay {
    vec3 start;
    vec3 w;
    float t_max;
};

// The ray that ends where one along w from the surface itself does.
LightRay light_ray(RaySurface surface, vec3 w, float t_max)
{
#if RAY_SMOOTH_NORMALS
    vec3 to_end = w * t_max - surface.lift;
    float size = length(to_end);
    bool is_lifted = t_max > 0.0 && size > 0.0 && surface.lift != vec3(0.0);
    return LightRay(surface.start + surface.lift, is_lifted ? to_end / size : w,
                    is_lifted ? size : t_max);
#else
    return LightRay(surface.start, w, t_max);
#endif
}

bool light_is_blocked(RaySurface surface, vec3 w, float t_max)
{
    LightRay ray = light_ray(surface, w, t_max);
    return bvh_light_is_blocked(ray.start, ray.w, ray.t_max);
}

// What of a sample of light arrives past sheets that are seen from one side, which stop what comes
// from there: `found` of it where rays by chance find the same light, all of it where they do not.
// `is_blocked`: by any side, if they differ, else by those that the light meets.
vec3 light_past_sheets(LightRay ray, bool is_blocked, vec3 found, vec3 all)
{
#if RAY_SINGLE_SIDED
    if (is_blocked && found != all) {
        is_blocked = bvh_light_is_blocked(ray.start, ray.w, ray.t_max);
        found = all;
    }
#endif
    return is_blocked ? vec3(0.0) : found;
}

vec3 arriving_light(RaySurface surface, vec3 w, float t_max, vec3 found, vec3 all)
{
    LightRay ray = light_ray(surface, w, t_max);
    float sides = found != all ? ALL_SIDES : SIDES_TO_LIGHT;
    bool is_blocked = bvh_meets_any(bvh_ray_to_light(ray.start, ray.w, sides), ray.t_max);
    return light_past_sheets(ray, is_blocked, found, all);
}

// Whether sheets stop the light of what a ray by chance has met, on its way back.
bool met_light_is_blocked(vec3 start, vec3 w, float t)
{
#if RAY_SINGLE_SIDED
    return bvh_light_is_blocked(start, w, reach_toward_light(t));
#else
    return false;
#endif
}

// How much of a point p of a triangle each corner has, from areas.
vec3 weights_of_corners(vec3 p, vec3 a, vec3 b, vec3 c, vec3 front)
{
    vec3 sub_a = cross(b - p, c - p);
    vec3 sub_b = cross(c - p, a - p);
    vec3 sub_c = cross(a - p, b - p);
    vec3 weights = max(vec3(dot(sub_a, front), dot(sub_b, front), dot(sub_c, front)), vec3(0.0));
    return weights / max(weights.x + weights.y + weights.z, 1e-30);
}

#if RAY_SMOOTH_NORMALS
// From a point of a triangle onto the smooth surface that it stands for, after Hanika 2021,
// "Hacking the Shadow Terminator": by how much the planes across the corners' normals lie
// above the point, weighted like the normal. Nothing moves inwards. Unlike there, heights are
// clamped together: normals that all lean the same way bend no surface.
vec3 lift_onto_corner_planes(vec3 p, vec3 a, vec3 b, vec3 c, vec3 weights, Corners corners,
                             vec3 normal)
{
    vec3 n_a = normal_of_word(corners.words_0.x);
    vec3 n_b = normal_of_word(corners.words_0.y);
    vec3 n_c = normal_of_word(corners.words_0.z);
    vec3 heights = vec3(dot(a - p, n_a), dot(b - p, n_b), dot(c - p, n_c));
    vec3 mean = weights.x * n_a + weights.y * n_b + weights.z * n_c;
    float height = dot(weights, heights);
    return max(dot(mean, normal) < 0.0 ? -height : height, 0.0) * normal;
}
#endif

// Where rays start that leave a surface at `p`, which a ray along `w` has found.
vec3 ray_start(vec3 p, vec3 geometric, vec3 w, float offset)
{
    return p + (geometric - w) * offset;
}

// Those that leave a surface in view where the G-buffer says that it is, by what that may be wrong.
vec3 ray_start_vs(vec3 p_vs, vec3 geometric_vs)
{
    vec3 to_point = u_ns_from_vs * (p_vs * u_ns_per_unit);
    return ray_start(u_eye_ns + to_point, u_ns_from_vs * geometric_vs,
                     viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                     GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
}

// A triangle's unit normal, towards its front. The longest edge as unit keeps products
// of small edges from underflowing.
vec3 triangle_normal(vec3 a, vec3 b, vec3 c)
{
    vec3 u = b - a;
    vec3 v = c - a;
    vec3 extent = max(abs(u), abs(v));
    float scale = 1.0 / max(max(extent.x, extent.y), max(extent.z, 1e-30));
    vec3 n = cross(u * scale, v * scale);
    return n * inversesqrt(max(dot(n, n), 1e-30));
}

// The surface that the camera sees at `texel`; the caller has checked that there is one.
// A short ray around the position of the G-buffer finds it again in the hierarchy, whose
// triangles are exact to float32: an offset that covered the rasterizer's error instead
// would have to be ten times as long, and grow with the distance of the camera.
RaySurface ray_surface_at(ivec2 texel)
{
    vec3 to_surface = u_ns_from_vs * (gbuffer_position_vs(texel) * u_ns_per_unit);
    vec3 w = viewing_direction(to_surface, u_ns_from_vs * AHEAD_VS);
    float reach = GBUFFER_ERROR * length(to_surface) + RAY_OFFSET;
    RaySurface surface;
    surface.w_out = -w;
    surface.normal = u_ns_from_vs * gbuffer_shading_normal_vs(texel);
    surface.geometric = u_ns_from_vs * gbuffer_geometric_normal_vs(texel);
    surface.position = u_eye_ns + to_surface;
    surface.start = ray_start(surface.position, surface.geometric, w, reach);
    surface.lift = vec3(0.0);
    surface.is_smooth = gbuffer_is_smooth(texel);
    vec3 start = surface.position - w * reach;
    BvhHit hit = bvh_nearest(start, w, 2.0 * reach);
    if (hit.record >= 0) {
        vec3 a, b, c;
        bvh_triangle(hit, a, b, c);
        vec3 n = triangle_normal(a, b, c);
        n = dot(n, w) > 0.0 ? -n : n;
        if (dot(n, surface.geometric) > 0.999) {
            surface.position = start + hit.t * w;
            surface.geometric = n;
            surface.start = ray_start(surface.position, n, w, RAY_OFFSET);
#if RAY_SMOOTH_NORMALS
            if (surface.is_smooth) {
                vec3 weights = weights_of_corners(surface.position, a, b, c, triangle_normal(a, b, c));
                int slot = int(bvh_texel(hit.record, 3).x) * 2 + (hit.is_second ? 1 : 0);
                surface.lift = lift_onto_corner_planes(
                    surface.position, a, b, c, weights, corners_of(slot), surface.normal);
            }
#endif
        } else {
            // At an edge the short ray may meet the neighbouring face first. Its normal
            // is not the one that the pixel is shaded with, but rays must keep clear of
            // both faces.
            surface.start += n * reach;
        }
    }
    return surface;
}

// A direction of the hemisphere about the shading normal. Those that point below the
// triangle, which stands for a smooth surface here, are mirrored above it: the sum over
// all directions keeps its weight, and a sphere of facets stays open.
vec3 ray_direction(RaySurface surface, mat3 frame, vec2 u)
{
    vec3 w = frame * cosine_hemisphere(u);
    float height = dot(w, surface.geometric);
    return w - min(2.0 * height, 0.0) * surface.geometric;
}
