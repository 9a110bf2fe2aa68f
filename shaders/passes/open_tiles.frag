#version 330 core
// Squares of the frame from which no ray of length R can meet anything that blocks it.
//
// A surface Q blocks a ray of the receiver P at a point S of the ray only if Q lies above
// the tangent plane of P, and S, seen from the camera, lies behind Q (lib/march.glsl). So a
// tile A that shows one plane is open if, for each tile B that the ball of radius R around
// A may cover, one of these holds:
//   below:   B shows one plane too, and all of it lies on or below the plane of A;
//   apart:   B shows one plane, and A is farther in front of it than a ray is long, so that
//            no ray passes through it;
//   behind:  what B shows is farther from the camera than the ball is there.
// Every bound is on the safe side: depths that a step stands for, half a texel between a
// ray and the texel it falls on, and the distance of actual points from their plane are
// added to R.
//
// OPEN_TILE_SIZE: pixels along a square's sides.
#include "lib/constants.glsl"
#include "lib/space.glsl"
#include "lib/tangent_height.glsl"

uniform sampler2D t_tile_plane;   // see passes/tile_planes.frag
uniform sampler2D t_tile_depths;
uniform float u_step_reach;       // depth by which a step may miss its point, scene units

layout(location = 0) out float o_open;

// Tiles that are looked at on each side, at most; a ball that covers more is not tried.
const int FARTHEST_TILE = 24;
// The ball's size changes little across it, so that no bound on perspective exceeds 1.5.
const float FEWEST_RADII = 3.0;
// All lengths below are rounded to a few 1e-7 of the depth.
const float ROUNDING_MARGIN = 1.0 + 1e-4;

struct Tile {
    vec3 normal_vs;
    float offset;
    float nearest;
    float farthest;     // 0: background only
    float deviation;
    bool is_plane;
};

Tile tile_at(ivec2 index)
{
    vec4 plane = texelFetch(t_tile_plane, index, 0);
    vec4 depths = texelFetch(t_tile_depths, index, 0);
    return Tile(plane.xyz, plane.w, depths.x, depths.y, depths.z, depths.w > 0.5);
}

vec2 corner_uv(ivec2 index, int corner)
{
    vec2 place = vec2(index + ivec2(corner & 1, corner >> 1)) * float(OPEN_TILE_SIZE);
    return min(place / u_frame_size_px, vec2(1.0));
}

// The corners of a tile on the plane that it shows; false if it is seen too obliquely.
bool corners_of(ivec2 index, Tile tile, out vec3 corners[4])
{
    bool is_clear = tile.is_plane;
    for (int i = 0; i < 4; ++i) {
        vec3 ray = view_ray_at(corner_uv(index, i));
        float toward = dot(ray, tile.normal_vs);
        is_clear = is_clear && toward < -1e-3;
        corners[i] = ray * (tile.offset / min(toward, -1e-3));
    }
    return is_clear;
}

// What of tile A the test of another tile needs.
struct Ball {
    vec3 corners[4];
    vec3 centre;
    float radius;       // about the centre: A and all that its rays reach
    float reach;        // of a ray, with all margins
    float min_height;   // above A's plane that may block
};

// Size of a pixel at depth 1.
float pixel_size()
{
    vec2 size = 2.0 * u_tan_half_fov / u_frame_size_px;
    return max(size.x, size.y);
}

bool is_harmless(ivec2 index, Tile a, Ball ball)
{
    Tile b = tile_at(index);
    if (b.farthest <= 0.0)
        return true;
    // behind: the ball, widened by the tile, where the ray through the tile's middle leaves it.
    vec3 ray = view_ray_at((vec2(index) + 0.5) * float(OPEN_TILE_SIZE) / u_frame_size_px);
    float half_tile = 0.7072 * float(OPEN_TILE_SIZE) * pixel_size();
    float wide = ball.radius + half_tile * (length(ball.centre) + ball.radius);
    float inverse_length = inversesqrt(dot(ray, ray));
    float along = dot(ray, ball.centre) * inverse_length;
    float half_chord_2 = along * along - dot(ball.centre, ball.centre) + wide * wide;
    float leaves = (along + sqrt(max(half_chord_2, 0.0))) * inverse_length;
    if (half_chord_2 <= 0.0 || leaves + u_step_reach < b.nearest)
        return true;
    if (!b.is_plane)
        return false;
    // apart
    bool is_apart = true;
    for (int i = 0; i < 4; ++i)
        is_apart = is_apart && dot(ball.corners[i], b.normal_vs) - b.offset > ball.reach + b.deviation;
    if (is_apart)
        return true;
    // below
    vec3 corners[4];
    bool is_below = corners_of(index, b, corners);
    for (int i = 0; i < 4; ++i) {
        float height = dot(corners[i], a.normal_vs) - a.offset;
        is_below = is_below && height + a.deviation + b.deviation < ball.min_height;
    }
    return is_below;
}

bool is_open(ivec2 index, Tile a)
{
    Ball ball;
    if (!corners_of(index, a, ball.corners))
        return false;
    ball.centre = 0.25 * (ball.corners[0] + ball.corners[1] + ball.corners[2] + ball.corners[3]);
    float z_far = a.farthest;
    float half_size = 0.0;
    for (int i = 0; i < 4; ++i) {
        half_size = max(half_size, length(ball.corners[i] - ball.centre));
        z_far = max(z_far, -ball.corners[i].z);
    }
    float slant = length(vec3(u_tan_half_fov * (1.0 + abs(u_jitter_ndc)), 1.0));
    float pixel = pixel_size();
    ball.reach = (u_radius + a.deviation + slant * u_step_reach
                  + pixel * (z_far + u_radius)) * ROUNDING_MARGIN;
    ball.radius = (ball.reach + half_size) * ROUNDING_MARGIN;
    ball.min_height = 0.5 * min_blocking_height(a.nearest);
    // Depth of the ball's nearest point, and what it covers of the frame there.
    float z_near = -ball.centre.z - ball.radius;
    if (a.nearest < FEWEST_RADII * u_radius || z_near <= 0.0)
        return false;
    vec2 pixels = 2.0 * u_tan_half_fov / u_frame_size_px;
    float spread = ball.radius * slant / (z_near * float(OPEN_TILE_SIZE) * min(pixels.x, pixels.y));
    if (spread > float(FARTHEST_TILE - 1))
        return false;
    int margin = int(ceil(spread)) + 1;
    ivec2 low = max(index - margin, ivec2(0));
    ivec2 high = min(index + margin, textureSize(t_tile_plane, 0) - 1);
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
            if (!is_harmless(ivec2(x, y), a, ball))
                return false;
    return true;
}

void main()
{
    ivec2 index = ivec2(gl_FragCoord.xy);
    Tile a = tile_at(index);
    o_open = a.farthest <= 0.0 || is_open(index, a) ? 1.0 : 0.0;
}
