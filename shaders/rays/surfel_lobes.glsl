// What gloss sends on of the light that a surfel receives, by directions: metal, and the reflecting
// layer of smooth dielectrics.
//
// Needs lib/brdf.glsl. Of the resources, `surfel_quarters` holds, a tile above the other, the light
// of sources and sky; and of each quarter of the hemisphere the mean direction of that light, times
// the sum of its colours, and how far it spreads. `surfel_rest` holds of all other light the sum of
// its directions, by that of its colours, and that.
#if LOBES
uniform sampler2D t_surfel_quarters;
uniform sampler2D t_surfel_rest;

const int SURFEL_QUARTERS = 4;
// How far the directions of even light in a quarter spread: their mean is .897 long.
const float EVEN_SPREAD = 0.099;
// Lobes are no narrower: rays of pixels and surfels would find them by chance. What layers send is
// less, and so are its dots.
const float LEAST_LOBE = 0.12;
const float LEAST_LOBE_OF_LAYER = 0.05;
const float LEAST_COSINE = 0.02;
// Of radiance that rises evenly along the surface, over that of the mean direction.
const float RISE = 4.0;

// Rougher layers send as if they were diffuse. A room whose dark floor a lamp grazes is 2.0 % too dark
// so at .5, by directions right; at .7 it is 1.0 % too dark and .7 % too bright. As RayFeatures.lobes has it.
const float SMOOTH_LAYER = 0.6;

bool is_metal(Brdf brdf)
{
    return largest_of(brdf.f0) > 0.1;
}

// Reflectance at normal and at grazing incidence, all colours alike: 1 and 1 for metal, of which a
// share is known; 0 and 0 for all that sends what it sends as if it was diffuse.
vec2 layer_of(Brdf brdf)
{
    vec2 layer = vec2(dot(brdf.f0, vec3(1.0 / 3.0)), brdf.f90);
    return is_metal(brdf) ? vec2(1.0) : brdf.roughness < SMOOTH_LAYER ? layer : vec2(0.0);
}

bool has_layer(vec2 layer)
{
    return layer.y > 0.0;
}

bool is_all_layer(vec2 layer)
{
    return layer.x > 0.5;
}

// What the layer reflects of even light; `more`: that it arrives more at grazing angles.
float share_of_layer(vec2 layer, float roughness, float more)
{
    float grazing = grazing_reflectance(roughness);
    return layer.x * (once_of_even_light(roughness) - grazing) + layer.y * grazing
        + (layer.y - layer.x) * grazing * more;
}

// What a lobe sends of light that arrives at a cosine, of F = 1: facets hide each other most where
// that is about alpha. A fit, within .04.
float sent_by_lobe(float cos_in, float alpha)
{
    float hidden = max(0.11 - 0.25 * alpha, 0.0);
    hidden *= 2.0 * alpha * cos_in / (alpha * alpha + cos_in * cos_in);
    return once_of_even_light(sqrt(alpha)) * (1.0 - hidden);
}

// The share of such light that the layer itself reflects, however wide its lobe is drawn; 1 for metal.
// It is Schlick's at a cosine that counts as the less grazing the rougher the layer is.
float reflected_by_layer(vec2 layer, float cos_in, float roughness)
{
    float rough = 0.58 * max(roughness, 0.03);
    float cosine = min(cos_in + rough * exp(-cos_in / rough), 1.0);
    float share = once_of_even_light(roughness) * mix(layer.x, layer.y, pow_5(1.0 - cosine));
    return is_all_layer(layer) ? 1.0 : share;
}

vec4 quarter_texel(ivec2 surfel, int tile)
{
    int rows = textureSize(t_surfel_quarters, 0).y / (1 + SURFEL_QUARTERS);
    return texelFetch(t_surfel_quarters, surfel + ivec2(0, tile * rows), 0);
}

