#version 330 core
// Where the probes of each tile stand: the pixel nearest to the tile's middle, and the pixel
// that this one can tell least about, if it lies on another surface.
//
// Defines: PROBE_TILE.
#include "lib/gbuffer.glsl"
#include "lib/far_probes.glsl"

layout(location = 0) out vec4 o_point;

// Normals whose cosine is less than this are those of different surfaces.
const float SAME_NORMAL = 0.9;

ivec2 pixel_of(ivec2 tile, int i)
{
    return tile * PROBE_TILE + ivec2(i % PROBE_TILE, i / PROBE_TILE);
}

ivec2 first_pixel(ivec2 tile)
{
    ivec2 found = ivec2(-1);
    int smallest = 4 * PROBE_TILE * PROBE_TILE;
    ivec2 size = ivec2(u_frame_size_px);
    for (int i = 0; i < PROBE_TILE * PROBE_TILE; ++i) {
        ivec2 pixel = pixel_of(tile, i);
        // Twice the distance from the middle, which lies between pixels.
        ivec2 across = 2 * (pixel - tile * PROBE_TILE) + 1 - PROBE_TILE;
        int far = across.x * across.x + across.y * across.y;
        bool counts = all(lessThan(pixel, size)) && far < smallest;
        if (counts && gbuffer_z_vs(pixel) > 0.0) {
            found = pixel;
            smallest = far;
        }
    }
    return found;
}

// The pixel farthest from the tangent plane of the first one, or facing elsewhere.
ivec2 second_pixel(ivec2 tile, ivec2 first)
{
    vec3 p = gbuffer_position_vs(first);
    vec3 n = gbuffer_geometric_normal_vs(first);
    // A quarter of the tile: steps and grooves of two pixels count, too.
    float high = 0.25 * float(PROBE_TILE) * pixel_height_at(-p.z);
    ivec2 size = ivec2(u_frame_size_px);
    ivec2 found = ivec2(-1);
    float largest = 1.0;
    for (int i = 0; i < PROBE_TILE * PROBE_TILE; ++i) {
        ivec2 pixel = pixel_of(tile, i);
        if (all(lessThan(pixel, size)) && gbuffer_z_vs(pixel) > 0.0) {
            float height = abs(dot(gbuffer_position_vs(pixel) - p, n)) / high;
            float turn = (1.0 - dot(gbuffer_geometric_normal_vs(pixel), n)) / (1.0 - SAME_NORMAL);
            float other = max(height, turn);
            if (other > largest) {
                largest = other;
                found = pixel;
            }
        }
    }
    return found;
}

void main()
{
    int rows = (int(u_frame_size_px.y) + PROBE_TILE - 1) / PROBE_TILE;
    ivec2 tile = ivec2(gl_FragCoord.xy);
    bool is_first = tile.y < rows;
    tile.y %= rows;
    ivec2 first = first_pixel(tile);
    ivec2 second = first.x >= 0 ? second_pixel(tile, first) : first;
    ivec2 pixel = is_first ? first : second;
    o_point = vec4(0.0);
    if (pixel.x < 0)
        return;
    float code = probe_code(gbuffer_shading_normal_vs(pixel));
    o_point = vec4(gbuffer_position_vs(pixel), is_first && second.x >= 0 ? -code : code);
}
