#version 330 core
// Irradiance of surfels straight from the scene's lights, glowing meshes and environment map,
// by shadow rays from all their points. Emission that rays meet by chance is thus counted
// nowhere else, but for a map's: see passes/surfel_sky.frag. Defines as in rays/surface_data.glsl and
// lib/environment.glsl.
#include "rays/surfel_points.glsl"
#include "rays/glow_that_is_met.glsl"
#include "rays/quarter_sums.glsl"

#if GLOW_IS_DIRECT
uniform int u_tree_samples;
#endif

uniform int u_samples;          // of each group, or in all where they are drawn
uniform bool u_draws_groups;    // too many to go through

layout(location = 0) out vec4 o_irradiance;

const uint DIMENSION_GROUP = 1u;
const uint DIMENSION_LIGHT = 2u;  // two for each group
const uint DIMENSION_TREE = 0x10000u;
// Of a surfel, how far away a body may be that rays spread by the cosine look for.
const float NEAR_SIZES = 4.0;
const int MOST_PANELS = 16;  // of a body that are looked at

// Of the points, which lie in 4 x 4 cells, number i in an order in which any few in turn are spread
// over the surfel: a (0, 2)-sequence (Sobol 1967), mirrored by the bits of `flip`.
int spread_point(int i, uint flip)
{
    uint bits = uint(i);
    uint x = (bits & 1u) << 1 | (bits >> 1 & 1u);
    uint odd = bits >> 1 ^ bits >> 3;
    uint y = ((bits ^ bits >> 2 ^ odd) & 1u) << 1 | (odd & 1u);
    return int((y << 2 | x) ^ flip);
}

// Whether surfels may send so many samples into the same cells: these lie in all columns and rows.
// Of others all surfels would leave out the same parts of a lamp.
bool may_share_cells(int samples)
{
    return samples % (int(u_shared_bits) + 1) == 0;
}

float surfel_size(ivec2 surfel)
{
    vec3 one = surfel_point(surfel, 15).position - surfel_point(surfel, 0).position;
    vec3 other = surfel_point(surfel, 12).position - surfel_point(surfel, 3).position;
    return sqrt(max(dot(one, one), dot(other, other)));
}

// About how much light of a panel arrives; 0 only where none can.
float panel_weight(Emitter e, RaySurface at)
{
    vec3 corner = e.place - at.start;
    vec3 u = e.edge_u.xyz;
    vec3 v = e.edge_v.xyz;
    vec3 normal = cross(u, v);
    float height = -dot(corner, normal) * inversesqrt(max(dot(normal, normal), 1e-30));
    height = e.two_sided ? abs(height) : height;
    float top = dot(corner, at.normal) + max(dot(u, at.normal), 0.0) + max(dot(v, at.normal), 0.0);
    vec3 d = corner + clamp(-dot(corner, u) / max(dot(u, u), 1e-30), 0.0, 1.0) * u;
    d += clamp(-dot(d, v) / max(dot(v, v), 1e-30), 0.0, 1.0) * v;
    float near_2 = max(dot(d, d), 1e-30);
    float area = e.edge_v.w;
    float sent = dot(e.power.rgb, vec3(1.0)) * area * height * inversesqrt(near_2);
    return height > 0.0 && top > 0.0 ? sent / (near_2 + area) : 0.0;
}

// A point of a group. Of a body of few panels, as a box, it is on one that can light the surfel, if there
// is any: next to its narrow side the others, which send more, do not.
LightSample sample_of_group(EmitterGroup group, RaySurface at, vec2 choice, vec2 u)
{
    bool has_few = group.count > 1 && group.count <= MOST_PANELS;
    int drawn = -1;
    float weight = 0.0;
    float total = 0.0;
    float chance = choice.x;
    for (int i = 0; i < (has_few ? group.count : 0); ++i) {
        float more = panel_weight(emitter_at(group.first + i), at);
        total += more;
        float part = more / max(total, 1e-30);
        bool takes = chance < part;
        drawn = takes ? group.first + i : drawn;
        weight = takes ? more : weight;
        // What is left of the number is one again.
        chance = takes ? chance / max(part, 1e-30) : (chance - part) / max(1.0 - part, 1e-7);
        chance = clamp(chance, 0.0, 1.0 - FLOAT_EPSILON);
    }
    bool is_drawn = drawn >= 0;
    drawn = is_drawn ? drawn : draw_emitter(group, choice.x);
    LightSample light = sample_entry(drawn, choice, u, at.start);
    // Its chance by power is divided out.
    float by_power = emitter_texel(drawn, 1).w * total / max(weight, 1e-30);
    light.radiance *= is_drawn ? by_power : has_few ? 0.0 : 1.0;
    light.density /= is_drawn ? by_power : 1.0;
    return light;
}

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    uint seed = pixel_seed(surfel);
    int group_count = u_draws_groups ? 1 : u_emitter_group_count;
    vec4 sum = vec4(0.0);
