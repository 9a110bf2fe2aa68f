// The surface that a ray has hit, with what it takes to shade it.
#include "lib/brdf.glsl"
#include "rays/ray.glsl"
#include "lib/normals.glsl"

struct Surface {
    RaySurface at;       // normals on the side that the ray came from
    Brdf brdf;
    vec3 emission;       // towards the ray
    float mean_emission; // of the material, both sides together, without its texture
    float area_cosine;   // between the ray and the triangle
    uint flags;          // of the material's word
};

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
    s.brdf = Brdf(albedo_of(word, corners, weights).rgb);
#if RAY_TEXTURES
    vec4 place = material_texel(word, 3);
    vec2 emission_uv = interpolated_uv(emission_corners_of(slot, corners), weights);
    vec3 texture_color = place.z != 0.0 ? atlas_color(place, emission_uv).rgb : vec3(1.0);
#else
    const vec3 texture_color = vec3(1.0);
#endif
#else
    s.brdf = Brdf(material_texel(word, 0).rgb);
    const vec3 texture_color = vec3(1.0);
#endif
    bool two_sided = emission.a > 0.5;
    s.emission = is_front || two_sided ? emission.rgb * texture_color : vec3(0.0);
    s.mean_emission = (emission.r + emission.g + emission.b) * (two_sided ? 2.0 / 3.0 : 1.0 / 3.0);
    return s;
}
