// How surfaces reflect light: the only file that knows.
//
// GLOSSY: surfaces are those of glTF 2.0, appendix B: a dielectric is diffuse
// under a reflecting layer, a metal reflects only; GGX microfacets, height-correlated Smith
// shadowing, Schlick's Fresnel. Light that facets send to each other, which appendix B leaves
// out, is added to the lobe: `rescattered`. Without it all are diffuse, albedo / pi.
//
// `normal` is the shading normal, `w_in` points to where light comes from and `w_out` to
// where it goes: unit vectors away from the surface, all in one space. Values come times
// the cosine at w_in, because all who ask go on to integrate over directions of it.
#include "lib/constants.glsl"
#include "lib/sampling.glsl"
#include "lib/gloss_image.glsl"

uniform sampler2D t_albedo;  // of the G-buffer; a: 1 on surfaces, 0 elsewhere
#if GLOSSY
uniform sampler2D t_finish;  // r: reflectance at grazing incidence, g: baked visibility
// What facets reflect once of even light. x: view, y: roughness; rg: shares of f0 and f90 by
// the view's cosine, b: their sum by another scale
uniform sampler2D t_reflectance;
#endif

struct Brdf {
    vec3 albedo;      // share of diffuse light that leaves again, [0, 1]
#if GLOSSY
    vec3 f0;          // reflectance of the microfacets at normal incidence
    float f90;        // and at grazing incidence
    float roughness;  // perceptual, [0, 1]
#endif
};

// A direction that light may have come from, drawn with `density` over solid angle.
struct BrdfSample {
    vec3 w_in;
    vec3 weight;    // brdf_times_cosine / density
    float density;
};

Brdf diffuse_brdf(vec3 albedo)
{
#if GLOSSY
    return Brdf(albedo, vec3(0.0), 0.0, 1.0);
#else
    return Brdf(albedo);
#endif
}

// The surface that the camera sees at `texel`.
Brdf brdf_at(ivec2 texel)
{
    vec3 albedo = texelFetch(t_albedo, texel, 0).rgb;
#if GLOSSY
    vec4 gloss = texelFetch(t_gloss, texel, 0);
    return Brdf(albedo, gloss.rgb, texelFetch(t_finish, texel, 0).r, gloss.a);
#else
    return Brdf(albedo);
#endif
}

#if GLOSSY
// A surface of base colour `base`: `dielectric_f0` is that of its dielectric part, whose
// reflection has the strength `specular`.
Brdf metallic_roughness_brdf(vec3 base, float metallic, float roughness, vec3 dielectric_f0,
                             float specular)
{
    return Brdf(base * (1.0 - metallic), mix(dielectric_f0, base, metallic),
                mix(specular, 1.0, metallic), roughness);
}

bool is_glossy(Brdf brdf)
{
    return brdf.f90 > 0.0;
}

// Width of the distribution of microfacets. Below a roughness of 0.03 a highlight is
// narrower than the sun seen from the earth, and float32 has too few digits for its
// height's square.
const float MIN_ALPHA = 1e-3;
// Cosine with the shading normal of those who look from below its horizon, where
// interpolated and mapped normals put some.
const float MIN_COSINE = 1e-4;

float alpha_of(float roughness)
{
    return max(roughness * roughness, MIN_ALPHA);
}

float pow_5(float x)
{
    float x_2 = x * x;
    return x_2 * x_2 * x;
}

// Schlick 1994. `cosine` is that between either direction and the half vector.
vec3 fresnel(Brdf brdf, float cosine)
{
    return brdf.f0 + (brdf.f90 - brdf.f0) * pow_5(clamp(1.0 - cosine, 0.0, 1.0));
}

// Mean of Schlick's fifth power over evenly lit directions, weighted by their cosine: a fit
// to the integral of (1 - v.h)^5 cos / pi by `cosine` of the one at w_out, within 1.3e-4.
vec3 mean_fresnel(Brdf brdf, float cosine)
{
    float power = 0.02804 + cosine * (-0.07731 + cosine * (0.07495 - cosine * 0.02571));
    return brdf.f0 + (brdf.f90 - brdf.f0) * max(power, 0.0);
}

const float TABLE_SIZE = 32.0;
// No view gains energy by how the table is interpolated.
const float TABLE_MARGIN = 0.997;

vec3 reflected_once(float view, float roughness)
{
    vec2 node = (vec2(view, roughness) * (TABLE_SIZE - 1.0) + 0.5) / TABLE_SIZE;
    return textureLod(t_reflectance, node, 0.0).rgb;
}

