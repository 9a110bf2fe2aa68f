// The terms of the picture that effects add, whatever these are.
//
// IRRADIANCE_COUNT, RADIANCE_COUNT: how many images of each kind there are, at most 6 and 4.
// The alpha of a radiance is 1 where senders pass it on.
#if IRRADIANCE_COUNT > 0
uniform sampler2D t_irradiance_0;
#endif
#if IRRADIANCE_COUNT > 1
uniform sampler2D t_irradiance_1;
#endif
#if IRRADIANCE_COUNT > 2
uniform sampler2D t_irradiance_2;
#endif
#if IRRADIANCE_COUNT > 3
uniform sampler2D t_irradiance_3;
#endif
#if IRRADIANCE_COUNT > 4
uniform sampler2D t_irradiance_4;
#endif
#if IRRADIANCE_COUNT > 5
uniform sampler2D t_irradiance_5;
#endif
#if RADIANCE_COUNT > 0
uniform sampler2D t_radiance_0;
#endif
#if RADIANCE_COUNT > 1
uniform sampler2D t_radiance_1;
#endif
#if RADIANCE_COUNT > 2
uniform sampler2D t_radiance_2;
#endif
#if RADIANCE_COUNT > 3
uniform sampler2D t_radiance_3;
#endif

vec3 summed_irradiance(ivec2 texel)
{
    vec3 sum = vec3(0.0);
#if IRRADIANCE_COUNT > 0
    sum += texelFetch(t_irradiance_0, texel, 0).rgb;
#endif
#if IRRADIANCE_COUNT > 1
    sum += texelFetch(t_irradiance_1, texel, 0).rgb;
#endif
#if IRRADIANCE_COUNT > 2
    sum += texelFetch(t_irradiance_2, texel, 0).rgb;
#endif
#if IRRADIANCE_COUNT > 3
    sum += texelFetch(t_irradiance_3, texel, 0).rgb;
#endif
#if IRRADIANCE_COUNT > 4
    sum += texelFetch(t_irradiance_4, texel, 0).rgb;
#endif
#if IRRADIANCE_COUNT > 5
    sum += texelFetch(t_irradiance_5, texel, 0).rgb;
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
