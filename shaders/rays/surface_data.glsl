// Tables of what rays hit: where a record lies, and what materials look like.
//
// RAY_SMOOTH_NORMALS, RAY_VERTEX_COLORS, RAY_TEXTURES, RAY_CUTOUTS,
// RAY_SINGLE_SIDED, RAY_SECOND_UVS, RAY_NORMAL_MAPS, RAY_TANGENTS, GLOSSY: what the scene has.
// GLOW_IS_DIRECT (default 0): all that glows counts as direct light.
// Layouts: ssdo_gl/raytracing/surface_tables.py.
// LOBES (default 0): some surfaces send on by directions, rays/surfel_lobes.glsl; with GLOSSY alone.
#ifndef LOBES
#define LOBES 0
#endif
#ifndef GLOW_IS_DIRECT
#define GLOW_IS_DIRECT 0
#endif
#include "lib/octahedral.glsl"

uniform usampler2D t_ray_surfaces;
uniform sampler2D t_ray_materials;
uniform sampler2D t_ray_atlas;
uniform sampler2D t_ray_data_atlas;  // images whose numbers count, not sRGB
#if RAY_SECOND_UVS || RAY_TANGENTS
uniform int u_second_slot;          // where the second coordinates and tangents of slot 0 are
#endif

// Texels of the material table.
#define ALBEDO_IMAGE 2
#define EMISSION_IMAGE 3
#define METALLIC_ROUGHNESS_IMAGE 7
#define SPECULAR_IMAGE 8
#define SPECULAR_COLOR_IMAGE 9
#if RAY_NORMAL_MAPS
#define NORMAL_IMAGE 10
#endif

// A row of a table holds 1024 records, of 4 texels but for corners.
const int BVH_ROW_SHIFT = 10;
const int RECORD_TEXELS = 4;

const uint SMOOTH_FLAG = 0x80000000u;
const uint LIGHT_BODY_FLAG = 0x40000000u;       // its light is in the scene's lights
const uint SINGLE_SIDED_FLAG = 0x20000000u;     // what comes from behind passes
const uint MATERIAL_MASK = 0x1fffffffu;

// Texels of a record of corners: normals; texture coordinates, tangents; colours.
#if RAY_VERTEX_COLORS
#define SURFACE_TEXELS 4
#elif RAY_TEXTURES
#define SURFACE_TEXELS 3
#else
#define SURFACE_TEXELS 1
#endif

// Place of the first of a record's texels.
ivec2 record_place(int record, int texels)
{
    return ivec2((record & ((1 << BVH_ROW_SHIFT) - 1)) * texels, record >> BVH_ROW_SHIFT);
}

vec4 material_texel(uint word, int texel)
{
    return texelFetch(t_ray_materials, ivec2(texel, int(word & MATERIAL_MASK)), 0);
}

// Whether the triangle is the body of a light that passes through everything.
bool is_unshadowed_body(uint word)
{
    return material_texel(word, 4).y > 0.5;
}

// Whether what a triangle emits, of that mean, arrives as direct light: rays do not gather it.
bool counts_as_direct(uint word, float mean_emission)
{
#if GLOW_IS_DIRECT
    // That of lights, and by rays to all other bodies; not of what is unlit, which has no mean.
    return mean_emission > 0.0;
#else
    return (word & LIGHT_BODY_FLAG) != 0u;
#endif
}

// Whether it is the body of a light that is direct and casts shadows.
bool is_direct_body(uint word)
{
    return material_texel(word, 4).z > 0.5;
}

// What the corners of a triangle carry, words as in the table.
struct Corners {
    uvec4 words_0;
    uvec4 words_1;
    uvec4 words_2;
    uvec4 words_3;
};

uvec4 surface_texel(int slot, int texel)
{
    return texel < SURFACE_TEXELS
         ? texelFetch(t_ray_surfaces, record_place(slot, SURFACE_TEXELS) + ivec2(texel, 0), 0) : uvec4(0u);
}

Corners corners_of(int slot)
{
    return Corners(surface_texel(slot, 0), surface_texel(slot, 1), surface_texel(slot, 2),
                   surface_texel(slot, 3));
}

// The corners whose texture coordinates are those of one of the material's images.
Corners corners_of_image(uint word, int image, int slot, Corners corners)
{
#if RAY_SECOND_UVS
    bool is_second = ((int(material_texel(word, 5).w) >> image) & 1) != 0;
    return is_second ? corners_of(slot + u_second_slot) : corners;
#else
    return corners;
#endif
}

#if RAY_SMOOTH_NORMALS
vec3 normal_of_word(uint word)
{
    // 0..65534 stands for -1..1: see oct_encode.
    return oct_unproject(vec2(word & 0xffffu, word >> 16) * (1.0 / 32767.0) - 1.0);
}

vec3 interpolated_normal(Corners c, vec3 weights)
{
    return weights.x * normal_of_word(c.words_0.x) + weights.y * normal_of_word(c.words_0.y)
         + weights.z * normal_of_word(c.words_0.z);
}
#endif

#if RAY_TANGENTS && RAY_SMOOTH_NORMALS
// Of a second row: direction, 0 where there is none, and handedness.
vec4 interpolated_tangent(Corners c, vec3 weights)
{
    uvec3 signs = (c.words_2.yyy >> uvec3(0u, 2u, 4u)) & 3u;
    vec3 share = weights * vec3(notEqual(signs, uvec3(0u)));
    vec3 t = share.x * normal_of_word(c.words_0.x) + share.y * normal_of_word(c.words_0.y)
           + share.z * normal_of_word(c.words_0.z);
    return vec4(t, dot(share, 2.0 - vec3(signs)));
}
#endif