// The lobe with the light that facets reflect again and again, over that without: Turquin
// 2019, "Practical Multiple Scattering Compensation for Microfacet Models".
vec3 rescattered(Brdf brdf, float cos_out)
{
    // The view at which facets hide each other most is half-way for all roughnesses.
    float alpha = alpha_of(brdf.roughness);
    float view = sqrt(cos_out * (1.0 + alpha) / (cos_out + alpha));
    float once = reflected_once(view, brdf.roughness).b;
    return 1.0 + brdf.f0 * max(TABLE_MARGIN / max(once, 1e-3) - 1.0, 0.0);
}

// The share of evenly spread light that the glossy layer reflects.
vec3 layer_reflectance(Brdf brdf, float cos_out)
{
    vec2 share = reflected_once(cos_out, brdf.roughness).rg;
    return (brdf.f0 * share.x + brdf.f90 * share.y) * rescattered(brdf, cos_out);
}

// The distribution of GGX, Walter et al. 2007, of a unit half vector. Lagrange's identity
// for the sine keeps the digits that 1 - cosine^2 loses near the normal.
float ggx_distribution(vec3 normal, vec3 h, float alpha)
{
    float cosine = dot(normal, h);
    vec3 sine = cross(normal, h);
    float d = alpha * alpha * cosine * cosine + dot(sine, sine);
    float a = alpha / max(d, 1e-30);
    return cosine > 0.0 ? a * a * INV_PI : 0.0;
}

// Height-correlated Smith shadowing and masking over 4 cos_out cos_in: Heitz 2014.
float smith_visibility(float cos_out, float cos_in, float alpha)
{
    float a_2 = alpha * alpha;
    float masked = cos_in * sqrt(a_2 + (1.0 - a_2) * cos_out * cos_out);
    float shadowed = cos_out * sqrt(a_2 + (1.0 - a_2) * cos_in * cos_in);
    return 0.5 / max(masked + shadowed, 1e-30);
}

// Density over solid angle of w_in behind a visible normal h: Heitz 2018, equation 17.
float visible_normal_density(vec3 normal, vec3 h, float cos_out, float alpha)
{
    float a_2 = alpha * alpha;
    float lambda = sqrt(a_2 + (1.0 - a_2) * cos_out * cos_out);
    return ggx_distribution(normal, h, alpha) / (2.0 * max(cos_out + lambda, 1e-30));
}

// A visible normal of the microfacets, in the frame of the surface: Dupuy and Benyoub
// 2023, "Sampling Visible GGX Normals with Spherical Caps".
vec3 sampled_visible_normal(vec3 w_out, float alpha, vec2 u)
{
    vec3 stretched = normalize(vec3(alpha * w_out.xy, w_out.z));
    float phi = TWO_PI * u.x;
    float z = 1.0 - u.y * (1.0 + stretched.z);
    float sine = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(sine * cos(phi), sine * sin(phi), z) + stretched;
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-7)));
}

float largest_of(vec3 v)
{
    return max(v.r, max(v.g, v.b));
}

float cosine_out(vec3 normal, vec3 w_out)
{
    return max(dot(normal, w_out), MIN_COSINE);
}

// Half vector; the normal, where the two directions cancel.
vec3 half_vector(vec3 normal, vec3 w_out, vec3 w_in)
{
    vec3 sum = w_out + w_in;
    float size = length(sum);
    return size > 1e-6 ? sum / size : normal;
}

// The distribution of microfacets that mirror w_in to w_out.
float facets_between(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    return ggx_distribution(normal, half_vector(normal, w_out, w_in), alpha_of(brdf.roughness));
}

// What facets reflect once, where w_in is above the horizon; d is that distribution.
vec3 once_per_cosine(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in, float d)
{
    float alpha = alpha_of(brdf.roughness);
    vec3 h = half_vector(normal, w_out, w_in);
    float v = smith_visibility(cosine_out(normal, w_out), dot(normal, w_in), alpha);
    return is_glossy(brdf) ? fresnel(brdf, dot(w_in, h)) * (d * v) : vec3(0.0);
}

// What one view of facets says, wherever light comes from. Loops over light work it out before.
struct FacetView {
    vec3 normal;
    vec3 w_out;
    float cos_out;
    float alpha;
    float spread;  // root of Smith's masking
};

FacetView facet_view(Brdf brdf, vec3 normal, vec3 w_out)
{
    float alpha = alpha_of(brdf.roughness);
    float cos_out = cosine_out(normal, w_out);
    float spread = sqrt(mix(cos_out * cos_out, 1.0, alpha * alpha));
    return FacetView(normal, w_out, cos_out, alpha, spread);
}

