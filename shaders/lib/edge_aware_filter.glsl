// One stage of the edge-aware filter: removes the estimators' noise without mixing across edges,
// and brings images of half size to full size.
//
// Defines: STAGE 0 separable, 1 upsample, 2 box, 3 copy, 4 apart; SIGNAL_COUNT 1 or 2 images of one
// size, filtered side by side: what weighs a tap is looked up once;
// IS_VISIBILITY 1: one value in [0, 1], and 1 where nothing is, 0: rgb irradiance + a;
// Z_SIGNALS: bit i says that the channel after the value of signal i is z, else it is
// visibility;
// IS_FIRST: the values are an estimator's, and may be unsound;
// PARTS_EDGES: pixels that a neighbour in front may shade, which trace many rays,
// count next to nothing for others; the sign of z
// among the values says which have them (1), or an image does (2); 0: none has;
// IS_OF_GLOSS: the values are what gloss reflects;
// TAP_RADIUS: taps on each side; USE_NORMALS; IS_VERTICAL: the axis of a separable stage;
// STRIDE: texels of the frame per pixel of the values; STEP: pixels of the values from one tap to
// the next of a stage apart;
// KNOWS_NOISE 1: separable; it is known how noisy the light of pixels is: those whose light differs
// by more than that are on another level of light and count less, whatever the surface.
//
// The estimators give neighbouring pixels different sample sets that repeat every 4 x 4
// pixels, so the filter must weight all sets alike where nothing separates them. A box
// of 4 taps convolved with any other kernel does: the separable kernel is a box of 4
// convolved with a box of 2 TAP_RADIUS - 2, which is symmetric about the pixel.
#include "lib/finite.glsl"
#include "lib/gbuffer.glsl"
#include "lib/gloss_image.glsl"

#define STAGE_SEPARABLE 0
#define STAGE_UPSAMPLE 1
#define STAGE_BOX 2
#define STAGE_COPY 3
#define STAGE_APART 4
// Of light whose noise is more than its change beside joints, as that of gloss, it makes more.
#define FITS_LINE (STAGE == STAGE_SEPARABLE && !IS_OF_GLOSS)

uniform sampler2D t_value_0;
#if SIGNAL_COUNT > 1
uniform sampler2D t_value_1;
#endif
#if PARTS_EDGES == 2
uniform sampler2D t_gathered_near;  // a negative: the pixel traces many rays
#endif
uniform sampler2D t_light;     // r: a pixel's light, g: the variance of that
uniform float u_noise_tolerance;  // squared differences of light, in the variance of both
uniform float u_depth_tolerance;  // distance from the plane at which a tap counts 1/4, pixels
uniform float u_value_bound;   // larger values are faults, not light

bool holds_z(int signal)
{
    return (Z_SIGNALS >> signal & 1) == 1;
}

// What is written where nothing is known.
vec4 neutral(int result)
{
#if IS_VISIBILITY
    return vec4(1.0, 0.0, 0.0, 0.0);
#else
    return vec4(0.0, 0.0, 0.0, holds_z(result) ? 0.0 : 1.0);
#endif
}

vec4 value_at(int signal, ivec2 pixel)
{
#if SIGNAL_COUNT > 1
    return signal == 1 ? texelFetch(t_value_1, pixel, 0) : texelFetch(t_value_0, pixel, 0);
#else
    return texelFetch(t_value_0, pixel, 0);
#endif
}

// Distance of octahedral codes, 2 across the square, at which normals have nothing in
// common. cos^8 of the decoded angle gives the same errors to 1 %.
const float NORMAL_REACH = 0.8;
// The same of gloss, in widths of the lobe, of mirrors at least that of GGX with this alpha.
const float LOBE_REACH = 1.5;
const float LEAST_ALPHA = 1e-3;

// How much deeper or less deep than the centre, in footprints of a pixel, a tap counts a quarter, where
// pixels have rays: along a surface seen at a grazing angle the next one is far away, in other light.
const float DEEP = 8.0;

// Of the four pixels around a texel, which each weigh a quarter or more on one surface:
// those that weigh less together show another one.
const float LEAST_WEIGHT = 0.02;

// What a tap counts that traces many rays where the centre does not, or the other way round.
const float OTHER_WEIGHT = 1e-3;
// A variance that tells nothing, and what is larger; light whose noise nobody asks for; and what
// keeps 0 / 0 away. Squares of the former, and of the latter, are numbers.
const float NO_VARIANCE = 1e15;
const float MOST_LIGHT = 1e9;
const float LEAST_VARIANCE = 1e-15;

