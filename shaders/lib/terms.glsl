// The terms of the picture that effects add, whatever these are.
//
// IRRADIANCE_COUNT, RADIANCE_COUNT: how many images of each kind there are, at most 6 and 4.
// The alpha of a radiance is 1 where senders pass it on.
// HALF_IRRADIANCES (default 0): bit i says that image i has half the frame's size.
#ifndef HALF_IRRADIANCES
#define HALF_IRRADIANCES 0
#endif
// Those beyond the counts are not used, and nothing is bound to them.
uniform sampler2D t_irradiance_0;
uniform sampler2D t_irradiance_1;
uniform sampler2D t_irradiance_2;
uniform sampler2D t_irradiance_3;
uniform sampler2D t_irradiance_4;
uniform sampler2D t_irradiance_5;
uniform sampler2D t_radiance_0;
uniform sampler2D t_radiance_1;
uniform sampler2D t_radiance_2;
uniform sampler2D t_radiance_3;

// What is read of irradiance `i`: the texel; of half the size, the four pixels nearest to it, of
// which the mean is taken.
int read_count(int i)
{
    return (HALF_IRRADIANCES >> i & 1) == 1 ? 4 : 1;
}

ivec2 read_texel(int i, int k, ivec2 texel, ivec2 size)
{
    ivec2 own = texel >> 1;
    ivec2 other = clamp(own + 2 * (texel & 1) - 1, ivec2(0), size - 1);
    ivec2 pixel = ivec2((k & 1) == 0 ? own.x : other.x, k < 2 ? own.y : other.y);
    return read_count(i) == 1 ? texel : pixel;
}

vec3 summed_irradiance(ivec2 texel)
{
    vec3 sum = vec3(0.0);
#if IRRADIANCE_COUNT > 0
    for (int k = 0; k < read_count(0); ++k)
        sum += texelFetch(t_irradiance_0, read_texel(0, k, texel, textureSize(t_irradiance_0, 0)), 0).rgb
             / float(read_count(0));
#endif
#if IRRADIANCE_COUNT > 1
    for (int k = 0; k < read_count(1); ++k)
        sum += texelFetch(t_irradiance_1, read_texel(1, k, texel, textureSize(t_irradiance_1, 0)), 0).rgb
             / float(read_count(1));
#endif
#if IRRADIANCE_COUNT > 2
    for (int k = 0; k < read_count(2); ++k)
        sum += texelFetch(t_irradiance_2, read_texel(2, k, texel, textureSize(t_irradiance_2, 0)), 0).rgb
             / float(read_count(2));
#endif
#if IRRADIANCE_COUNT > 3
    for (int k = 0; k < read_count(3); ++k)
        sum += texelFetch(t_irradiance_3, read_texel(3, k, texel, textureSize(t_irradiance_3, 0)), 0).rgb
             / float(read_count(3));
#endif
#if IRRADIANCE_COUNT > 4
    for (int k = 0; k < read_count(4); ++k)
        sum += texelFetch(t_irradiance_4, read_texel(4, k, texel, textureSize(t_irradiance_4, 0)), 0).rgb
             / float(read_count(4));
#endif
#if IRRADIANCE_COUNT > 5
    for (int k = 0; k < read_count(5); ++k)
        sum += texelFetch(t_irradiance_5, read_texel(5, k, texel, textureSize(t_irradiance_5, 0)), 0).rgb
             / float(read_count(5));
#endif
    return sum;
}

// A select, not a product: what is not counted may be anything.
vec3 counted(vec4 radiance, bool sent_only)
{
    return sent_only && radiance.a <= 0.5 ? vec3(0.0) : radiance.rgb;
}

// `sent_only`: leave out what other light delivers already.
vec3 summed_radiance(ivec2 texel, bool sent_only)
{
    vec3 sum = vec3(0.0);
#if RADIANCE_COUNT > 0
    sum += counted(texelFetch(t_radiance_0, texel, 0), sent_only);
#endif
#if RADIANCE_COUNT > 1
    sum += counted(texelFetch(t_radiance_1, texel, 0), sent_only);
#endif
#if RADIANCE_COUNT > 2
    sum += counted(texelFetch(t_radiance_2, texel, 0), sent_only);
#endif
#if RADIANCE_COUNT > 3
    sum += counted(texelFetch(t_radiance_3, texel, 0), sent_only);
#endif
    return sum;
}