// What facets of F = 1 reflect once times the cosine at w_in, and the share of it by which Schlick's
// Fresnel rises. As ggx_distribution and smith_visibility, but of a half vector of any length.
vec2 once_shares(FacetView view, vec3 w_in)
{
    float a_2 = view.alpha * view.alpha;
    float cos_in = dot(view.normal, w_in);
    vec3 h = view.w_out + w_in;
    vec3 sine = cross(view.normal, h);
    float h_2 = dot(h, h);
    float cosine = dot(view.normal, h);
    float d = view.alpha * h_2 / max(a_2 * cosine * cosine + dot(sine, sine), 1e-30);
    float masked = cos_in * view.spread + view.cos_out * sqrt(mix(cos_in * cos_in, 1.0, a_2));
    float once = 0.5 * INV_PI * d * d * cos_in / max(masked, 1e-30);
    float rise = pow_5(max(1.0 - 0.5 * sqrt(h_2), 0.0));
    // Who looks from below a mapped normal's horizon sees no facet by its back.
    return cos_in > 0.0 && cosine > 0.0 ? vec2(once, once * rise) : vec2(0.0);
}

vec3 once_of_shares(Brdf brdf, vec2 shares)
{
    return is_glossy(brdf) ? brdf.f0 * shares.x + (brdf.f90 - brdf.f0) * shares.y : vec3(0.0);
}

vec3 once_times_cosine(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    return once_of_shares(brdf, once_shares(facet_view(brdf, normal, w_out), w_in));
}

// The glossy part alone.
vec3 gloss_times_cosine(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    vec3 once = once_times_cosine(brdf, normal, w_out, w_in);
    return once * rescattered(brdf, cosine_out(normal, w_out));
}

// A direction from the glossy part alone, whose weight is of that part, too.
BrdfSample gloss_sample(Brdf brdf, vec3 normal, vec3 w_out, vec2 u)
{
    mat3 frame = frame_from_z(normal);
    // Those who look from below see the surface at grazing incidence.
    vec3 local = transpose(frame) * w_out;
    local = local.z < MIN_COSINE ? normalize(vec3(local.xy, MIN_COSINE)) : local;
    float alpha = alpha_of(brdf.roughness);
    vec3 h = sampled_visible_normal(local, alpha, u);
    vec3 w_in = frame * (2.0 * dot(local, h) * h - local);
    float cos_in = dot(w_in, normal);
    float spread = sqrt(alpha * alpha + (1.0 - alpha * alpha) * local.z * local.z);
    float share = smith_visibility(local.z, cos_in, alpha) * 2.0 * (local.z + spread) * cos_in;
    bool is_up = cos_in > 0.0 && is_glossy(brdf);
    vec3 gloss = fresnel(brdf, dot(local, h)) * share * rescattered(brdf, local.z);
    vec3 weight = is_up ? gloss : vec3(0.0);
    return BrdfSample(w_in, weight, visible_normal_density(normal, frame * h, local.z, alpha));
}

// Density over solid angle with which gloss_sample draws w_in, above the horizon.
float gloss_density(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    vec3 h = half_vector(normal, w_out, w_in);
    return visible_normal_density(normal, h, cosine_out(normal, w_out), alpha_of(brdf.roughness));
}

// Chance of drawing from the glossy part: its share of the light that leaves, about.
float gloss_chance(Brdf brdf, float cos_out)
{
    float glossy = largest_of(brdf.f0 + (brdf.f90 - brdf.f0) * pow_5(1.0 - min(cos_out, 1.0)));
    float diffuse = largest_of(brdf.albedo);
    return is_glossy(brdf) ? clamp(glossy / max(glossy + diffuse, 1e-30), 0.1, 1.0) : 0.0;
}
#endif

// Radiance towards w_out for each unit of radiance from the unit solid angle at w_in.
vec3 brdf_times_cosine(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    float cosine = max(dot(w_in, normal), 0.0) * INV_PI;
#if GLOSSY
    vec3 h = half_vector(normal, w_out, w_in);
    vec3 diffuse = brdf.albedo * (vec3(1.0) - fresnel(brdf, dot(w_in, h))) * cosine;
    return diffuse + gloss_times_cosine(brdf, normal, w_out, w_in);
#else
    return brdf.albedo * cosine;
#endif
}

// Density over solid angle with which brdf_sample draws w_in.
float brdf_density(Brdf brdf, vec3 normal, vec3 w_out, vec3 w_in)
{
    float diffuse = max(dot(w_in, normal), 0.0) * INV_PI;
#if GLOSSY
    float chance = gloss_chance(brdf, cosine_out(normal, w_out));
    return mix(diffuse, diffuse > 0.0 ? gloss_density(brdf, normal, w_out, w_in) : 0.0, chance);
#else
    return diffuse;
#endif
}

