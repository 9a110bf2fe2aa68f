#version 330 core
// Distance of the nearest back face along the view axis: where the first solid may end.
#include "lib/space.glsl"
#include "lib/depth_test.glsl"

layout(location = 0) out float o_z_back_vs;

void main()
{
    float z = fragment_z_vs();
    o_z_back_vs = z;
    write_depth(z);
}
