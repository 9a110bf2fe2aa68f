// Points of light: drawn by chance, and how likely a point that a ray has hit was.
//
// Layout of the tables: ssdo_gl/raytracing/emitter_tables.py. Everything is in the normalised
// frame: intensities are per (half-diagonal)^2, so that intensity / distance^2 holds.
// ENVIRONMENT_KIND: see lib/environment.glsl; only a map (3) is drawn from here, the
// others vary too little to be worth it.
#include "lib/constants.glsl"
#include "lib/surface.glsl"
#include "lights/lights.glsl"
#include "lights/spherical_rectangle.glsl"
#include "lights/spherical_triangle.glsl"
#include "lib/environment.glsl"

#define EMITTER_PARALLELOGRAM 0
#define EMITTER_TRIANGLE 1
#define EMITTER_MAP 2
#define EMITTER_LIGHT 3  // the first kind of lights/kinds.glsl; others follow

#define EMITTER_UNSHADOWED 0
#define EMITTER_SHADOWED 1
#define EMITTER_SSDO 2

#define EMITTER_TWO_SIDED 64
#define EMITTER_BODY 128
#define EMITTER_DIRECT 4
#define EMITTER_TREE 24  // bodies that no light stands for (8), or rectangles within them (16)

uniform sampler2D t_ray_emitters;
uniform sampler2D t_ray_emitter_groups;
uniform sampler2D t_ray_map_cells;
uniform int u_emitter_group_count;
uniform float u_emitter_density;  // probability per area and mean emission of being drawn

// Rectangles and triangles that subtend less are drawn from by area: it is as good there, and exact,
// while a solid angle is a difference of angles with an error of some 1e-6.
const float SMALL_SOLID_ANGLE = 0.02;
// Of those as long as half of their distance, as of a tube, most of the area is far away: they are
// drawn from by solid angle down to this, where it is known to 5e-4.
const float SMALL_OF_LONG = 0.002;

float small_solid_angle(vec3 middle, vec3 edge_u, vec3 edge_v)
{
    float longest_2 = max(dot(edge_u, edge_u), dot(edge_v, edge_v));
    return 4.0 * longest_2 > dot(middle, middle) ? SMALL_OF_LONG : SMALL_SOLID_ANGLE;
}

// Distance from a rectangle's plane below which a point counts as lying in it: a quarter
// of what rays start off their surface, ten roundings.
const float COPLANAR = 1e-6;

struct EmitterGroup {
    int first;
    int count;
    int shadow;
    bool is_direct;      // its light is in the scene's lights
    int tree;            // of EMITTER_TREE
    float probability;
};

// Light from one drawn point. Arriving irradiance is `radiance` times the cosine at the
// receiver; the probability of drawing the point is divided out already.
struct LightSample {
    vec3 w;          // towards the light
    float distance;
    vec3 radiance;
    float density;   // of points drawn by area, over solid angle: for weighing against
                     // scattered rays, which is right with any such number; 0 where no
                     // scattered ray could have found the point
};

const LightSample NO_LIGHT = LightSample(vec3(0.0, 0.0, 1.0), 0.0, vec3(0.0), 0.0);

// An entry takes two records of 4 texels.
vec4 emitter_texel(int entry, int texel)
{
    ivec2 place = record_place(2 * entry, RECORD_TEXELS);
    return texelFetch(t_ray_emitters, place + ivec2(texel, 0), 0);
}

// A texture has no more than some thousand rows: 256 groups stand in each.
vec4 emitter_group_texel(int group, int texel)
{
    return texelFetch(t_ray_emitter_groups, ivec2(2 * (group & 255) + texel, group >> 8), 0);
}

EmitterGroup emitter_group(int group)
{
    vec4 head = emitter_group_texel(group, 0);
    int code = int(head.z);
    return EmitterGroup(int(head.x), int(head.y), code & 3, (code & EMITTER_DIRECT) != 0,
                        code & EMITTER_TREE, head.w);
}

// What is left of u in [0, 1), uniform again, once it has chosen a share that ends at `end`.
float rest_of_choice(float u, float end, float share)
{
    return clamp((u - (end - share)) / max(share, 1e-30), 0.0, 1.0 - FLOAT_EPSILON);
}

