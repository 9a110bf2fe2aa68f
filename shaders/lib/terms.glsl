// The terms of the picture that effects add, whatever these are.
//
// IRRADIANCE_COUNT, RADIANCE_COUNT: how many images of each kind there are, at most 6 and 4.
// The alpha of a radiance is 1 where senders pass it on.
// HALF_IRRADIANCES (default 0): bit i says that image i has half the frame's size.
#ifndef HALF_IRRADIANCES
#define HALF_IRRADIANCES 0
#endif
// Those beyond the counts are not used, and nothing is bound to them.
uniform sampler2D t_irradiance_0, t_irradiance_1, t_irradiance_2;
uniform sampler2D t_irradiance_3, t_irradiance_4, t_irradiance_5;
uniform sampler2D t_radiance_0, t_radiance_1, t_radiance_2, t_radiance_3;

// Of half the size: the mean of the four pixels nearest to the texel.
vec3 irradiance_at(sampler2D image, ivec2 texel, int is_half)
{
    if (is_half == 0)
        return texelFetch(image, texel, 0).rgb;
    ivec2 a = texel >> 1;
    ivec2 b = clamp(a + 2 * (texel & 1) - 1, ivec2(0), textureSize(image, 0) - 1);
    return 0.25 * (texelFetch(image, a, 0).rgb + texelFetch(image, ivec2(b.x, a.y), 0).rgb
                   + texelFetch(image, ivec2(a.x, b.y), 0).rgb + texelFetch(image, b, 0).rgb);
}

vec3 summed_irradiance(ivec2 texel)
{
    vec3 sum = vec3(0.0);
#if IRRADIANCE_COUNT > 0
    sum += irradiance_at(t_irradiance_0, texel, HALF_IRRADIANCES & 1);
#endif
#if IRRADIANCE_COUNT > 1
    sum += irradiance_at(t_irradiance_1, texel, HALF_IRRADIANCES >> 1 & 1);
#endif
#if IRRADIANCE_COUNT > 2
    sum += irradiance_at(t_irradiance_2, texel, HALF_IRRADIANCES >> 2 & 1);
#endif
#if IRRADIANCE_COUNT > 3
    sum += irradiance_at(t_irradiance_3, texel, HALF_IRRADIANCES >> 3 & 1);
#endif
#if IRRADIANCE_COUNT > 4
    sum += irradiance_at(t_irradiance_4, texel, HALF_IRRADIANCES >> 4 & 1);
#endif
#if IRRADIANCE_COUNT > 5
    sum += irradiance_at(t_irradiance_5, texel, HALF_IRRADIANCES >> 5 & 1);
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
