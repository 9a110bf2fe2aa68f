#version 330 core
// Draws the blocks of large triangles that were written down, one by a group at a time.
#include "lib/space.glsl"
#include "rasterizer/triangle.glsl"
#include "rasterizer/blocks.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

// Whether all of a block, by its low and high corner in device coordinates, is on the edge's
// wrong side; the slack is a rounding of the sum.
bool is_beyond(vec3 edge, vec2 low, vec2 high)
{
    vec2 best = mix(low, high, greaterThan(edge.xy, vec2(0.0)));
    return dot(edge, vec3(best, 1.0)) < -1e-6 * (abs(edge.x) + abs(edge.y) + abs(edge.z));
}

void main()
{
    uint count = min(u_block_count, u_room.y);
    for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) {
        uvec2 block = u_blocks[i];
        if (block.x == NO_RECORD) {
            continue;
        }
        Record record = u_records[block.x];
        Triangle t = Triangle(record.edge_0.xyz, record.edge_1.xyz, record.edge_2.xyz,
                              record.normal.xyz,
                              vec3(record.edge_0.w, record.edge_1.w, record.edge_2.w),
                              record.depths.xy, floatBitsToUint(record.normal.w));
        ivec2 corner = BLOCK_SIDE * ivec2(block.y & 0xffffu, block.y >> 16);
        ivec2 end = min(corner + BLOCK_SIDE, ivec2(u_frame_size_px));
        for (int y = corner.y; y < end.y; y += int(gl_WorkGroupSize.y)) {
            for (int x = corner.x; x < end.x; x += int(gl_WorkGroupSize.x)) {
                vec2 low = 2.0 * vec2(x, y) / u_frame_size_px - 1.0;
                vec2 high = low + 2.0 * vec2(gl_WorkGroupSize.xy) / u_frame_size_px;
                if (is_beyond(t.edge_0, low, high) || is_beyond(t.edge_1, low, high)
                    || is_beyond(t.edge_2, low, high)) {
                    continue;
                }
                ivec2 pixel = ivec2(x, y) + ivec2(gl_LocalInvocationID.xy);
                if (all(lessThan(pixel, end))) {
                    put_pixel(t, pixel);
                }
            }
        }
    }
}
