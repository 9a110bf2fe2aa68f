#version 330 core
// Four texels of an image, 2 x 2, in one: the lower two before the upper two.
uniform sampler2D t_image;

layout(location = 0) out vec4 o_quad;

void main()
{
    ivec2 low = 2 * ivec2(gl_FragCoord.xy);
    ivec2 high = min(low + 1, textureSize(t_image, 0) - 1);
    o_quad = vec4(texelFetch(t_image, low, 0).x, texelFetch(t_image, ivec2(high.x, low.y), 0).x,
                  texelFetch(t_image, ivec2(low.x, high.y), 0).x, texelFetch(t_image, high, 0).x);
}