// The group that u in [0, 1) falls on.
EmitterGroup draw_emitter_group(inout float u)
{
    int low = 0;
    int high = u_emitter_group_count - 1;
    while (low < high) {
        int middle = (low + high) >> 1;
        bool is_left = u < emitter_group_texel(middle, 1).x;
        high = is_left ? middle : high;
        low = is_left ? low : middle + 1;
    }
    EmitterGroup group = emitter_group(low);
    u = rest_of_choice(u, emitter_group_texel(low, 1).x, group.probability);
    return group;
}

// Software rasterizers end the loops of a shader after 65535 turns in all, of which a ray takes
// some 20 and up to 150: of more groups than MOST_ALL each sample asks MOST_ASKED by chance.
const int MOST_ALL = 1536;
const int MOST_ASKED = 256;

int asked_group_count()
{
    return u_emitter_group_count > MOST_ALL ? MOST_ASKED : u_emitter_group_count;
}

// The group to ask in turn g, and what its light counts; u in [0, 1) is uniform again.
EmitterGroup asked_group(int g, inout float u, out float weight)
{
    weight = 1.0;
    if (u_emitter_group_count <= MOST_ALL) {
        return emitter_group(g);
    }
    EmitterGroup group = draw_emitter_group(u);
    weight = 1.0 / max(group.probability * float(MOST_ASKED), 1e-30);
    return group;
}

int draw_emitter(EmitterGroup group, float u)
{
    int low = 0;
    int high = group.count - 1;
    while (low < high) {
        int middle = (low + high) >> 1;
        bool is_left = u < emitter_texel(group.first + middle, 3).w;
        high = is_left ? middle : high;
        low = is_left ? low : middle + 1;
    }
    return group.first + low;
}

// The four texels that every entry has.
struct Emitter {
    int kind;
    bool two_sided;
    bool can_be_hit;
    vec3 place;
    vec4 edge_u;     // w: probability within the group
    vec4 edge_v;     // w: area
    vec4 power;      // w: cumulative probability
};

Emitter emitter_at(int entry)
{
    vec4 head = emitter_texel(entry, 0);
    int code = int(head.w);
    return Emitter(code & 63, (code & EMITTER_TWO_SIDED) != 0, (code & EMITTER_BODY) != 0, head.xyz,
                   emitter_texel(entry, 1), emitter_texel(entry, 2), emitter_texel(entry, 3));
}

// Part of the light of a kind without an area that leaves towards -w.
float emitter_falloff(Emitter e, vec3 w)
{
    return light_falloff(Light(e.kind - EMITTER_LIGHT, SHADOW_NONE, false, e.place, e.power.rgb,
                               e.edge_u.xyz, vec3(0.0), e.edge_v.xy), w);
}

// As emitter_place, of a triangle.
vec3 triangle_place(vec3 corner, vec3 edge_u, vec3 edge_v, vec2 u)
{
    // Folding the far half over keeps the points as evenly spread as the square's.
    vec2 by_area = u.x + u.y > 1.0 ? 1.0 - u : u;
    SphericalTriangle t = spherical_triangle(corner, corner + edge_u, corner + edge_v);
    vec3 normal = cross(edge_u, edge_v);
    float height = dot(corner, normal);
    float square = dot(normal, normal);
    vec3 w = spherical_triangle_direction(t, u);
    float along = dot(w, normal);
    vec3 point = height / (abs(along) > 1e-30 ? along : 1e-30) * w - corner;
    vec2 place = vec2(dot(cross(point, edge_v), normal), dot(cross(edge_u, point), normal)) / max(square, 1e-30);
    place = clamp(place, 0.0, 1.0);
    place /= max(place.x + place.y, 1.0);
    float small = small_solid_angle(corner + (edge_u + edge_v) / 3.0, edge_u, edge_v);
    bool by_angle = t.solid_angle > small && abs(height) > COPLANAR * sqrt(square);
    return by_angle ? vec3(place, t.solid_angle) : vec3(by_area, 0.0);
}

// Where on the parallelogram or triangle: x, y along its edges, z = the factor between
// light and mean, 1 / density over solid angle; 0 asks for the density of area.
vec3 emitter_place(vec3 corner, vec3 edge_u, vec3 edge_v, bool is_triangle, vec2 u)
{
    if (is_triangle) {
        return triangle_place(corner, edge_u, edge_v, u);
    }
    float length_u = max(length(edge_u), 1e-15);
    float length_v = max(length(edge_v), 1e-15);
    vec3 x = edge_u / length_u;
    vec3 y = edge_v / length_v;
    vec3 seen = vec3(dot(corner, x), dot(corner, y), dot(corner, cross(x, y)));
    SphericalRectangle r = spherical_rectangle(seen, length_u, length_v);
    bool is_rectangle = abs(dot(x, y)) < 1e-4;
    vec3 point = spherical_rectangle_point(r, u);
    vec2 place = (point.xy - seen.xy) / vec2(length_u, length_v);
    float small = small_solid_angle(corner + 0.5 * (edge_u + edge_v), edge_u, edge_v);
    bool by_angle = is_rectangle && r.solid_angle > small && r.low.z < -COPLANAR;
    return by_angle ? vec3(clamp(place, 0.0, 1.0), r.solid_angle) : vec3(u, 0.0);
}

