#version 330 core
// One more bounce: what each surfel receives of the light that those its rays met receive,
//     E' = E_direct + mean of albedo E over all rays,
// and a step of Chebyshev's iteration beyond it, which needs the root of the steps where
// albedos are high. Glossy surfaces reflect less of what arrives upright. Defines as in
// passes/surfel_rays.frag.
#include "rays/surfel_hits.glsl"

uniform usampler2D t_surfel_hits;
uniform sampler2D t_surfel_direct;
uniform sampler2D t_last;       // E; a: as it is written
uniform sampler2D t_last_but_one;
uniform int u_surfel_rows;
uniform float u_over;           // 1: nothing but the bounce

layout(location = 0) out vec4 o_irradiance;

const int SURFEL_ROW_SHIFT = 8;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    vec3 sum = vec3(0.0);
    for (int y = 0; y < SURFEL_RAYS_PER_SIDE; ++y) {
        for (int x = 0; x < SURFEL_RAYS_PER_SIDE; ++x) {
            uvec2 words = texelFetch(t_surfel_hits, ivec2(x, y) * tile_size + surfel, 0).xy;
            SurfelHit met = unpacked_hit(words);
            ivec2 texel = ivec2(met.surfel & ((1u << SURFEL_ROW_SHIFT) - 1u),
                                met.surfel >> SURFEL_ROW_SHIFT);
            // Where nothing was met the albedo is 0.
            texel.y = min(texel.y, u_surfel_rows - 1);
            vec4 light = texelFetch(t_last, texel, 0);
            sum += max(met.albedo + met.slope * light.a, 0.0) * light.rgb;
        }
    }
    float scale = 1.0 / float(SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE);
    vec4 direct = texelFetch(t_surfel_direct, surfel, 0);
    vec3 bounced = direct.rgb + sum * scale;
    vec3 before = texelFetch(t_last_but_one, surfel, 0).rgb;
    vec3 light = before + u_over * (bounced - before);
    // How grazing it arrives, from upright, -1, to as light from everywhere, 0. What grazes more is
    // mirrored on along the surface: as if it was diffuse it would come back.
    float grazing = direct.a / max(light.r + light.g + light.b, 1e-30);
    o_irradiance = vec4(light, clamp(grazing, -1.0, 0.0));
}
