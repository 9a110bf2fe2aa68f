#version 330 core
// Depths along the view axis of what rasterizer/triangle.glsl keeps: 0 is background.

uniform usampler2D t_depth_keys;

layout(location = 0) out float o_z_vs;

void main()
{
    uint key = texelFetch(t_depth_keys, ivec2(gl_FragCoord.xy), 0).x;
    o_z_vs = key == 0u ? 0.0 : uintBitsToFloat(~key);
}
