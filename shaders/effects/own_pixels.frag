#version 330 core
// How many rays each pixel traces: none, the usual number, or more where a neighbour in
// front may shade it.
#include "lib/shaded_pixels.glsl"

uniform int u_receiver_stride;  // pixels from one that light is gathered at to the next

// r: class, gb: octahedral code of the geometric normal, 127 steps to either side
layout(location = 0) out vec4 o_class;

// As ssdo_gl/effects/own_rays.py reads them.
const float NONE = 0.0;
const float USUAL = 0.5;
const float EDGE = 1.0;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_class = vec4(NONE);
    if (gbuffer_z_vs(texel) <= 0.0 || texel % u_receiver_stride != ivec2(0))
        return;
    vec2 code = (oct_project(gbuffer_geometric_normal_vs(texel)) + 1.0) * (127.0 / 255.0);
    o_class = vec4(may_be_shaded(texel) ? EDGE : USUAL, code, 0.0);
}
