// What a march found in each direction, kept for the pass that would march the same way
// again: the texel that blocks it as a number, -1 where the direction is open.
//
// KEPT_TEXTURE_COUNT: textures of four directions each, 0 if nothing is kept.
// TAKES_DIRECTIONS: 1 in the pass that reads them, 0 in the one that writes them.
#if KEPT_TEXTURE_COUNT > 0

// x and y, 14 bits each, as the bits of a float: from 2^-63 to 2^-31, so that no device
// takes it for NaN or flushes it to zero.
const uint KEPT_BASE = 0x20000000u;
const int KEPT_ROW_SHIFT = 14;

// Only ever indexed by constants, or compilers unroll the loop over directions around it;
// Mesa's software rasterizer then follows every direction of the sky's pixels, too, where
// a loop ends at once: 163 ms instead of 17 for a small thing before the sky.
float kept_direction[4 * KEPT_TEXTURE_COUNT];

// Moves all directions one place ahead: next to nothing for compilers, where telling the
// place of direction `i` took a select for each.
void shift_directions()
{
    for (int k = 0; k < 4 * KEPT_TEXTURE_COUNT - 1; ++k)
        kept_direction[k] = kept_direction[k + 1];
}

#if TAKES_DIRECTIONS
uniform sampler2D t_kept_0;
#if KEPT_TEXTURE_COUNT > 1
uniform sampler2D t_kept_1;
#endif
#if KEPT_TEXTURE_COUNT > 2
uniform sampler2D t_kept_2;
#endif
#if KEPT_TEXTURE_COUNT > 3
uniform sampler2D t_kept_3;
#endif

void take_four(int first, vec4 four)
{
    kept_direction[first] = four.x;
    kept_direction[first + 1] = four.y;
    kept_direction[first + 2] = four.z;
    kept_direction[first + 3] = four.w;
}

void take_directions(ivec2 pixel)
{
    take_four(0, texelFetch(t_kept_0, pixel, 0));
#if KEPT_TEXTURE_COUNT > 1
    take_four(4, texelFetch(t_kept_1, pixel, 0));
#endif
#if KEPT_TEXTURE_COUNT > 2
    take_four(8, texelFetch(t_kept_2, pixel, 0));
#endif
#if KEPT_TEXTURE_COUNT > 3
    take_four(12, texelFetch(t_kept_3, pixel, 0));
#endif
    for (int k = DIRECTION_COUNT; k < 4 * KEPT_TEXTURE_COUNT; ++k)
        shift_directions();
}

// What blocks the next direction; how far along it is not kept.
Blocker next_kept_blocker()
{
    float number = kept_direction[0];
    shift_directions();
    int bits = int(floatBitsToUint(number) - KEPT_BASE);
    if (number < 0.0)
        return NO_BLOCKER;
    return Blocker(ivec2(bits & ((1 << KEPT_ROW_SHIFT) - 1), bits >> KEPT_ROW_SHIFT), 0.0);
}
#else
layout(location = 1) out vec4 o_kept_0;
#if KEPT_TEXTURE_COUNT > 1
layout(location = 2) out vec4 o_kept_1;
#endif
#if KEPT_TEXTURE_COUNT > 2
layout(location = 3) out vec4 o_kept_2;
#endif
#if KEPT_TEXTURE_COUNT > 3
layout(location = 4) out vec4 o_kept_3;
#endif

void keep_nothing()
{
    for (int i = 0; i < 4 * KEPT_TEXTURE_COUNT; ++i)
        kept_direction[i] = -1.0;
}

// One direction after the other, all of them: they come to stand at the end.
void keep_direction(Blocker b)
{
    shift_directions();
    uint bits = KEPT_BASE + uint(b.texel.x | b.texel.y << KEPT_ROW_SHIFT);
    kept_direction[4 * KEPT_TEXTURE_COUNT - 1] = is_blocked(b) ? uintBitsToFloat(bits) : -1.0;
}

vec4 four_kept(int first)
{
    return vec4(kept_direction[first], kept_direction[first + 1],
                kept_direction[first + 2], kept_direction[first + 3]);
}

void write_kept_directions()
{
    o_kept_0 = four_kept(0);
#if KEPT_TEXTURE_COUNT > 1
    o_kept_1 = four_kept(4);
#endif
#if KEPT_TEXTURE_COUNT > 2
    o_kept_2 = four_kept(8);
#endif
#if KEPT_TEXTURE_COUNT > 3
    o_kept_3 = four_kept(12);
#endif
}
#endif
#endif