// A plane through the centre pixel's surface point, and what weights are relative to.
struct Centre {
    ivec2 texel;
    bool is_edge;       // it traces many rays
    vec2 shading_code;  // octahedral
    float per_turn_2;   // 1 / the square of the reach of normals
    // A tap of depth z, d texels away, stands off the plane by z * dot(rate, (d, 1)) - offset
    // tolerances of the centre.
    vec3 rate;
    float offset;
    float per_footprint;  // of a pixel of the frame
    float per_depth;      // in which the centre's own depth is `depth`
    float depth;
    vec2 light;           // and its variance
};

vec2 light_at(ivec2 pixel)
{
#if KNOWS_NOISE
    vec2 light = texelFetch(t_light, pixel, 0).rg;
    // Of the bits, as below.
    uvec2 bits = floatBitsToUint(vec2(abs(light.r), light.g));
    bool is_known = bits.r < floatBitsToUint(MOST_LIGHT) && bits.g < floatBitsToUint(NO_VARIANCE);
    return is_known ? light : vec2(0.0, NO_VARIANCE);
#else
    return vec2(0.0);
#endif
}

// How much two pixels can be on one level of light: 1 as far as their noise tells (after Sakai et
// al. 2024), and less beyond.
float same_light(vec2 a, vec2 b)
{
    float apart = a.r - b.r;
    float noise = u_noise_tolerance * (a.g + b.g) + LEAST_VARIANCE;
    float beyond = max(apart * apart - noise, 0.0);
    noise *= noise;
    return noise / (noise + beyond * beyond);
}

Centre centre_at(ivec2 texel, float z)
{
    Centre c;
    c.texel = texel;
    c.is_edge = false;
    c.light = vec2(0.0);
    vec4 normals = texelFetch(t_normals_vs, texel, 0);
    c.shading_code = normals.xy;
    float reach = NORMAL_REACH;
#if IS_OF_GLOSS
    // What a lobe reflects changes where normals turn by its width.
    float roughness = texelFetch(t_gloss, texel, 0).a;
    reach = min(reach, LOBE_REACH * max(roughness * roughness, LEAST_ALPHA));
#endif
    c.per_turn_2 = 1.0 / (reach * reach);
    vec3 geometric = oct_decode(normals.zw);
    c.per_footprint = 1.0 / pixel_height_at(z);
    c.per_depth = c.per_footprint / (DEEP * float(STRIDE));
    c.depth = z * c.per_depth;
    // Of what one pixel of the values covers at this depth.
    float tolerance = u_depth_tolerance * pixel_height_at(z) * float(STRIDE);
    c.rate = plane_rate(uv_of_texel(texel), geometric) / tolerance;
    c.offset = plane_height(c.rate, vec2(0.0), z);
    return c;
}

// How much a tap shows the same surface: 1 on the centre's tangent plane at any tilt,
// falling with the distance from it in footprints of a pixel, where the farther of the two is, and
// with that in depth where pixels have rays.
// So it knows neither scene units nor the angle of view; and towards a horizon, where the next
// pixel is many times as far, a normal's last digit does not decide.
// `away`: in texels, from the centre.
float same_surface(Centre c, ivec2 texel, vec2 away, float z)
{
    float x = plane_height(c.rate, away, z) - c.offset;
    float reach = max(pixel_height_at(z) * c.per_footprint, 1.0);
    float apart = reach * reach + x * x;
#if PARTS_EDGES && STAGE != STAGE_UPSAMPLE
    float deep = z * c.per_depth - c.depth;
    apart *= 1.0 + deep * deep;
#endif
    float weight = reach * reach / apart;
    // The tail of 1 / (1 + x^2) is long: cut it off smoothly.
    weight *= weight;
#if USE_NORMALS
    // Compared as they are stored: decoding them costs half as much as the whole filter.
    // Codes of normals that face the camera, all but a few at grazing angles, lie on one
    // sheet, and their distance is about the angle: a weight of 1 if alike, a half at 25
    // degrees, next to nothing from 50 on. Never 0: where all taps face elsewhere (a ledge
    // thinner than a pixel of a half-size image), they are still the best that is known.
    vec2 turn = 2.0 * (texelFetch(t_normals_vs, texel, 0).xy - c.shading_code);
    float agree = max(1.0 - dot(turn, turn) * c.per_turn_2, 0.0);
    weight *= max(agree * agree, 1e-3);
#endif
    return z > 0.0 ? weight : 0.0;
}

