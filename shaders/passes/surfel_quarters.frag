#version 330 core
// Light of sources and sky by directions, a tile of the image each: of the parts in which it was
// added up, passes/surfel_sum.frag has the tiles. Layout: rays/surfel_lobes.glsl.
// SURFEL_RAYS_PER_SIDE, PART_COUNT: how many of each.

uniform sampler2D t_sky_0;  // irradiance, then the quarters
uniform sampler2D t_sky_1;
uniform sampler2D t_sky_2;
uniform sampler2D t_sky_3;
uniform sampler2D t_sky_4;
uniform sampler2D t_part_0;
uniform sampler2D t_part_1;
uniform sampler2D t_part_2;
uniform sampler2D t_part_3;
uniform sampler2D t_part_4;
uniform int u_surfel_rows;

layout(location = 0) out vec4 o_sum;

vec4 sum_of(sampler2D image, int count, ivec2 surfel)
{
    vec4 sum = vec4(0.0);
    for (int i = 0; i < count; ++i) {
        sum += texelFetch(image, surfel + ivec2(0, i * u_surfel_rows), 0);
    }
    return sum;
}

vec4 sum_of_both(sampler2D sky, sampler2D parts, ivec2 surfel)
{
    return sum_of(sky, SURFEL_RAYS_PER_SIDE, surfel) + sum_of(parts, PART_COUNT, surfel);
}

// The mean direction, times the sum of colours; and how far directions spread: 1 over the sharpness
// of a lobe of von Mises and Fisher's (Banerjee 2005).
vec4 mean_and_spread(vec4 quarter)
{
    float size = min(length(quarter.xyz) / max(quarter.w, 1e-30), 1.0);
    float spread = (1.0 - size * size) / max(size * (3.0 - size * size), 1e-30);
    return vec4(quarter.xyz / max(size, 1e-30), spread);
}

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    int tile = surfel.y / u_surfel_rows;
    surfel.y -= tile * u_surfel_rows;
    if (tile == 0) {
        o_sum = sum_of_both(t_sky_0, t_part_0, surfel);
        return;
    }
    o_sum = mean_and_spread(tile == 1 ? sum_of_both(t_sky_1, t_part_1, surfel)
                          : tile == 2 ? sum_of_both(t_sky_2, t_part_2, surfel)
                          : tile == 3 ? sum_of_both(t_sky_3, t_part_3, surfel)
                          : sum_of_both(t_sky_4, t_part_4, surfel));
}