#if RAY_TEXTURES
// The texture's factor of a material's emission: nothing where there is a hole.
vec3 emitter_color(uint material, vec2 uv, vec2 hole_uv)
{
    vec4 place = material_texel(material, 3);
    vec3 color = place.z != 0.0 ? atlas_color(place, uv).rgb : vec3(1.0);
#if RAY_CUTOUTS
    place = material_texel(material, 2);
    float alpha = material_texel(material, 0).a * (place.z != 0.0 ? atlas_color(place, hole_uv).a : 1.0);
    color = alpha < material_texel(material, 4).x ? vec3(0.0) : color;
#endif
    return color;
}
#endif

LightSample sample_surface_emitter(Emitter e, int entry, vec2 u, vec3 p)
{
    vec3 corner = e.place - p;
    vec3 s = emitter_place(corner, e.edge_u.xyz, e.edge_v.xyz, e.kind == EMITTER_TRIANGLE, u);
    vec3 to_light = corner + s.x * e.edge_u.xyz + s.y * e.edge_v.xyz;
    float distance_2 = max(dot(to_light, to_light), 1e-30);
    float distance = sqrt(distance_2);
    vec3 w = to_light / distance;
    vec3 normal = cross(e.edge_u.xyz, e.edge_v.xyz);
    float cosine = -dot(normal, w) * inversesqrt(max(dot(normal, normal), 1e-30));
    cosine = e.two_sided ? abs(cosine) : max(cosine, 0.0);
    vec3 radiance = e.power.rgb;
#if RAY_TEXTURES
    vec4 uv_along = emitter_texel(entry, 4);
    vec4 uv_last = emitter_texel(entry, 5);
    vec2 uv = uv_along.xy + s.x * uv_along.zw + s.y * uv_last.xy;
    vec2 hole_uv = uv;
#if RAY_SECOND_UVS
    vec4 hole_along = emitter_texel(entry, 6);
    hole_uv = hole_along.xy + s.x * hole_along.zw + s.y * emitter_texel(entry, 7).xy;
#endif
    radiance *= uv_last.z >= 0.0 ? emitter_color(uint(uv_last.z), uv, hole_uv) : vec3(1.0);
#endif
    float density = distance_2 / max(e.edge_v.w * cosine, 1e-30);
    bool is_lit = cosine > 0.0 && distance_2 > 1e-20;
    radiance *= s.z > 0.0 ? s.z : 1.0 / density;
    return LightSample(w, distance, is_lit ? radiance : vec3(0.0), e.can_be_hit ? density : 0.0);
}

LightSample sample_map(vec2 choice, vec2 u)
{
#if ENVIRONMENT_KIND == 3
    ivec2 size = textureSize(t_ray_map_cells, 0);
    float scaled = choice.x * float(size.x * size.y);
    int cell = min(int(scaled), size.x * size.y - 1);
    vec4 entry = texelFetch(t_ray_map_cells, ivec2(cell % size.x, cell / size.x), 0);
    cell = choice.y < entry.x ? cell : int(entry.y);
    ivec2 place = ivec2(cell % size.x, cell / size.x);
    float density = texelFetch(t_ray_map_cells, place, 0).z;
    // Uniform over the cell's solid angle: the height is uniform between its edges.
    float high = cos(PI * float(place.y) / float(size.y));
    float low = cos(PI * float(place.y + 1) / float(size.y));
    float y = mix(high, low, u.y);
    float azimuth = TWO_PI * ((float(place.x) + u.x) / float(size.x) - 0.5);
    float r = sqrt(max(0.0, 1.0 - y * y));
    vec3 w = vec3(r * sin(azimuth), y, -r * cos(azimuth));
    return LightSample(w, RAY_FAR, environment_radiance(w) / max(density, 1e-30), density);
#else
    return NO_LIGHT;
#endif
}

