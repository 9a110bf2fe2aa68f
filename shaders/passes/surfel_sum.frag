#version 330 core
// Light of sources and sky: the sum of what shadow rays found and of the parts in which the sky was
// added up. SURFEL_RAYS_PER_SIDE: how many these are. OF_QUARTER: of a quarter of the hemisphere, as
// rays/surfel_lobes.glsl has it.

uniform sampler2D t_surfel_light;
uniform sampler2D t_surfel_sky;    // a tile for each part, from the bottom up
uniform int u_surfel_rows;
uniform int u_first_row;           // of the image from which on it is drawn

layout(location = 0) out vec4 o_sum;

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
    ivec2 surfel = ivec2(gl_FragCoord.xy) - ivec2(0, u_first_row);
    vec4 sum = texelFetch(t_surfel_light, surfel, 0);
    for (int row = 0; row < SURFEL_RAYS_PER_SIDE; ++row) {
        sum += texelFetch(t_surfel_sky, surfel + ivec2(0, row * u_surfel_rows), 0);
    }
    o_sum = OF_QUARTER == 1 ? mean_and_spread(sum) : sum;
}
