#version 330 core
// Direct light of surfels: the parts in which the sky was added up and shadow rays traced.
// SURFEL_RAYS_PER_SIDE, PART_COUNT: how many of each.

uniform sampler2D t_surfel_sky;    // a tile for each part, from the bottom up
uniform sampler2D t_surfel_parts;
uniform int u_surfel_rows;

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    for (int row = 0; row < SURFEL_RAYS_PER_SIDE; ++row) {
        sum += texelFetch(t_surfel_sky, surfel + ivec2(0, row * u_surfel_rows), 0);
    }
    for (int part = 0; part < PART_COUNT; ++part) {
        sum += texelFetch(t_surfel_parts, surfel + ivec2(0, part * u_surfel_rows), 0);
    }
    o_irradiance = sum;
}
