#version 330 core
// What a square of the frame shows, in a few numbers: whether it is all one plane, and the
// range of its depths.
//
// OPEN_TILE_SIZE: pixels along the square's sides.
#include "lib/constants.glsl"
#include "lib/gbuffer.glsl"

layout(location = 0) out vec4 o_tile_plane;   // xyz geometric normal, w: p . normal
layout(location = 1) out vec4 o_tile_depths;  // nearest z, farthest z (0: background only),
                                              // largest distance from the plane, 1 if plane

void main()
{
    ivec2 corner = ivec2(gl_FragCoord.xy) * OPEN_TILE_SIZE;
    ivec2 size = min(ivec2(u_frame_size_px) - corner, ivec2(OPEN_TILE_SIZE));
    vec2 code = vec2(0.0);
    vec4 plane = vec4(0.0);
    vec4 depths = vec4(FLOAT_MAX, 0.0, 0.0, 1.0);
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            ivec2 texel = corner + ivec2(x, y);
            float z = gbuffer_z_vs(texel);
            if (z > 0.0) {
                vec2 own_code = texelFetch(t_normals_vs, texel, 0).zw;
                vec3 p_vs = position_vs_at(uv_of_texel(texel), z);
                if (depths.y == 0.0) {
                    code = own_code;
                    plane.xyz = oct_decode(code);
                    plane.w = dot(p_vs, plane.xyz);
                }
                depths.x = min(depths.x, z);
                depths.y = max(depths.y, z);
                depths.z = max(depths.z, abs(dot(p_vs, plane.xyz) - plane.w));
                depths.w = own_code == code ? depths.w : 0.0;
            }
        }
    }
    o_tile_plane = plane;
    o_tile_depths = depths;
}