// A value that may enter a sum. What an earlier stage wrote may always. Asked of the bits, whose
// order is that of numbers from 0 on: what is negative, or no number, stands above all of them.
// A depth that is no number gives a tap no weight.
bool is_sound(int signal, vec4 value)
{
    uvec4 bits = floatBitsToUint(value);
    uint one = floatBitsToUint(1.0);
#if !IS_FIRST
    return true;
#elif IS_VISIBILITY
    return bits.x <= one;
#else
    bool is_light = max(max(bits.r, bits.g), bits.b) <= floatBitsToUint(u_value_bound);
    return is_light && (holds_z(signal) || bits.a <= one);
#endif
}

float z_of(ivec2 texel, vec4 values[SIGNAL_COUNT])
{
#if Z_SIGNALS > 0 && IS_VISIBILITY
    return values[0].y;
#elif Z_SIGNALS > 0
    return values[Z_SIGNALS == 2 ? 1 : 0].a;
#else
    return gbuffer_z_vs(texel);
#endif
}

// Whether a pixel whose values hold z traces many rays.
bool is_edge(ivec2 texel, float z)
{
#if PARTS_EDGES == 1
    return z < 0.0;
#elif PARTS_EDGES == 2
    return texelFetch(t_gathered_near, texel, 0).a < 0.0;
#else
    return false;
#endif
}

bool is_centre_edge(ivec2 pixel)
{
    ivec2 texel = pixel * STRIDE;
    vec4 values[SIGNAL_COUNT];
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        values[i] = value_at(i, pixel);
    return is_edge(texel, z_of(texel, values));
}

struct Sum {
    vec4 value;
    float weight;
#if FITS_LINE
    // The same times how far away taps lie, and of weights times its square.
    vec4 tilted;
    vec2 moments;
#endif
};
#if FITS_LINE
const Sum NO_SUM = Sum(vec4(0.0), 0.0, vec4(0.0), vec2(0.0));
#else
const Sum NO_SUM = Sum(vec4(0.0), 0.0);
#endif

// Where taps lie to one side only, as at a joint, towards which light falls off within pixels, light
// there is not the centre's. A line through the taps tells how it changes (Cleveland 1979), and
// takes that off, as far as taps still count something, up to the kernel's end.
vec4 mean_of(Sum sum)
{
#if FITS_LINE
    const float MOST = 1.0 / float(TAP_RADIUS + 1);
    float tilt = clamp(sum.moments.x / max(sum.moments.y, 1e-30), -MOST, MOST);
    return (sum.value - tilt * sum.tilted) / (sum.weight - tilt * sum.moments.x);
#else
    return sum.value / sum.weight;
#endif
}

#if KNOWS_NOISE
// Of weighed light, its variance, and weights.
vec3 light_sum = vec3(0.0);
#endif

// The tap at `pixel`, which lies `away` from the centre, in texels, and `step` along the axis.
void add_tap(inout Sum sums[SIGNAL_COUNT], Centre c, ivec2 pixel, vec2 away, ivec2 size,
             float weight, float step)
{
    ivec2 inside = clamp(pixel, ivec2(0), size - 1);
    ivec2 texel = inside * STRIDE;
    vec4 values[SIGNAL_COUNT];
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        values[i] = value_at(i, inside);
    float z = z_of(texel, values);
#if PARTS_EDGES == 1
    weight *= same_surface(c, texel, away, abs(z));
#else
    weight *= same_surface(c, texel, away, z);
#endif
#if STAGE != STAGE_UPSAMPLE
    weight *= is_edge(texel, z) == c.is_edge ? 1.0 : OTHER_WEIGHT;
#endif
#if KNOWS_NOISE
    vec2 light = light_at(inside);
    weight *= same_light(light, c.light);
    float counted = inside == pixel ? weight : 0.0;
    light_sum += counted * vec3(light.r, counted * light.g, 1.0);
#endif
    for (int i = 0; i < SIGNAL_COUNT; ++i) {
        bool use = is_sound(i, values[i]) && inside == pixel && weight > 0.0;
        vec4 value = use ? values[i] * weight : vec4(0.0);
        float share = use ? weight : 0.0;
        sums[i].value += value;
        sums[i].weight += share;
#if FITS_LINE
        sums[i].tilted += step * value;
        sums[i].moments += step * share * vec2(1.0, step);
#endif
    }
}

