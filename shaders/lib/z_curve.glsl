// Points of a sequence for the rays of each pixel.

// Leaves room for another bit after each of the lower sixteen.
uint spread_bits(uint x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// Pixels take their points from one sequence in the order of their Z-curve, so that those of every
// block are spread evenly, which the filter averages (Ahmed, Wonka 2020). Without the order
// relMSE is .0033 for .0018 in an attic, .0129 for .0098 in a cellar (four rays, not guided).
uint first_point(ivec2 texel, int ray_count)
{
    return (spread_bits(uint(texel.x)) | spread_bits(uint(texel.y)) << 1) * uint(ray_count);
}
