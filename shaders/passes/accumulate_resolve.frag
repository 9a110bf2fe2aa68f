#version 330 core
// From the sums of both halves of the samples to their mean.
//
// OUTPUT_COUNT: 1 to 3 resources.
uniform sampler2D t_sum_a_0;
uniform sampler2D t_sum_b_0;
uniform float u_inverse_count;

layout(location = 0) out vec4 o_mean_0;
#if OUTPUT_COUNT > 1
uniform sampler2D t_sum_a_1;
uniform sampler2D t_sum_b_1;

layout(location = 1) out vec4 o_mean_1;
#endif
#if OUTPUT_COUNT > 2
uniform sampler2D t_sum_a_2;
uniform sampler2D t_sum_b_2;

layout(location = 2) out vec4 o_mean_2;
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_mean_0 = (texelFetch(t_sum_a_0, texel, 0) + texelFetch(t_sum_b_0, texel, 0)) * u_inverse_count;
#if OUTPUT_COUNT > 1
    o_mean_1 = (texelFetch(t_sum_a_1, texel, 0) + texelFetch(t_sum_b_1, texel, 0)) * u_inverse_count;
#endif
#if OUTPUT_COUNT > 2
    o_mean_2 = (texelFetch(t_sum_a_2, texel, 0) + texelFetch(t_sum_b_2, texel, 0)) * u_inverse_count;
#endif
}