#if LOBES
    QuarterSums quarters = EMPTY_QUARTERS;
#endif
    for (int g = 0; g < group_count; ++g) {
        EmitterGroup group = emitter_group(g);
        group.probability = 1.0;
        int samples = max(u_samples, 1);
        uint dimension = DIMENSION_LIGHT + 2u * uint(g);
        vec4 of_group = vec4(0.0);
        for (int i = 0; i < samples; ++i) {
            // Groups of few samples start from different points.
            int point = (i + g * samples) % SURFEL_POINTS;
            RaySurface at = surfel_point(surfel, spread_point(point, seed & 15u));
            vec2 choice = random_2d(uint(i), seed, dimension, false);
            vec2 u = random_2d(uint(i), seed, dimension + 1u, may_share_cells(samples));
            if (u_draws_groups) {
                float chance = random_2d(uint(i), seed, DIMENSION_GROUP, false).x;
                group = draw_emitter_group(chance);
            }
            LightSample light = sample_of_group(group, at, choice, u);
            vec3 arriving = unblocked_irradiance(at, light) / max(group.probability, 1e-30);
#if GLOW_IS_DIRECT
            arriving = is_in_tree(group) ? vec3(0.0) : arriving;
#endif
            float reach = needed_reach(group, light, arriving, RAY_FAR);
            float sides = SIDES_TO_LIGHT;
#if ENVIRONMENT_KIND == 3
            bool is_sky = emitter_at(group.first).kind == EMITTER_MAP;
            sides = is_sky ? SIDES_TO_SKY : SIDES_TO_LIGHT;
            arriving *= is_sky ? 1.0 - share_of_own_rays(at, light.w, light.density) : 1.0;
#endif
            bool is_blocked = bvh_meets_any(bvh_ray_to_light(at.start, light.w, sides), reach);
            arriving = is_blocked ? vec3(0.0) : arriving;
            of_group += light_of_surfel(at, light.w, arriving);
#if LOBES
            add_to_quarter(quarters, at.normal, light.w, arriving / float(samples));
#endif
        }
        sum += of_group / float(samples);
    }
#if GLOW_IS_DIRECT
    float near_reach = NEAR_SIZES * surfel_size(surfel);
    for (int j = 0; j < u_tree_samples; ++j) {
        RaySurface at = surfel_point(surfel, j % SURFEL_POINTS);
        LightSample light = sample_tree(at.start, at.normal,
                                        random_2d(uint(j), seed, DIMENSION_TREE, false),
                                        random_2d(uint(j), seed, DIMENSION_TREE + 1u, may_share_cells(u_tree_samples)));
        float share = share_of_drawn(at, light, near_reach);
        vec3 all = unblocked_irradiance(at, light) / float(u_tree_samples);
        float reach = is_dark(all) ? -1.0 : reach_toward_light(light.distance);
        vec3 arriving = arriving_light(at, light.w, reach, share * all, all);
        sum += light_of_surfel(at, light.w, arriving);
        vec2 u = random_2d(uint(j), seed, DIMENSION_TREE + 2u, may_share_cells(u_tree_samples));
        vec3 w = frame_from_z(at.normal) * cosine_hemisphere(u);
        float distance;
        vec3 met = glow_nearby(at, w, near_reach, ANY_AREA, distance) / float(u_tree_samples);
        sum += light_of_surfel(at, w, met);
#if LOBES
        add_to_quarter(quarters, at.normal, light.w, arriving);
        add_to_quarter(quarters, at.normal, w, met);
#endif
    }
#endif
    o_irradiance = sum;
#if LOBES
    write_quarters(quarters, 1.0);
#endif
}