// A direction from a point of the unit square.
BrdfSample brdf_sample(Brdf brdf, vec3 normal, vec3 w_out, vec2 u)
{
    mat3 frame = frame_from_z(normal);
#if GLOSSY
    float cos_out = cosine_out(normal, w_out);
    float chance = gloss_chance(brdf, cos_out);
    vec3 w_in;
    if (u.x < chance) {
        w_in = gloss_sample(brdf, normal, w_out, vec2(u.x / chance, u.y)).w_in;
    } else {
        w_in = frame * cosine_hemisphere(vec2((u.x - chance) / (1.0 - chance), u.y));
    }
    float density = brdf_density(brdf, normal, w_out, w_in);
    vec3 value = brdf_times_cosine(brdf, normal, w_out, w_in);
    return BrdfSample(w_in, density > 0.0 ? value / density : vec3(0.0), density);
#else
    vec3 w_in = frame * cosine_hemisphere(u);
    return BrdfSample(w_in, brdf.albedo, brdf_density(brdf, normal, w_out, w_in));
#endif
}

// About the largest share of light that leaves again, by colour: how far it is worth
// following. 0 only where nothing leaves.
vec3 brdf_reflectance(Brdf brdf)
{
#if GLOSSY
    return is_glossy(brdf) ? min(brdf.albedo + max(brdf.f0, vec3(0.04)), vec3(1.0)) : brdf.albedo;
#else
    return brdf.albedo;
#endif
}

#if GLOSSY
// How grazing light arrives whose direction has this cosine: Schlick's fifth power over its mean
// for light from everywhere.
float grazing_of(float cosine)
{
    return 21.0 * pow_5(clamp(1.0 - cosine, 0.0, 1.0));
}

// What microfacets of Fresnel's (1 - cosine)^5 reflect once of even light: a fit, within 0.003.
float grazing_reflectance(float roughness)
{
    float r = roughness;
    return max(0.0494 + r * (-0.0181 + r * (-0.1335 + r * 0.1070)), 0.0);
}

// What microfacets of Fresnel's 1 reflect once of even light: a fit, within 0.003.
float once_of_even_light(float roughness)
{
    float r = roughness;
    return 0.9998 + r * (-0.0143 + r * (0.3322 + r * (-2.2012 + r * 1.2952)));
}
#endif

// Share of light that leaves again in all directions, for light that has been scattered so often
// that where it goes hardly matters: of light that arrives evenly.
vec3 even_reflectance(Brdf brdf)
{
#if GLOSSY
    // Of the light that enters the diffuse part 0.0037 (f90 - f0) is reflected before.
    float all = once_of_even_light(brdf.roughness);
    float grazing = grazing_reflectance(brdf.roughness);
    vec3 enters = is_glossy(brdf) ? vec3(1.0) - mix(brdf.f0, vec3(brdf.f90), 0.0037) : vec3(1.0);
    vec3 gloss = brdf.f0 * (all - grazing) + brdf.f90 * grazing;
    gloss *= 1.0 + brdf.f0 * (1.0 / all - 1.0);
    return brdf.albedo * enters + (is_glossy(brdf) ? gloss : vec3(0.0));
#else
    return brdf.albedo;
#endif
}

#if GLOSSY
// What the share rises by with how grazing the light arrives.
vec3 reflectance_slope(Brdf brdf)
{
    vec3 range = brdf.f90 - brdf.f0;
    return is_glossy(brdf) ? range * grazing_reflectance(brdf.roughness) : vec3(0.0);
}
#endif

// Radiance that diffuse reflection makes of an irradiance, the same in all directions.
vec3 diffuse_radiance(Brdf brdf, vec3 irradiance)
{
    return brdf.albedo * INV_PI * irradiance;
}

// The same towards w_out, less what the reflecting layer keeps of evenly spread light.
vec3 diffuse_radiance_towards(Brdf brdf, vec3 normal, vec3 w_out, vec3 irradiance)
{
#if GLOSSY
    float cos_out = clamp(dot(normal, w_out), 0.0, 1.0);
    irradiance *= vec3(1.0) - mean_fresnel(brdf, cos_out);
#endif
    return diffuse_radiance(brdf, irradiance);
}

// What leaves in all directions together of evenly spread light, as if it were diffuse:
// what a surface sends on to others that do not look closely.
vec3 sent_radiance(Brdf brdf, vec3 irradiance)
{
#if GLOSSY
    // Mean of Schlick's fifth power over both directions: 1 / 21 for the microfacets (GGX
    // loses some of it), 0.0037 for the light below.
    vec3 reflected = brdf.f0 + (brdf.f90 - brdf.f0) * (1.0 / 21.0);
    vec3 lost = brdf.f0 + (brdf.f90 - brdf.f0) * 0.0037;
    vec3 share = brdf.albedo * (vec3(1.0) - lost) + reflected;
    return min(share, vec3(1.0)) * INV_PI * irradiance;
#else
    return diffuse_radiance(brdf, irradiance);
#endif
}
