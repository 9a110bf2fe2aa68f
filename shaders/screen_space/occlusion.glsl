// Is a point in space inside something solid, as far as the depth buffer can tell?
//
// A point S in front of the camera is projected and snapped to the texel it falls on;
// Q is the surface stored there. S is taken to be inside a solid, and Q to block the
// receiver P from it, when
//   behind:   S is farther from the camera than Q                   z_S > z_Q
//   above:    Q rises above the tangent plane of P                  (Q - P) . n > bias
//   in front: S has not left the solid again through its back       z_S < z_back
// RGS09 asks for `behind` alone. On a plane, `behind` is decided by rounding and by the
// half pixel between S and the texel centre, so tilted planes shadow themselves; `above`
// is exactly false there, because Q is rebuilt at the centre where its depth was taken.
#include "lib/constants.glsl"
#include "lib/gbuffer.glsl"
#include "screen_space/origin.glsl"
#include "screen_space/tangent_height.glsl"

#if HAS_BACK_LAYER
uniform sampler2D t_z_layers;   // x: z_vs, y: depth of the nearest back face, 0 = none
#endif

uniform float u_thickness;         // depth of solids whose back is unknown, relative to R

// A surface that blocks a direction, and how far along it that was noticed.
struct Blocker {
    ivec2 texel;
    float distance;
};

const Blocker NO_BLOCKER = Blocker(ivec2(-1), FLOAT_MAX);

bool is_blocked(Blocker b)
{
    return b.texel.x >= 0;
}

// Height that rounding may give a coplanar Q, relative to its distance from P: normals
// in 2 x 16 octahedral bits are off by up to 0.0037 degrees = 6.5e-5; twice for safety.
// The distance is taken to be R, and as much again for each time that Q is as deep as P: its
// own takes ten products more for each depth read, an eighth of the march's time.
const float NORMAL_ERROR = 1.3e-4;
// Surfaces nearer to the first one than this, relative to z, are the surface itself
// seen from behind, not the back of a solid.
const float BACK_GAP = 1.0e-4;

// What the tests at one receiver have in common.
struct Tangent {
    vec3 position_vs;
    vec3 normal_vs;     // geometric
    vec3 rate;          // see plane_rate; Q lies above where plane_height is more than
    float lowest;
    float min_height;   // at P, but for the error of normals
    float thickness;    // scene units
    vec3 end_rate;      // blockers lie above a plane where rays end, too
    float end_offset;
    Origin origin;      // of rays
};

Tangent tangent_at(vec3 position_vs, vec3 geometric_vs)
{
    float z = -position_vs.z;
    Origin origin = origin_at(position_vs);
    vec3 rate = plane_rate(vec2(0.0), geometric_vs);
    float own = plane_height(rate, origin.start_px, z);
    float error = NORMAL_ERROR * length_scale_at(z);
    float min_height = min_blocking_height(z);
    rate.z -= error / z;
    return Tangent(position_vs, geometric_vs, rate, own + min_height + error, min_height,
                   u_thickness * length_scale_at(z), vec3(0.0), -1.0, origin);
}

// The same for rays that are aimed at a surface with the plane n . Q = offset: that surface
// must no more block them than the receiver's own does. `n` points to the receiver's side.
Tangent with_end_plane(Tangent t, vec3 normal_vs, float offset)
{
    t.end_rate = plane_rate(vec2(0.0), normal_vs);
    float own = plane_height(t.end_rate, t.origin.start_px, -t.position_vs.z);
    t.end_offset = own + (offset - dot(t.position_vs, normal_vs)) + t.min_height;
    return t;
}

// `above`, for the surface with depth z in the texel whose centre lies at `px`.
bool is_above(Tangent t, vec2 px, float z)
{
    return plane_height(t.rate, px, z) > t.lowest && plane_height(t.end_rate, px, z) > t.end_offset;
}

// What is known of the solids in the texel whose centre `uv` is: x is the depth of the nearest front, 0 for
// background; y that of the nearest back, 0 if there is none or the layer is missing. Both
// lie in one texture: a second fetch per step would cost half as much again.
vec2 solid_at(ivec2 texel)
{
#if HAS_BACK_LAYER
    return texelFetch(t_z_layers, texel, 0).xy;
#else
    return vec2(texelFetch(t_z_vs, texel, 0).x, 0.0);
#endif
}

// Depth at which the solid ends.
float solid_end(Tangent t, vec2 solid)
{
    return solid.y > solid.x * (1.0 + BACK_GAP) ? solid.y : solid.x + t.thickness;
}

// Whether R covers less than a pixel at depth z. Such a receiver sees nothing but its
// own texel and is open by definition.
bool is_radius_under_a_pixel(float z)
{
    return u_radius < pixel_height_at(z);
}
