// Normals from images, in the tangent space of their texture coordinates.

// The directions on a surface in which texture coordinates grow, up to a common factor; 0
// where there are none. Both turn with the normal where that is turned to the back.
struct TangentFrame {
    vec3 along_u;
    vec3 along_v;
};

// That of two steps on the triangle, counter-clockwise seen from the side of the normal, and
// what they change: Schueler 2013, "Normal Mapping Without Precomputed Tangents".
// `side` is -1 on the back.
TangentFrame frame_of_steps(vec3 normal, vec3 dp_1, vec3 dp_2, vec2 duv_1, vec2 duv_2, float side)
{
    vec3 across_1 = cross(normal, dp_1);
    vec3 across_2 = cross(dp_2, normal);
    vec3 along_u = across_2 * duv_1.x + across_1 * duv_2.x;
    vec3 along_v = across_2 * duv_1.y + across_1 * duv_2.y;
    return TangentFrame(along_u * side, along_v * side);
}

// That of the file's tangent, w its handedness; `steps` where it has none. `side` is -1 where
// the normal is the file's turned around.
TangentFrame frame_of_tangent(vec3 normal, vec4 tangent, float side, TangentFrame steps)
{
    vec3 along_u = tangent.xyz - dot(tangent.xyz, normal) * normal;
    float size_2 = dot(along_u, along_u);
    if (!(size_2 > 1e-8)) {
        return steps;
    }
    along_u *= inversesqrt(size_2);
    // The top of the image lies where v is small.
    vec3 along_v = cross(along_u, normal);
    return TangentFrame(along_u * side, tangent.w < 0.0 ? -along_v : along_v);
}

// A texel of a normal map in -1..1. Its y points to smaller v, to the top of the image.
vec3 mapped_normal(vec3 texel, float scale)
{
    vec3 n = 2.0 * texel - 1.0;
    n = vec3(n.x * scale, -n.y * scale, n.z);
    // A texel of no direction, or of a NaN, stands for an even surface.
    return dot(n, n) > 1e-4 ? n : vec3(0.0, 0.0, 1.0);
}

// Roughness of facets that lie about normals which spread over GGX of width `spread`.
float widened_roughness(float roughness, float spread)
{
    float wide = sqrt(roughness * roughness * roughness * roughness + spread * spread);
    return spread != 0.0 ? min(sqrt(wide), 1.0) : roughness;
}

// The unit normal that `mapped` stands for. It stays on the side of the triangle's own.
vec3 bumped_normal(vec3 normal, vec3 geometric, TangentFrame frame, vec3 mapped)
{
    float size_2 = max(dot(frame.along_u, frame.along_u), dot(frame.along_v, frame.along_v));
    if (!(size_2 > 0.0)) {
        return normal;
    }
    vec3 tilted = (mapped.x * frame.along_u + mapped.y * frame.along_v) * inversesqrt(size_2)
                + mapped.z * normal;
    float height = dot(tilted, geometric);
    tilted -= min(height - 1e-3 * length(tilted), 0.0) * geometric;
    float size = length(tilted);
    return size > 1e-6 ? tilted / size : normal;
}
