// What a ray of a surfel met, in two words: the surfel there (16 bits, all set: nothing was met)
// and its albedo, red, green and blue (16 bits each). With gloss 14 bits each, and 6 for how much
// the albedo falls when light arrives upright: `slope`.

#if GLOSSY
// That of a smooth dielectric, about.
const float MOST_SLOPE = 0.05;
#endif

const uint NO_SURFEL = 0xffffu;

struct SurfelHit {
    uint surfel;
    vec3 albedo;
    float slope;
};

uvec2 packed_hit(SurfelHit hit)
{
    vec3 albedo = clamp(hit.albedo, 0.0, 1.0);
#if GLOSSY
    uint slope = uint(clamp(hit.slope / MOST_SLOPE, 0.0, 1.0) * 63.0 + 0.5);
    uvec3 parts = uvec3(albedo * 16383.0 + 0.5) << 2u
                | (uvec3(slope) >> uvec3(4u, 2u, 0u) & uvec3(3u));
#else
    uvec3 parts = uvec3(albedo * 65535.0 + 0.5);
#endif
    return uvec2(hit.surfel | parts.x << 16, parts.y | parts.z << 16);
}

SurfelHit unpacked_hit(uvec2 words)
{
    uvec3 parts = uvec3(words.x >> 16, words.y & 0xffffu, words.y >> 16);
#if GLOSSY
    uvec3 low = parts & uvec3(3u);
    vec3 albedo = vec3(parts >> 2u) * (1.0 / 16383.0);
    float slope = float(low.x << 4u | low.y << 2u | low.z) * (MOST_SLOPE / 63.0);
#else
    vec3 albedo = vec3(parts) * (1.0 / 65535.0);
    float slope = 0.0;
#endif
    return SurfelHit(words.x & NO_SURFEL, albedo, slope);
}