// What the stage makes of the surface at `texel`, whose depth is z; `pixel` is its place among
// the values, or where the stage brings them to the frame's size, in the frame. Where the sign of z
// says whose rays the values are, it does so afterwards.
void filter_surface(ivec2 pixel, ivec2 texel, inout float z, inout vec4 results[SIGNAL_COUNT])
{
    ivec2 size = textureSize(t_value_0, 0);
#if STAGE == STAGE_COPY
    vec4 values[SIGNAL_COUNT];
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        values[i] = value_at(i, pixel / STRIDE);
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        results[i] = is_sound(i, values[i]) ? values[i] : neutral(i);
#else
    Centre c = centre_at(texel, z);
#if PARTS_EDGES && STAGE != STAGE_UPSAMPLE
    c.is_edge = is_centre_edge(pixel);
    z = PARTS_EDGES == 1 && c.is_edge ? -z : z;
#endif
#if KNOWS_NOISE
    c.light = light_at(pixel);
#endif
    Sum sums[SIGNAL_COUNT];
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        sums[i] = NO_SUM;
#if STAGE == STAGE_SEPARABLE
    const ivec2 axis = ivec2(1 - IS_VERTICAL, IS_VERTICAL);
    // Tested at its end: in software other loops cost two rounds more than they run.
    int i = -TAP_RADIUS;
    do {
        int trapezoid = min(min(4, 2 * TAP_RADIUS - 2), TAP_RADIUS + 1 - abs(i));
        vec2 away = float(i * STRIDE) * vec2(axis);
        add_tap(sums, c, pixel + i * axis, away, size, float(trapezoid), float(i));
    } while (++i <= TAP_RADIUS);
#elif STAGE == STAGE_APART
    for (int i = 0; i < 9; ++i) {
        ivec2 step_px = ivec2(i % 3, i / 3) - 1;
        float near = 1.0 + 0.25 * float(step_px.x * step_px.x + step_px.y * step_px.y);
        vec2 away = float(STEP * STRIDE) * vec2(step_px);
        add_tap(sums, c, pixel + STEP * step_px, away, size, 1.0 / (near * near), 0.0);
    }
#elif STAGE == STAGE_BOX
    for (int y = -2; y < 2; ++y)
        for (int x = -2; x < 2; ++x)
            add_tap(sums, c, pixel + ivec2(x, y), float(STRIDE) * vec2(x, y), size, 1.0, 0.0);
#else
    // The four pixels of the values around the texel, bilinear times same_surface.
    // Pixel p of the values sits on texel p * STRIDE.
    vec2 position = vec2(pixel) / float(STRIDE);
    ivec2 base = ivec2(floor(position));
    vec2 f = position - vec2(base);
    // Never exactly 0, so that a tap across an edge can be replaced by any other.
    vec2 near = max(1.0 - f, vec2(1e-3));
    vec2 far = max(f, vec2(1e-3));
    float stride = float(STRIDE);
    vec2 away = vec2(base * STRIDE - texel);
    add_tap(sums, c, base, away, size, near.x * near.y, 0.0);
    add_tap(sums, c, base + ivec2(1, 0), away + vec2(stride, 0.0), size, far.x * near.y, 0.0);
    add_tap(sums, c, base + ivec2(0, 1), away + vec2(0.0, stride), size, near.x * far.y, 0.0);
    // Then the fourth. Where none of them lies on a thing so thin, what is known of it
    // farther away, or else of the surroundings, is better than nothing: one loop for
    // both, because one that runs no rounds takes the time of one in software.
    int i = -1;
    bool is_lost = false;
    do {
        ivec2 place = i < 0 ? ivec2(1) : ivec2(i & 3, i >> 2) - 1;
        add_tap(sums, c, base + place, away + stride * vec2(place), size,
                i < 0 ? far.x * far.y : 1.0, 0.0);
        is_lost = is_lost || (i < 0 && sums[0].weight < LEAST_WEIGHT);
    } while (is_lost && ++i < 16);
#endif
    for (int i = 0; i < SIGNAL_COUNT; ++i)
        results[i] = sums[i].weight > 0.0 ? mean_of(sums[i]) : neutral(i);
#endif
}
