// The scene's lights in view space, and the irradiance of each without any shadow.
//
// What differs between kinds is in a file for each, lights/<kind>.glsl. Of a light with
// an area it defines
//     vec3 <kind>_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
//     float <kind>_distance(Light light, vec3 p_vs, vec3 w): along w to the side that emits,
//         FLOAT_MAX if w misses it
//     vec3 <kind>_point(Light light, vec2 u): evenly over the area for u in [0, 1]^2
//         (soft shadows of gi take it for the parallelogram about row 1 whose half edges are rows
//         3 and 4)
//     vec3 <kind>_normal(Light light, vec3 p_vs): of unit length, on the side of p_vs
// and of any other
//     float <kind>_falloff(Light light, vec3 to_light): of its intensity with direction.
// lights/kinds.glsl, which chooses between them, is made from the list of kinds.
//
// A light is LIGHT_ROWS vectors (written by passes/light_rows.py):
//        xyz                                            w
//   0    kind, shadow, parts with a shadow map each     1 if both sides emit
//        along an edge of a rectangle
//   1    position, centre of an area, unit direction    first number of the kind's own;
//        TOWARDS a parallel light                       of parallel light its spread
//   2    intensity (W/sr), irradiance (parallel),       second number
//        radiance (area)
//   3    axis of the kind's own                         half width of a shadow map's face:
//                                                       a tangent, or a length if parallel
//   4    second axis                                    half height
//   5..7 rows of light_from_view: +z is where the       column and row of the first face in
//        light shines                                   the atlas, its size, all in tiles
//   8    origin of the shadow map                       faces of the shadow map
//
// HAS_SHADING_NORMALS (default 1): 0 promises that n and m below are the same.
#include "lib/constants.glsl"
#include "lib/angle.glsl"

#ifndef HAS_SHADING_NORMALS
#define HAS_SHADING_NORMALS 1
#endif

#define LIGHT_ROWS 9
#define UNSHADOWED_ROWS 5  // the first of them, which do without a shadow map

// Form in ssdo_gl/scene/lights/base.py.
#define FORM_POINT 0
#define FORM_PARALLEL 1
#define FORM_AREA 2

#define SHADOW_NONE 0
#define SHADOW_MAP 1
#define SHADOW_SSDO 2

struct Light {
    int kind;
    int shadow;
    bool two_sided;
    vec3 place_vs;        // row 1
    vec3 power;           // row 2
    vec3 axis_vs;         // row 3
    vec3 second_axis_vs;  // row 4
    vec2 numbers;
};

Light light_from_rows(vec4 rows[UNSHADOWED_ROWS])
{
    return Light(int(rows[0].x), int(rows[0].y), rows[0].w > 0.5, rows[1].xyz, rows[2].rgb,
                 rows[3].xyz, rows[4].xyz, vec2(rows[1].w, rows[2].w));
}

// Lights reach no surface nearer than a few roundings of float32: there a position no
// longer says on which side of the light it lies. Relative to the distance from the eye.
const float LIGHT_ROUNDING = 4.0 * FLOAT_EPSILON;
// Bound on irradiance, so that a light within rounding of a surface stays finite and
// sums of many lights do, too. No picture comes near it.
const float IRRADIANCE_MAX = 1e30;

float largest_component(vec3 v)
{
    vec3 a = abs(v);
    return max(a.x, max(a.y, a.z));
}

vec3 bounded_irradiance(vec3 e)
{
    return vec3(e.r < IRRADIANCE_MAX ? e.r : IRRADIANCE_MAX,
                e.g < IRRADIANCE_MAX ? e.g : IRRADIANCE_MAX,
                e.b < IRRADIANCE_MAX ? e.b : IRRADIANCE_MAX);
}

#include "lights/kinds.glsl"

// Irradiance of a light without size: intensity * cos / distance^2.
vec3 point_form_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    vec3 to_light = light.place_vs - p_vs;
    float scale = largest_component(to_light);
    if (!(scale > 0.0)) {
        return vec3(0.0);
    }
    vec3 scaled = to_light / scale;
    float distance_scaled = length(scaled);
    vec3 w = scaled / distance_scaled;
    float cos_theta = dot(w, m_vs) > 0.0 ? max(dot(w, n_vs), 0.0) : 0.0;
    cos_theta *= light_falloff(light, w);
    // One factor at a time: the square of a tiny distance would underflow to 0, and
    // 0 * infinity is NaN.
    float distance = scale * distance_scaled;
    return bounded_irradiance(light.power / distance * cos_theta / distance);
}

// Parallel light strays from its direction to the points of a disk across it, at distance 1,
// whose radius is its spread (0: a sharp light) and whose parts all give as much irradiance
// to a surface that faces the light. This is the mean of max(0, cosine) over the disk, where
// the cosine towards its middle is `cosine`: it follows from (2 / pi) sqrt(1 - x^2), the
// share of a unit disk at x. Wholly above the horizon, a disk gives as much as its middle.
float disk_cosine(float spread, float cosine)
{
    float change = spread * sqrt(max(1.0 - cosine * cosine, 0.0));
    if (!(abs(cosine) < change)) {
        return max(cosine, 0.0);
    }
    float h = cosine / change;
    float chord = sqrt(1.0 - h * h);
    float above = h * (HALF_PI + asin(h) + h * chord) + (2.0 / 3.0) * chord * chord * chord;
    return change * INV_PI * above;
}

// The point of the disk at `u` in the unit square, in a frame around the direction.
vec2 disk_point(float spread, vec2 u)
{
    return spread * sqrt(u.x) * vec2(cos(TWO_PI * u.y), sin(TWO_PI * u.y));
}

vec3 parallel_irradiance(Light light, vec3 n_vs, vec3 m_vs)
{
    float spread = light.numbers.x;
    float cos_theta = disk_cosine(spread, dot(light.place_vs, n_vs));
    float cos_m = dot(light.place_vs, m_vs);
    bool is_above = cos_m > 0.0 || disk_cosine(spread, cos_m) > 0.0;
    return is_above ? light.power * cos_theta * light_falloff(light, light.place_vs) : vec3(0.0);
}

// Irradiance at `p` from one light without shadow, on a surface with shading normal `n`
// and geometric normal `m` (both on the camera's side, unit length). Light from below the
// geometric horizon does not count. A kind that is not listed gives none.
vec3 unshadowed_irradiance(Light light, vec3 p_vs, vec3 n_vs, vec3 m_vs)
{
    int form = light_form(light.kind);
    if (form == FORM_AREA) {
        return area_irradiance(light, p_vs, n_vs, m_vs);
    }
    if (form == FORM_PARALLEL) {
        return parallel_irradiance(light, n_vs, m_vs);
    }
    return form == FORM_POINT ? point_form_irradiance(light, p_vs, n_vs, m_vs) : vec3(0.0);
}
