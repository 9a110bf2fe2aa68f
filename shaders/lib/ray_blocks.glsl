// How many rays the pixels of a block trace: as many as any of them wants. Lanes that run
// together, 8 in software and 32 and more on GPUs, take about as long as the last of them.

uniform isampler2D t_numbers;  // of rays; negative: a neighbour in front may shade the pixel

const ivec2 RAY_BLOCK = ivec2(4, 2);

int number_of_rays(ivec2 texel)
{
    ivec2 first = texel / RAY_BLOCK * RAY_BLOCK;
    ivec2 last = textureSize(t_numbers, 0) - 1;
    int most = 0;
    for (int i = 0; i < RAY_BLOCK.x * RAY_BLOCK.y; ++i) {
        ivec2 other = min(first + ivec2(i % RAY_BLOCK.x, i / RAY_BLOCK.x), last);
        most = max(most, abs(texelFetch(t_numbers, other, 0).x));
    }
    return most;
}
