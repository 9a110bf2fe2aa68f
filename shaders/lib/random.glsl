// Sample points for Monte Carlo: the Sobol (0, 2)-sequence with Owen scrambling.
//
// Any 2^k consecutive points put one into every box of area 2^-k, so errors fall faster
// than with independent points; scrambling makes each single point uniform, so that means
// are unbiased, and pixels independent. Owen scrambling by hashing: Laine, Karras 2011;
// constants: Vegdahl 2021; padding dimensions with shuffled indices: Burley, "Practical
// Hash-based Owen Scrambling" (2020).

uniform uint u_stream;           // scrambling of this accumulation: from seed and half
uniform uint u_first_sample;     // of this draw
uniform int u_sample_count;      // of this draw
uniform uint u_shared_bits;      // mask: leading bits that all pixels scramble alike

// Degski's and Wellons' search, `lowbias32`.
uint random_hash(uint x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

// GLSL 3.30 has no bitfieldReverse.
uint reverse_bits(uint x)
{
    x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
    return x << 16 | x >> 16;
}

// Owen scrambling of a fraction whose bits are reversed: a bit flips depending on the
// ones below it, which here are the more significant ones.
uint owen_reversed(uint x, uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1u;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

// Second coordinate of Sobol point `i`, bits reversed: Pascal's triangle modulo 2.
uint sobol_second_reversed(uint i)
{
    i ^= (i & 0xaaaaaaaau) >> 1;
    i ^= (i & 0xccccccccu) >> 2;
    i ^= (i & 0xf0f0f0f0u) >> 4;
    i ^= (i & 0xff00ff00u) >> 8;
    return i ^ (i & 0xffff0000u) >> 16;
}

float unit_float(uint bits)
{
    // 24 bits are what a float can hold below 1; rounding 32 of them could give 1.
    return float(bits >> 8) * (1.0 / 16777216.0);
}

uint pixel_seed(ivec2 pixel)
{
    return random_hash(uint(pixel.x) + (uint(pixel.y) << 16) + u_stream * 0x9e3779b9u);
}

// Scrambles by a seed that all pixels share, and below the leading bits in `shared_bits`
// by the pixel's own. Neighbouring pixels then send sample i into the same cell of the
// hemisphere, each to its own place in it, and rays that run in lockstep visit the same
// boxes. After 4^bits samples every pixel has been in every cell, and pixels err
// independently.
float scramble_partly(uint reversed, uint shared_seed, uint own_seed, uint shared_bits)
{
    uint together = owen_reversed(reversed, shared_seed);
    uint apart = owen_reversed(together, own_seed);
    return unit_float(reverse_bits(together & shared_bits | apart & ~shared_bits));
}

// The point of a pair of dimensions that the sequence has in this place.
vec2 scrambled_2d(uint place, uint own, uint dimension, uint shared_bits)
{
    uint shared_seed = random_hash(u_stream + dimension * 0x9e3779b9u);
    return vec2(scramble_partly(place, random_hash(shared_seed ^ 0x68bc21ebu),
                                random_hash(own ^ 0x68bc21ebu), shared_bits),
                scramble_partly(sobol_second_reversed(place), random_hash(shared_seed ^ 0x02e5be93u),
                                random_hash(own ^ 0x02e5be93u), shared_bits));
}

// Shuffling keeps any 2^k consecutive points together, in another order.
uint shuffled(uint index, uint own)
{
    return reverse_bits(owen_reversed(reverse_bits(index), own));
}

// Point `index` of a pair of dimensions. `is_together`: one in which neighbouring pixels
// stay together; such pairs are not independent of each other, only of all others.
vec2 random_2d(uint index, uint seed, uint dimension, bool is_together)
{
    uint own = random_hash(seed + dimension * 0x9e3779b9u);
    uint place = is_together ? index : shuffled(index, own);
    return scrambled_2d(place, own, dimension, is_together ? u_shared_bits : 0u);
}

// Of the points of `random_2d` from `first` on, a multiple of their number, one after the other: in every
// `count` of them point i of all pixels, whose seed is one, lies in the same strip along the second axis.
// So the rays of lanes that run together visit the same boxes, and are no more alike than others.
vec2 random_2d_in_step(uint first, uint i, uint count, uint seed, uint dimension)
{
    uint own = random_hash(seed + dimension * 0x9e3779b9u);
    // What is not a power of two consists of such blocks.
    uint in_block = (count & (0u - count)) - 1u;
    uint block = shuffled(first + i, own) & ~in_block;
    return scrambled_2d(block | i & in_block, own, dimension, 0u).yx;
}
