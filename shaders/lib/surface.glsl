// The surface that a ray has hit, with what it takes to shade it.
#include "lib/brdf.glsl"
#include "rays/ray.glsl"
#include "lib/normals.glsl"
#include "lib/bump.glsl"

struct Surface {
    RaySurface at;       // normals on the side that the ray came from
    Brdf brdf;
    vec3 emission;       // towards the ray
    float mean_emission; // of the material, both sides together, without its texture
    float area_cosine;   // between the ray and the triangle
    uint flags;          // of the material's word
};

#if GLOSSY
// Of a material without images, or what these multiply: metallic, roughness, reflectance
// and strength of its dielectric part.
Brdf brdf_of_numbers(vec3 base, vec4 metal_rough, vec4 dielectric)
{
    return metallic_roughness_brdf(base, metal_rough.x, metal_rough.y,
                                   dielectric.rgb * dielectric.a, dielectric.a);
}
#endif

#if RAY_SMOOTH_NORMALS || RAY_VERTEX_COLORS || RAY_TEXTURES
Brdf brdf_of(uint word, int slot, Corners corners, vec3 weights)
{
    vec3 base = albedo_of(word, corners, weights).rgb;
#if GLOSSY
    return brdf_of_numbers(base, metal_rough_of(word, slot, corners, weights),
                           dielectric_of(word, slot, corners, weights));
#else
    return diffuse_brdf(base);
#endif
}
#else
Brdf even_brdf(uint word)
{
    vec3 base = material_texel(word, 0).rgb;
#if GLOSSY
    return brdf_of_numbers(base, material_texel(word, 5), material_texel(word, 6));
#else
    return diffuse_brdf(base);
#endif
}
#endif

#if RAY_NORMAL_MAPS
// Tilts the shading normal as the material's image says.
void bump(inout Surface s, uint word, int slot, Corners corners, vec3 weights, vec3 a, vec3 b,
          vec3 c)
{
    vec4 place = material_texel(word, NORMAL_IMAGE);
    if (place.z == 0.0) {
        return;
    }
    Corners own = corners_of_image(word, NORMAL_IMAGE, slot, corners);
    vec2 uv_a = interpolated_uv(own, vec3(1.0, 0.0, 0.0));
    vec2 along_b = interpolated_uv(own, vec3(0.0, 1.0, 0.0)) - uv_a;
    vec2 along_c = interpolated_uv(own, vec3(0.0, 0.0, 1.0)) - uv_a;
    bool is_front = dot(cross(b - a, c - a), s.at.geometric) > 0.0;
    vec3 n = s.at.normal;
    TangentFrame frame = is_front ? frame_of_steps(n, b - a, c - a, along_b, along_c, 1.0)
                                  : frame_of_steps(n, c - a, b - a, along_c, along_b, -1.0);
#if RAY_TANGENTS && RAY_SMOOTH_NORMALS
    vec4 tangent = interpolated_tangent(corners_of(slot + u_second_slot), weights);
    bool is_turned = dot(interpolated_normal(corners, weights), n) < 0.0;
    frame = frame_of_tangent(n, tangent, is_turned ? -1.0 : 1.0, frame);
#endif
    vec3 texel = atlas_color(place, interpolated_uv(own, weights)).rgb;
    vec3 mapped = mapped_normal(texel, material_texel(word, 5).z);
    s.at.normal = bumped_normal(n, s.at.geometric, frame, mapped);
}
#endif

// Share of light that leaves again, of what the surface's triangle receives. From below it nothing arrives:
// the farther a normal map tilts the shading normal, the less of even light is left.
vec3 reflectance_of_facet(Surface s)
{
    vec3 share = even_reflectance(s.brdf);
#if RAY_NORMAL_MAPS
    share *= s.at.is_smooth ? 1.0 : 0.5 + 0.5 * dot(s.at.normal, s.at.geometric);
#endif
    return share;
}

#if GLOSSY
// How much less of it leaves where light arrives upright: gloss reflects less, and of such light tilted
// normals receive the share c, where they receive (1 + c) / 2 of even light.
vec3 facet_slope(Surface s)
{
    vec3 slope = reflectance_slope(s.brdf);
#if RAY_NORMAL_MAPS
    bool is_tilted = !s.at.is_smooth && largest_of(s.brdf.f0) <= 0.1;
    slope += is_tilted ? even_reflectance(s.brdf) * (0.5 - 0.5 * dot(s.at.normal, s.at.geometric)) : vec3(0.0);
#endif
    return slope;
}
#endif

Surface surface_at_hit(BvhHit hit, vec3 origin, vec3 w)
{
    vec3 a, b, c;
    bvh_triangle(hit, a, b, c);
    uvec4 words = bvh_texel(hit.record, 3);
    uint word = hit.is_second ? words.z : words.y;
    vec3 front = triangle_normal(a, b, c);
    float facing = dot(front, w);
    bool is_front = facing <= 0.0;
    Surface s;
    s.at.geometric = is_front ? front : -front;
    // t is off by some roundings of its own length; the plane is not.
    vec3 p = origin + hit.t * w;
    s.at.w_out = -w;
    s.at.position = p - front * dot(p - a, front);
    s.at.start = ray_start(s.at.position, s.at.geometric, w, RAY_OFFSET);
    s.at.normal = s.at.geometric;
    s.at.lift = vec3(0.0);
    s.at.is_smooth = false;
    s.area_cosine = abs(facing);
    s.flags = word;
    vec4 emission = material_texel(word, 1);
#if RAY_SMOOTH_NORMALS || RAY_VERTEX_COLORS || RAY_TEXTURES
    vec3 weights = weights_of_corners(s.at.position, a, b, c, front);
    int slot = int(words.x) * 2 + (hit.is_second ? 1 : 0);
    Corners corners = corners_of(slot);
#if RAY_SMOOTH_NORMALS
    vec3 smoothed = interpolated_normal(corners, weights);
    smoothed *= faces_back(smoothed, front) == is_front ? -1.0 : 1.0;
    float size_2 = dot(smoothed, smoothed);
    s.at.is_smooth = (word & SMOOTH_FLAG) != 0u && size_2 > 1e-12;
    if (s.at.is_smooth) {
        s.at.normal = smoothed * inversesqrt(size_2);
        s.at.lift = lift_onto_corner_planes(
            s.at.position, a, b, c, weights, corners, s.at.normal);
    }
#endif
#if RAY_NORMAL_MAPS
    bump(s, word, slot, corners, weights, a, b, c);
#endif
    s.brdf = brdf_of(word, slot, corners, weights);
#if RAY_TEXTURES
    vec4 place = material_texel(word, EMISSION_IMAGE);
    vec2 emission_uv = interpolated_uv(corners_of_image(word, EMISSION_IMAGE, slot, corners), weights);
    vec3 texture_color = place.z != 0.0 ? atlas_color(place, emission_uv).rgb : vec3(1.0);
#else
    const vec3 texture_color = vec3(1.0);
#endif
#else
    s.brdf = even_brdf(word);
    const vec3 texture_color = vec3(1.0);
#endif
    bool two_sided = emission.a > 0.5;
    s.emission = is_front || two_sided ? emission.rgb * texture_color : vec3(0.0);
    if (emission.a > 1.5) {
        // Unlit: it shows its own colour, whatever the light.
        s.emission = s.brdf.albedo;
        s.brdf = diffuse_brdf(vec3(0.0));
    }
    s.mean_emission = (emission.r + emission.g + emission.b) * (two_sided ? 2.0 / 3.0 : 1.0 / 3.0);
    return s;
}
