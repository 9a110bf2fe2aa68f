#version 330 core
// Draws small triangles of a mesh's instances, one by an invocation, and writes down large ones.
//
// A triangle is met with at least as many pixels as its box has: large ones would keep all others
// of their group waiting.
#include "lib/space.glsl"
#include "rasterizer/triangle.glsl"
#include "rasterizer/blocks.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 4) readonly buffer Indices {
    uint u_indices[];
};
layout(std430, binding = 5) readonly buffer Instances {
    float u_instances[];
};
layout(std430, binding = 6) readonly buffer Positions {
    float u_positions[];
};

uniform uvec3 u_triangles;       // number of the first, how many, and how many to an instance
uniform uint u_instance_floats;
uniform uint u_first_of_fronts;  // instances from here on show their fronts only
uniform int u_shows_backs;       // and nothing else is drawn
uniform int u_is_mirrored;

// More pixels than an invocation draws by itself.
const int MOST_PIXELS = 128;

vec3 corner_vs(uint row, uint vertex)
{
    vec4 p = vec4(u_positions[3u * vertex], u_positions[3u * vertex + 1u],
                  u_positions[3u * vertex + 2u], 1.0);
    vec3 sums;
    for (uint i = 0u; i < 3u; ++i) {
        uint at = row + 4u * i;
        sums[i] = dot(vec4(u_instances[at], u_instances[at + 1u], u_instances[at + 2u],
                           u_instances[at + 3u]), p);
    }
    return sums;
}

// Pixels whose centres may be covered: low and high corner, both included.
ivec4 pixels_about(vec3 a, vec3 b, vec3 c)
{
    ivec2 last = ivec2(u_frame_size_px) - 1;
    float nearest = min(a.z, min(b.z, c.z));
    if (nearest < 0.5 * u_near_vs * u_unit && u_clip_from_view[2][3] != 0.0) {
        return ivec4(0, 0, last);
    }
    vec2 p = a.xy / a.z;
    vec2 q = b.xy / b.z;
    vec2 r = c.xy / c.z;
    // A hundredth of a pixel for rounding; far beyond the frame numbers are no pixels.
    vec2 half_size = 0.5 * u_frame_size_px;
    vec2 low = clamp((min(p, min(q, r)) + 1.0) * half_size - 0.51, vec2(-1.0), u_frame_size_px);
    vec2 high = clamp((max(p, max(q, r)) + 1.0) * half_size - 0.49, vec2(-1.0), u_frame_size_px);
    return ivec4(max(ivec2(ceil(low)), 0), min(ivec2(floor(high)), last));
}

bool is_outside(vec3 a, vec3 b, vec3 c)
{
    vec2 low = min(min(a.xy + a.z, b.xy + b.z), c.xy + c.z);
    vec2 high = max(max(a.xy + a.z, b.xy + b.z), c.xy + c.z);
    vec2 other_high = max(max(a.z - a.xy, b.z - b.xy), c.z - c.xy);
    return min(min(high.x, high.y), min(other_high.x, other_high.y)) < 0.0;
}

// Whether there was room for it.
bool is_written_down(Triangle t, ivec4 pixels)
{
    uint record = atomicAdd(u_record_count, 1u);
    ivec4 blocks = pixels / BLOCK_SIDE;
    ivec2 count = blocks.zw - blocks.xy + 1;
    uint first = atomicAdd(u_block_count, uint(count.x * count.y));
    uint end = first + uint(count.x * count.y);
    if (record >= u_room.x || end > u_room.y) {
        while (first < min(end, u_room.y)) {
            u_blocks[first++] = uvec2(NO_RECORD, 0u);
        }
        return false;
    }
    u_records[record] = Record(vec4(t.edge_0, t.corner_vs.x), vec4(t.edge_1, t.corner_vs.y),
                               vec4(t.edge_2, t.corner_vs.z),
                               vec4(t.normal_vs, uintBitsToFloat(t.id)), vec4(t.depths, 0.0, 0.0));
    for (int y = blocks.y; y <= blocks.w; ++y) {
        for (int x = blocks.x; x <= blocks.z; ++x) {
            u_blocks[first++] = uvec2(record, uint(y) << 16 | uint(x));
        }
    }
    return true;
}

void main()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint number = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (number >= u_triangles.y) {
        return;
    }
    uint instance = number / u_triangles.z;
    uint first = 3u * (number % u_triangles.z);
    uint row = instance * u_instance_floats;
    vec3 p = corner_vs(row, u_indices[first]);
    vec3 q = corner_vs(row, u_indices[first + 1u]);
    vec3 r = corner_vs(row, u_indices[first + 2u]);
    vec3 depths = -vec3(p.z, q.z, r.z);
    vec3 normal = cross(q - p, r - p);
    float turn = turn_of(normal, p);
    bool is_front = (turn > 0.0) != (u_is_mirrored != 0);
    bool is_shown = u_shows_backs != 0 ? !is_front : is_front || instance < u_first_of_fronts;
    if (turn == 0.0 || !is_shown || max(depths.x, max(depths.y, depths.z)) < u_near_vs) {
        return;
    }
    vec3 a = homogeneous(p);
    vec3 b = homogeneous(q);
    vec3 c = homogeneous(r);
    if (is_outside(a, b, c)) {
        return;
    }
    ivec4 pixels = pixels_about(a, b, c);
    ivec2 size = pixels.zw - pixels.xy + 1;
    if (min(size.x, size.y) <= 0) {
        return;
    }
    float side = turn > 0.0 ? 1.0 : -1.0;
    Triangle t = Triangle(side * edge_between(a, b), side * edge_between(b, c),
                          side * edge_between(c, a), normal, p,
                          vec2(min(depths.x, min(depths.y, depths.z)),
                               max(depths.x, max(depths.y, depths.z))),
                          u_triangles.x + number);
    if (size.x * size.y > MOST_PIXELS) {
        bool is_left = u_gives_ids == 0 ? is_written_down(t, pixels) : !is_overfull();
        if (is_left) {
            return;
        }
    }
    for (int y = pixels.y; y <= pixels.w; ++y) {
        for (int x = pixels.x; x <= pixels.z; ++x) {
            put_pixel(t, ivec2(x, y));
        }
    }
}
