// Light that the scene's surfaces receive, kept in surfels: small pieces of them.
//
// Which surfel a point of a triangle belongs to: ssdo_gl/raytracing/surfels.py, torn_surfels.py,
// graded_surfels.py.
// Of the resources, `surfel_places` and `surfel_splits` hold the tables and `surface_cache` what
// each surfel receives, direct light and all bounces; `surfel_direct` is the direct part alone.
// SURFEL_DEPTH: how often a texel is cut at most, graded_surfels.py; a loop over as many as there are
// takes 1.08 of the time of a moving camera's frames (stairs, courtyard), as many ifs 1.00 to 1.02.
#include "lib/surface.glsl"

uniform usampler2D t_surfel_places;
uniform sampler2D t_surfel_splits;
uniform sampler2D t_surface_cache;  // rgb: irradiance, W m^-2; a: see passes/surface_cache.frag

// Surfels in a row of their textures, as a power of two, and slots in one of the table.
const int SURFEL_ROW_SHIFT = 8;
const int SURFEL_PLACE_SHIFT = 10;
const uint SURFEL_FIRST_FLAG = 0x1000000u;
const uint SURFEL_SECOND_FLAG = 0x2000000u;
const int SURFEL_TURN_SHIFT = 26;
const uint SURFEL_FRONT_BLIND = 0x10000000u;
const uint SURFEL_BACK_BLIND = 0x20000000u;
const int SURFEL_BLIND_COARSENESS = 4;

ivec2 surfel_texel(int surfel)
{
    return ivec2(surfel & ((1 << SURFEL_ROW_SHIFT) - 1), surfel >> SURFEL_ROW_SHIFT);
}

// Which surfel a ray along `w` meets at the point `p` of the triangle that it hit, or one `aside` of
// it, in texels, on the same face.
int surfel_beside_hit(BvhHit hit, vec3 p, vec3 w, vec2 aside)
{
    vec3 a, b, c;
    bvh_triangle(hit, a, b, c);
    vec3 front = triangle_normal(a, b, c);
    vec3 weights = weights_of_corners(p, a, b, c, front);
    int slot = int(bvh_texel(hit.record, 3).x) * 2 + (hit.is_second ? 1 : 0);
    int mask = (1 << SURFEL_PLACE_SHIFT) - 1;
    uvec2 place = texelFetch(t_surfel_places, ivec2(slot & mask, slot >> SURFEL_PLACE_SHIFT), 0).xy;
    // From the triangle's corners to the grid's.
    uint turn = place.y >> SURFEL_TURN_SHIFT & 3u;
    weights = turn == 0u ? weights : turn == 1u ? weights.yzx : weights.zxy;
    // A pair fills the unit square; a single triangle has its corner a at 0 of one axis,
    // and the other runs from b to c.
    float outward = weights.y + weights.z;
    vec2 t = vec2(outward, weights.z / max(outward, 1e-30));
    t = (place.y & SURFEL_FIRST_FLAG) != 0u ? vec2(outward, weights.z) : t;
    t = (place.y & SURFEL_SECOND_FLAG) != 0u ? vec2(weights.y, outward) : t;
    ivec2 grid = ivec2(place.y & 0xfffu, place.y >> 12 & 0xfffu);
    ivec2 coarse = (grid + SURFEL_BLIND_COARSENESS - 1) / SURFEL_BLIND_COARSENESS;
    ivec2 own = (place.y & SURFEL_FRONT_BLIND) != 0u ? coarse : grid;
    int behind = 0;
    if (dot(front, w) > 0.0) {
        behind = own.x * own.y;
        own = (place.y & SURFEL_BACK_BLIND) != 0u ? coarse : grid;
    }
    t *= vec2(own);
    ivec2 cell = clamp(ivec2(floor(t + aside)), ivec2(0), own - 1);
    int surfel = int(place.x) + cell.y * own.x + cell.x + behind;
    int rows = textureSize(t_surfel_splits, 0).y / 2;
    vec4 plane = texelFetch(t_surfel_splits, surfel_texel(surfel), 0);
#if SURFEL_DEPTH
    // Without a normal it says which grid the surfel is cut into, whose texels may be cut again.
    t -= vec2(cell);
    for (int depth = 0; depth < SURFEL_DEPTH; ++depth) {
        if (plane.xyz == vec3(0.0) && plane.w > 0.0) {
            int parts = int(plane.w);
            ivec2 grid = ivec2(parts & 0xf, parts >> 4 & 0xf);
            t *= vec2(grid);
            cell = clamp(ivec2(t), ivec2(0), grid - 1);
            t -= vec2(cell);
            surfel = (parts >> 8) + cell.y * grid.x + cell.x;
            plane = texelFetch(t_surfel_splits, surfel_texel(surfel), 0);
        }
    }
#endif
    // Behind a wall that stands on the surfel is its second part, behind another one its third.
    for (int wall = 0; wall < 2; ++wall) {
        if (!(dot(plane.xyz, p) < plane.w)) {
            break;
        }
        surfel = int(texelFetch(t_surfel_splits, surfel_texel(surfel) + ivec2(0, rows), 0).x);
        plane = texelFetch(t_surfel_splits, surfel_texel(surfel), 0);
    }
    return surfel;
}

int surfel_at_hit(BvhHit hit, vec3 p, vec3 w)
{
    return surfel_beside_hit(hit, p, w, vec2(0.0));
}

#include "rays/surfel_lobes.glsl"

// Where a ray along `w` has met `surface`.
ivec2 surfel_met(BvhHit hit, Surface surface, vec3 w)
{
    return surfel_texel(surfel_at_hit(hit, surface.at.position, w));
}

// Irradiance of a surfel.
vec4 cached_light(ivec2 surfel)
{
    vec4 light = texelFetch(t_surface_cache, surfel, 0);
#if LOBES
    // Between mirrors that keep all light, what they send less may be more than there is.
    light.rgb = max(light.rgb, 0.0);
#endif
    return light;
}

// Radiance that `surface` reflects of its surfel's light along the ray that has met it: of metal and
// smooth layers in lobes, all else as if it was diffuse.
vec3 reflection_of(vec4 light, ivec2 surfel, Surface surface)
{
    Brdf brdf = surface.brdf;
    vec3 share = reflectance_of_facet(surface);
#if LOBES
    vec2 layer = layer_of(brdf);
    share += is_all_layer(layer) ? vec3(0.0) : facet_slope(surface) * light.a;
    return sent_by_directions(surfel, light, surface.at.normal, surface.at.w_out, brdf.roughness,
                              max(share, 0.0), layer);
#else
#if GLOSSY
    share = max(share + facet_slope(surface) * light.a, 0.0);
#endif
    return share * INV_PI * light.rgb;
#endif
}

// Radiance that `surface` reflects back along the ray; what it emits is `surface.emission`.
vec3 cached_reflection(BvhHit hit, Surface surface, vec3 w)
{
    ivec2 surfel = surfel_met(hit, surface, w);
    return reflection_of(cached_light(surfel), surfel, surface);
}
