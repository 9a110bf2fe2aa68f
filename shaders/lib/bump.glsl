// Normals from images, in the tangent space of their texture coordinates.

// The directions on a surface in which texture coordinates grow, without the normal.
struct TangentFrame {
    vec3 dp_1;  // two steps on the triangle, counter-clockwise seen from its lit side
    vec3 dp_2;
    vec2 duv_1; // and what they change
    vec2 duv_2;
};

TangentFrame tangent_frame(vec3 dp_1, vec3 dp_2, vec2 duv_1, vec2 duv_2)
{
    return TangentFrame(dp_1, dp_2, duv_1, duv_2);
}

// A texel of a normal map in -1..1. Its y points to smaller v, to the top of the image.
vec3 mapped_normal(vec3 texel, float scale)
{
    vec3 n = 2.0 * texel - 1.0;
    n = vec3(n.x * scale, -n.y * scale, n.z);
    // A texel of no direction, or of a NaN, stands for an even surface.
    return dot(n, n) > 1e-4 ? n : vec3(0.0, 0.0, 1.0);
}

// The unit normal that `mapped` stands for: Schueler 2013, "Normal Mapping Without
// Precomputed Tangents". It stays on the side of the triangle's own normal.
vec3 bumped_normal(vec3 normal, vec3 geometric, TangentFrame frame, vec3 mapped)
{
    vec3 across_1 = cross(normal, frame.dp_1);
    vec3 across_2 = cross(frame.dp_2, normal);
    vec3 tangent = across_2 * frame.duv_1.x + across_1 * frame.duv_2.x;
    vec3 bitangent = across_2 * frame.duv_1.y + across_1 * frame.duv_2.y;
    float size_2 = max(dot(tangent, tangent), dot(bitangent, bitangent));
    if (!(size_2 > 0.0)) {
        return normal;
    }
    vec3 tilted = (mapped.x * tangent + mapped.y * bitangent) * inversesqrt(size_2)
                + mapped.z * normal;
    float height = dot(tilted, geometric);
    tilted -= min(height - 1e-3 * length(tilted), 0.0) * geometric;
    float size = length(tilted);
    return size > 1e-6 ? tilted / size : normal;
}