// Density with which `sample_map` draws direction `w`.
float map_density(vec3 w)
{
#if ENVIRONMENT_KIND == 3
    ivec2 size = textureSize(t_ray_map_cells, 0);
    vec2 uv = vec2(atan(w.x, -w.z) * INV_TWO_PI + 0.5, atan(length(w.xz), w.y) * INV_PI);
    ivec2 place = clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1);
    return texelFetch(t_ray_map_cells, place, 0).z;
#else
    return 0.0;
#endif
}

// A point of an emitter that was drawn from its group by `choice`.
LightSample sample_entry(int entry, vec2 choice, vec2 u, vec3 p)
{
    Emitter e = emitter_at(entry);
    choice.x = rest_of_choice(choice.x, e.power.w, e.edge_u.w);
    LightSample light = sample_surface_emitter(e, entry, u, p);

    bool is_surface = e.kind == EMITTER_PARALLELOGRAM || e.kind == EMITTER_TRIANGLE;
    bool is_distant = light_form(e.kind - EMITTER_LIGHT) == FORM_PARALLEL;
    vec3 to_light = is_distant ? e.place : e.place - p;
    float spread = is_distant ? e.edge_v.x : 0.0;
    if (spread > 0.0) {
        to_light = frame_from_z(e.place) * vec3(disk_point(spread, u), 1.0);
    }
    float distance = max(length(to_light), 1e-15);
    vec3 w = to_light / distance;
    vec3 radiance = is_distant ? e.power.rgb : e.power.rgb / distance / distance;
    // Of a disk across the direction the cosine to it is that of w, but for its length.
    radiance *= spread > 0.0 ? distance : 1.0;
    radiance *= emitter_falloff(e, w);
    light.w = is_surface ? light.w : w;
    light.distance = is_surface ? light.distance : (is_distant ? RAY_FAR : distance);
    light.radiance = is_surface ? light.radiance : radiance;
    light.density = is_surface ? light.density : 0.0;
#if ENVIRONMENT_KIND == 3
    if (e.kind == EMITTER_MAP) {
        light = sample_map(choice, u);
    }
#endif
    light.radiance /= max(e.edge_u.w, 1e-30);
    light.density *= e.edge_u.w;
    return light;
}

// A point of the group's light as seen from `p`, the start of rays: a point on an edge of
// a lamp lies in the lamp's plane, from where it would be dark. Probabilities within the group are
// divided out of `radiance` and part of `density`, that of the group is not.
LightSample sample_group(EmitterGroup group, vec2 choice, vec2 u, vec3 p)
{
    return sample_entry(draw_emitter(group, choice.x), choice, u, p);
}

// Density over solid angle with which light is drawn where a ray of length t has met it.
float drawn_density(Surface met, float t)
{
    return u_emitter_density * met.mean_emission * (t * t / max(met.area_cosine, 1e-20));
}

// Bound on the light of one sample, so that a light within rounding of a surface stays
// finite and sums of many samples do, too. No picture comes near it.
const float SAMPLE_MAX = 1e30;

// A select, because min() may pass a NaN: infinity times a cosine of zero is one.
float bounded_light(float light)
{
    return light > 0.0 ? (light < SAMPLE_MAX ? light : SAMPLE_MAX) : 0.0;
}

// What a light sample brings before anything blocks it: its radiance times `response`.
// Light from below the geometric horizon counts only where the triangle stands for a smooth
// surface: there its own horizon would cut the shading off, facet by facet.
vec3 unblocked_light(RaySurface surface, LightSample light, vec3 response)
{
    bool is_above = surface.is_smooth || dot(light.w, surface.geometric) > 0.0;
    vec3 arriving = light.radiance * (is_above ? response : vec3(0.0));
    return vec3(bounded_light(arriving.r), bounded_light(arriving.g), bounded_light(arriving.b));
}

vec3 unblocked_irradiance(RaySurface surface, LightSample light)
{
    return unblocked_light(surface, light, vec3(max(dot(light.w, surface.normal), 0.0)));
}

bool is_dark(vec3 light)
{
    return !(light.r + light.g + light.b > 0.0);
}

// Length of the shadow ray of a sample that would bring `irradiance`: negative, so that
// it meets nothing and costs nothing, where there is nothing to find out.
float needed_reach(EmitterGroup group, LightSample light, vec3 irradiance, float longest)
{
    bool is_free = is_dark(irradiance) || group.shadow == EMITTER_UNSHADOWED;
    return is_free ? -1.0 : min(reach_toward_light(light.distance), longest);
}
