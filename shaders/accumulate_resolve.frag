#version 330 core
// From the sums of both halves of the samples to their mean.
//
// OUTPUT_COUNT: 1 or 2 resources.
uniform sampler2D t_z_vs;
uniform sampler2D t_sum_a_0;
uniform sampler2D t_sum_b_0;
uniform float u_inverse_count;
uniform vec4 u_background_0;

layout(location = 0) out vec4 o_mean_0;
#if OUTPUT_COUNT > 1
uniform sampler2D t_sum_a_1;
uniform sampler2D t_sum_b_1;
uniform vec4 u_background_1;

layout(location = 1) out vec4 o_mean_1;
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    bool is_covered = texelFetch(t_z_vs, texel, 0).x > 0.0;
    vec4 sum_0 = texelFetch(t_sum_a_0, texel, 0) + texelFetch(t_sum_b_0, texel, 0);
    o_mean_0 = is_covered ? sum_0 * u_inverse_count : u_background_0;
#if OUTPUT_COUNT > 1
    vec4 sum_1 = texelFetch(t_sum_a_1, texel, 0) + texelFetch(t_sum_b_1, texel, 0);
    o_mean_1 = is_covered ? sum_1 * u_inverse_count : u_background_1;
#endif
}
