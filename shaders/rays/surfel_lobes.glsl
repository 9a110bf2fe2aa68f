// What metal sends on of the light that a surfel receives, by directions.
//
// Needs lib/brdf.glsl. Of the resources, `surfel_quarters` holds, a tile above the other, the light
// of sources and sky; and of each quarter of the hemisphere the mean direction of that light, times
// the sum of its colours, and how far it spreads. `surfel_rest` holds of all other light the sum of
// its directions, by that of its colours, and that.
#if METAL
uniform sampler2D t_surfel_quarters;
uniform sampler2D t_surfel_rest;

const int SURFEL_QUARTERS = 4;
// How far the directions of even light in a quarter spread: their mean is .897 long.
const float EVEN_SPREAD = 0.099;
// Lobes are no narrower: rays of pixels and surfels would find them by chance.
const float LEAST_LOBE = 0.2;
const float LEAST_COSINE = 0.02;
// Of radiance that rises evenly along the surface, over that of the mean direction.
const float RISE = 4.0;

bool is_metal(Brdf brdf)
{
    return largest_of(brdf.f0) > 0.1;
}

vec4 quarter_texel(ivec2 surfel, int tile)
{
    int rows = textureSize(t_surfel_quarters, 0).y / (1 + SURFEL_QUARTERS);
    return texelFetch(t_surfel_quarters, surfel + ivec2(0, tile * rows), 0);
}

// Radiance, over the share that is reflected of even light, of light that arrives in a quarter, by
// its sum of colours. It is a lobe of the width `alpha`, widened by how far the light spreads,
// and as diffuse as the light is even.
float lobe_of_quarter(vec4 quarter, vec3 normal, vec3 w_out, float alpha)
{
    float sum = length(quarter.xyz);
    vec3 w_in = quarter.xyz / max(sum, 1e-30);
    float wide = sqrt(min(alpha * alpha + quarter.w, 1.0));
    float cos_in = max(dot(w_in, normal), LEAST_COSINE);
    float cos_out = max(dot(w_out, normal), LEAST_COSINE);
    vec3 h = half_vector(normal, w_out, w_in);
    float lobe = ggx_distribution(normal, h, wide) * smith_visibility(cos_out, cos_in, wide);
    lobe /= once_of_even_light(sqrt(wide));
    return sum * mix(lobe, INV_PI, min(quarter.w * (1.0 / EVEN_SPREAD), 1.0));
}

// What of the light of sources and sky is sent towards w_out, over the share that is reflected of
// even light. Unless `is_asked` the loop has no turns: where branches are taken by none of the pixels
// that a software renderer draws together, it goes through them all the same.
vec3 lobes_of_surfel(ivec2 surfel, vec3 direct, vec3 normal, vec3 w_out, float roughness, bool is_asked)
{
    float alpha = max(alpha_of(roughness), LEAST_LOBE);
    float lobes = 0.0;
    for (int quarter = is_asked ? 1 : SURFEL_QUARTERS + 1; quarter <= SURFEL_QUARTERS; ++quarter) {
        lobes += lobe_of_quarter(quarter_texel(surfel, quarter), normal, w_out, alpha);
    }
    return direct * (lobes / max(direct.r + direct.g + direct.b, 1e-30));
}

// Radiance towards w_out of metal that reflects `share` of even light and receives `irradiance`.
vec3 sent_by_metal(ivec2 surfel, vec3 irradiance, vec3 normal, vec3 w_out, float roughness, vec3 share,
                   bool is_asked)
{
    vec3 direct = quarter_texel(surfel, 0).rgb;
    vec4 mean = texelFetch(t_surfel_rest, surfel, 0);
    vec3 rise = RISE * (mean.xyz - dot(mean.xyz, normal) * normal) / max(mean.w, 1e-30);
    // Nowhere below 0, so that as much is sent as if it was diffuse.
    rise /= max(length(rise), 1.0);
    vec3 rest = max(irradiance - direct, 0.0) * INV_PI * (1.0 - dot(rise, w_out));
    return share * (lobes_of_surfel(surfel, direct, normal, w_out, roughness, is_asked) + rest);
}

// Two more words of what a ray of a surfel met: if it is metal, its shading normal, as oct_encode
// has it; 1 more than its roughness, in 16 bits, and 0 for all else.
struct MetalHit {
    vec3 normal;
    float roughness;  // negative: no metal
};

uvec2 packed_metal(MetalHit hit)
{
    uvec2 square = uvec2((oct_project(hit.normal) * 0.5 + 0.5) * 65534.0 + 0.5);
    uint rough = hit.roughness < 0.0 ? 0u : uint(hit.roughness * 65534.0 + 1.5);
    return uvec2(square.x | square.y << 16, rough);
}

MetalHit unpacked_metal(uvec2 words)
{
    vec2 square = vec2(words.x & 0xffffu, words.x >> 16) * (1.0 / 32767.0) - 1.0;
    return MetalHit(oct_unproject(square), (float(words.y) - 1.0) * (1.0 / 65534.0));
}
#endif
