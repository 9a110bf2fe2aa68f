#version 330 core
// What one irradiance contributes to the picture: the radiance that it is reflected as.
#include "lib/brdf.glsl"

uniform sampler2D t_irradiance;

layout(location = 0) out vec4 o_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = texelFetch(t_irradiance, texel, 0).rgb;
    float coverage = texelFetch(t_albedo, texel, 0).a;
    o_radiance = vec4(diffuse_radiance(brdf_at(texel), irradiance), coverage);
}
