// From scene-linear radiance (Rec.709) to display values.

// Anything a select lets through is finite and not negative: min() and max() may pass
// NaN, a failed comparison cannot. The bound is the largest half float; every tone
// curve here has reached white long before.
const float DISPLAY_MAX_RADIANCE = 65504.0;

float displayable(float x)
{
    return x > 0.0 ? (x < DISPLAY_MAX_RADIANCE ? x : DISPLAY_MAX_RADIANCE) : 0.0;
}

vec3 displayable(vec3 c)
{
    return vec3(displayable(c.r), displayable(c.g), displayable(c.b));
}

// Narkowicz 2015, "ACES Filmic Tone Mapping Curve": a rational fit of the ACES output
// transform for Rec.709 displays, applied per channel. His 0.6 puts middle grey where
// the reference transform has it.
vec3 tone_curve_aces(vec3 radiance)
{
    vec3 x = 0.6 * radiance;
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// IEC 61966-2-1: linear toe, then a power. Input in [0, 1].
float srgb_encode(float x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

vec3 srgb_encode(vec3 c)
{
    return vec3(srgb_encode(c.r), srgb_encode(c.g), srgb_encode(c.b));
}

// What hides the steps of eight bits: added, in steps, before rounding to one. In
// (-0.5, 0.5), by the R2 sequence (Roberts 2018), as `ssdo_gl/images/display.py`. One
// axis at a time keeps the fractions exact to 1e-3 up to 16384 pixels.
float dither_pattern(vec2 pixel)
{
    vec2 part = fract(floor(pixel) * vec2(0.7548776662466927, 0.5698402909980532));
    return fract(0.5 + part.x + part.y) - 0.5;
}

// The inverse.
float srgb_decode(float x)
{
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

vec3 srgb_decode(vec3 c)
{
    return vec3(srgb_decode(c.r), srgb_decode(c.g), srgb_decode(c.b));
}