vec2 interpolated_uv(Corners c, vec3 weights)
{
    return weights.x * vec2(uintBitsToFloat(c.words_0.w), uintBitsToFloat(c.words_1.x))
         + weights.y * uintBitsToFloat(c.words_1.yz)
         + weights.z * vec2(uintBitsToFloat(c.words_1.w), uintBitsToFloat(c.words_2.x));
}

vec4 color_of_words(uint rg, uint ba)
{
    return vec4(rg & 0xffffu, rg >> 16, ba & 0xffffu, ba >> 16) * (1.0 / 65535.0);
}

vec4 interpolated_color(Corners c, vec3 weights)
{
    return weights.x * color_of_words(c.words_2.y, c.words_2.z)
         + weights.y * color_of_words(c.words_2.w, c.words_3.x)
         + weights.z * color_of_words(c.words_3.y, c.words_3.z);
}

// The texel of an image in the atlas; `place` as in the material table.
vec4 atlas_texel(vec4 place, vec2 t)
{
    vec2 size = abs(place.zw);
    vec2 kept = clamp(t, vec2(0.0), size - 1.0);
    vec2 repeated = t - size * floor(t / size);
    vec2 inside = vec2(place.z < 0.0 ? kept.x : repeated.x, place.w < 0.0 ? kept.y : repeated.y);
    // Rounding of t / size may give `size` itself.
    inside = min(inside, size - 1.0);
    ivec2 texel = ivec2(place.xy + inside);
    bool is_data = fract(place.y) != 0.0;
    // Looked up, which decodes sRGB in software, too: there a fetch may read it as it is stored.
    vec2 color_place = (vec2(texel) + 0.5) / vec2(textureSize(t_ray_atlas, 0));
    return is_data ? texelFetch(t_ray_data_atlas, texel, 0) : textureLod(t_ray_atlas, color_place, 0.0);
}

// Bilinear, as the rasterizer magnifies. Finer levels than its mip maps choose blur
// nothing, since each hit is averaged over all samples anyway.
vec4 atlas_color(vec4 place, vec2 uv)
{
    bool is_nearest = fract(place.x) != 0.0;
    vec2 t = uv * abs(place.zw) - (is_nearest ? 0.0 : 0.5);
    vec2 low = floor(t);
    vec2 f = is_nearest ? vec2(0.0) : t - low;
    return mix(mix(atlas_texel(place, low), atlas_texel(place, low + vec2(1.0, 0.0)), f.x),
               mix(atlas_texel(place, low + vec2(0.0, 1.0)), atlas_texel(place, low + 1.0), f.x),
               f.y);
}

// Albedo and alpha of the material at a point of a triangle.
vec4 albedo_of(uint word, Corners c, vec3 weights)
{
    vec4 albedo = material_texel(word, 0);
#if RAY_VERTEX_COLORS
    albedo *= interpolated_color(c, weights);
#endif
#if RAY_TEXTURES
    vec4 place = material_texel(word, ALBEDO_IMAGE);
    albedo *= place.z != 0.0 ? atlas_color(place, interpolated_uv(c, weights)) : vec4(1.0);
#endif
    return albedo;
}

#if GLOSSY
// One of the material's images at a point, or white.
vec4 image_of(uint word, int image, int slot, Corners c, vec3 weights)
{
#if RAY_TEXTURES
    vec4 place = material_texel(word, image);
    vec2 uv = interpolated_uv(corners_of_image(word, image, slot, c), weights);
    return place.z != 0.0 ? atlas_color(place, uv) : vec4(1.0);
#else
    return vec4(1.0);
#endif
}

// Metallic and roughness.
vec4 metal_rough_of(uint word, int slot, Corners c, vec3 weights)
{
    return material_texel(word, 5) * image_of(word, METALLIC_ROUGHNESS_IMAGE, slot, c, weights).bgra;
}

// Reflectance at normal incidence and strength of the dielectric part.
vec4 dielectric_of(uint word, int slot, Corners c, vec3 weights)
{
    vec4 color = image_of(word, SPECULAR_COLOR_IMAGE, slot, c, weights);
    vec4 strength = image_of(word, SPECULAR_IMAGE, slot, c, weights);
    return min(material_texel(word, 6) * vec4(color.rgb, strength.a), vec4(1.0));
}
#endif

#if RAY_CUTOUTS
const float BY_CHANCE = -2.0;  // see ssdo_gl/raytracing/surface_tables.py

// Whether the material has a hole at the point that the weights, up to a factor, name.
bool is_cut_out(uint word, int slot, vec3 weights)
{
    float total = weights.x + weights.y + weights.z;
    vec3 share = total != 0.0 ? weights / total : vec3(1.0, 0.0, 0.0);
    float alpha = albedo_of(word, corners_of(slot), share).a;
    float cutoff = material_texel(word, 4).x;
    // Alpha as coverage: whether a ray meets the surface is a matter of where it would.
    uint place = floatBitsToUint(share.x) * 0x9e3779b9u ^ floatBitsToUint(share.y) + uint(slot);
    place = (place ^ place >> 15) * 0x2c1b3c6du;
    place = (place ^ place >> 12) * 0x297a2d39u;
    float chance = float((place ^ place >> 15) >> 8) * (1.0 / 16777216.0);
    return cutoff == BY_CHANCE ? alpha <= chance : alpha < cutoff;
}
#endif
