// Triangles that compute shaders rasterize: which pixels they cover, and at which depth.
//
// A pixel is covered if the ray through its centre meets the triangle, edges included: of two
// triangles that share an edge no pixel is left out, because each has the other's edge with its
// sign turned, to the last bit. In homogeneous coordinates nothing need be clipped (Olano and
// Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997).
#include "lib/space.glsl"

uniform mat4 u_clip_from_view;
uniform float u_unit;     // what coordinates are multiplied with, that their products stay in range
uniform float u_near_vs;  // what is nearer is cut off
uniform int u_gives_ids;  // the depths are known: which triangles have them

// Keys grow towards the camera, 0 is background: complements of depths, and of numbers.
layout(binding = 0, r32ui) uniform uimage2D u_depth_keys;
layout(binding = 1, r32ui) uniform uimage2D u_ids;

struct Triangle {
    vec3 edge_0;     // positive inside: dot(edge, (x, y, 1)) at normalised device coordinates
    vec3 edge_1;
    vec3 edge_2;
    vec3 normal_vs;  // of any length
    vec3 corner_vs;
    vec2 depths;     // the nearest and the farthest corner
    uint id;
};

// Its sign alone turns with the order of the points.
vec3 edge_between(vec3 a, vec3 b)
{
    precise vec3 one = a.yzx * b.zxy;
    precise vec3 other = a.zxy * b.yzx;
    precise vec3 edge = one - other;
    return edge;
}

vec3 homogeneous(vec3 p_vs)
{
    return (u_clip_from_view * vec4(p_vs, 1.0)).xyw * u_unit;
}

// Positive where the corners run counter-clockwise, seen from the camera.
float turn_of(vec3 normal_vs, vec3 corner_vs)
{
    return -dot(normal_vs, viewing_direction(corner_vs, AHEAD_VS));
}

float depth_of(Triangle t, vec2 uv)
{
    vec3 start = position_vs_at(uv, 0.0);
    vec3 ray = position_vs_at(uv, 1.0) - start;
    float slope = dot(t.normal_vs, ray);
    float depth = dot(t.normal_vs, t.corner_vs - start) / slope;
    return slope != 0.0 ? clamp(depth, t.depths.x, t.depths.y) : 0.5 * (t.depths.x + t.depths.y);
}

void put_pixel(Triangle t, ivec2 pixel)
{
    vec2 uv = (vec2(pixel) + 0.5) / u_frame_size_px;
    vec3 place = vec3(2.0 * uv - 1.0, 1.0);
    precise float a = dot(t.edge_0, place);
    precise float b = dot(t.edge_1, place);
    precise float c = dot(t.edge_2, place);
    if (min(a, min(b, c)) < 0.0) {
        return;
    }
    float z = depth_of(t, uv);
    if (!(z >= u_near_vs)) {
        return;
    }
    uint key = ~floatBitsToUint(z);
    if (u_gives_ids == 0) {
        imageAtomicMax(u_depth_keys, pixel, key);
    } else if (imageLoad(u_depth_keys, pixel).x == key) {
        imageAtomicMax(u_ids, pixel, ~t.id);
    }
}