// Radiance of light that arrives in a quarter, by its sum of colours; for metal over the share that is
// reflected of even light. It is a lobe of the layer's width, widened by how far the light spreads,
// and as diffuse as the light is even, of which `even` is reflected.
float lobe_of_quarter(vec4 quarter, vec3 normal, vec3 w_out, float roughness, vec2 layer, float even)
{
    float alpha = max(alpha_of(roughness), is_all_layer(layer) ? LEAST_LOBE : LEAST_LOBE_OF_LAYER);
    float sum = length(quarter.xyz);
    vec3 w_in = quarter.xyz / max(sum, 1e-30);
    float wide = sqrt(min(alpha * alpha + quarter.w, 1.0));
    float cos_in = max(dot(w_in, normal), LEAST_COSINE);
    float cos_out = max(dot(w_out, normal), LEAST_COSINE);
    vec3 h = half_vector(normal, w_out, w_in);
    float lobe = ggx_distribution(normal, h, wide) * smith_visibility(cos_out, cos_in, wide);
    lobe *= reflected_by_layer(layer, cos_in, roughness) / sent_by_lobe(cos_in, wide);
    // A lobe is widened as far as light that spreads less than even light needs. What layers mirror is
    // little, and blended at once as right.
    float evenness = min(quarter.w * (1.0 / EVEN_SPREAD), 1.0);
    evenness = is_all_layer(layer) ? evenness * evenness * evenness * evenness : evenness;
    return sum * mix(lobe, even * INV_PI, evenness);
}

// What of the light of sources and sky is sent towards w_out. Without a layer the loop has no turns:
// where branches are taken by none of the pixels that a software renderer draws together, it goes
// through them all the same.
vec3 lobes_of_surfel(ivec2 surfel, vec3 direct, vec3 normal, vec3 w_out, float roughness, vec2 layer)
{
    float even = is_all_layer(layer) ? 1.0 : share_of_layer(layer, roughness, 0.0);
    float lobes = 0.0;
    int quarter = has_layer(layer) ? 1 : SURFEL_QUARTERS + 1;
    for (; quarter <= SURFEL_QUARTERS; ++quarter) {
        lobes += lobe_of_quarter(quarter_texel(surfel, quarter), normal, w_out, roughness, layer,
                                 even);
    }
    return direct * (lobes / max(direct.r + direct.g + direct.b, 1e-30));
}

// Radiance towards w_out of what receives `light` and would send `share` of it if it was diffuse;
// light.a: how grazing it arrives.
vec3 sent_by_directions(ivec2 surfel, vec4 light, vec3 normal, vec3 w_out, float roughness, vec3 share,
                        vec2 layer)
{
    vec3 direct = quarter_texel(surfel, 0).rgb;
    vec3 lobes = lobes_of_surfel(surfel, direct, normal, w_out, roughness, layer);
    if (!is_all_layer(layer)) {
        // The rest is diffuse.
        vec3 layer_light = has_layer(layer) ? share_of_layer(layer, roughness, light.a) * direct : vec3(0.0);
        return lobes + INV_PI * max(share * light.rgb - layer_light, 0.0);
    }
    vec4 mean = texelFetch(t_surfel_rest, surfel, 0);
    vec3 rise = RISE * (mean.xyz - dot(mean.xyz, normal) * normal) / max(mean.w, 1e-30);
    // Nowhere below 0, so that as much is sent as if it was diffuse.
    rise /= max(length(rise), 1.0);
    vec3 rest = max(light.rgb - direct, 0.0) * INV_PI * (1.0 - dot(rise, w_out));
    return share * (lobes + rest);
}

// Two more words of what a ray of a surfel met: its shading normal, as oct_encode has it; its
// roughness in 16 bits and its layer in 8 each, by their roots.
struct LayerHit {
    vec3 normal;
    float roughness;
    vec2 layer;
};

uvec2 packed_layer(LayerHit hit)
{
    uvec2 square = uvec2((oct_project(hit.normal) * 0.5 + 0.5) * 65534.0 + 0.5);
    uvec2 layer = uvec2(sqrt(clamp(hit.layer, 0.0, 1.0)) * 255.0 + 0.5);
    uint rough = uint(hit.roughness * 65535.0 + 0.5);
    return uvec2(square.x | square.y << 16, rough | layer.x << 16 | layer.y << 24);
}

LayerHit unpacked_layer(uvec2 words)
{
    vec2 square = vec2(words.x & 0xffffu, words.x >> 16) * (1.0 / 32767.0) - 1.0;
    vec2 layer = vec2(words.y >> 16 & 0xffu, words.y >> 24) * (1.0 / 255.0);
    return LayerHit(oct_unproject(square), float(words.y & 0xffffu) * (1.0 / 65535.0), layer * layer);
}
#endif
