// A slice of the hemisphere as 32 directions, one bit for each that is blocked.
//
// The directions stand evenly in the share of the slice's cosine-weighted hemisphere that
// lies before them, so that each stands for 1 / 32 of the slice. `jitter` moves all 32
// together: whatever the width of a blocker, it hides its share on average.
//
// GLSL 3.30 has no bitCount(), and a shift by 32 is undefined.
#include "screen_space/slices.glsl"

const float SECTOR_COUNT = 32.0;

struct Sectors {
    Slice slice;
    vec2 gamma;    // cosine and sine of the slice's normal_angle
    float jitter;  // in [0, 1)
    float first;   // integral of the hemisphere's weight from its lower end to v
    float total;   // from end to end
};

int bit_count(uint x)
{
    x -= (x >> 1) & 0x55555555u;
    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0fu;
    return int((x * 0x01010101u) >> 24);
}

uint lowest_bits(int count)
{
    return count >= 32 ? 0xffffffffu : (1u << uint(count)) - 1u;
}

Sectors sectors_of(Slice slice, float jitter)
{
    float angle = slice.normal_angle;
    vec2 gamma = vec2(cos(angle), sin(angle));
    // The hemisphere reaches from gamma - pi / 2 to gamma + pi / 2.
    float first = 0.5 * (gamma.x + (angle - HALF_PI) * gamma.y);
    return Sectors(slice, gamma, jitter, first, gamma.x + angle * gamma.y);
}

// What one of a slice's directions stands for, relative to those of other slices.
float sector_weight(Sectors s)
{
    return s.slice.normal_length * s.total;
}

// Which directions have less than `share` of the slice before them, as a count of bits.
int sectors_before(Sectors s, float share)
{
    return int(SECTOR_COUNT * clamp(share, 0.0, 1.0) + s.jitter);
}

// Share of the slice that lies before the direction of (x, y), x along the slice, y along v.
float share_before(Sectors s, vec2 xy)
{
    float side = xy.x < 0.0 ? -1.0 : 1.0;
    vec2 gamma = vec2(s.gamma.x, side * s.gamma.y);
    float angle = angle_of(abs(xy.x), xy.y);
    // arc_integral() without another cosine.
    vec2 double_angle = vec2(xy.y * xy.y - xy.x * xy.x, 2.0 * abs(xy.x) * xy.y)
        / max(dot(xy, xy), 1e-37);
    float integral = 0.25 * (gamma.x - dot(double_angle, gamma) + 2.0 * angle * gamma.y);
    bool is_beyond = angle >= side * s.slice.normal_angle + HALF_PI;
    return is_beyond ? max(side, 0.0) : (s.first + side * integral) / s.total;
}

// The directions between two of them, in either order.
uint sectors_between(Sectors s, vec2 from_xy, vec2 to_xy)
{
    int a = sectors_before(s, share_before(s, from_xy));
    int b = sectors_before(s, share_before(s, to_xy));
    return lowest_bits(max(a, b)) & ~lowest_bits(min(a, b));
}
