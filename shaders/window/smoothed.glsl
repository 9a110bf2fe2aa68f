// A picture with smooth edges, though a pixel shows one point: FXAA 3 (Lottes 2011), cut short.
//
// A pixel beside an edge takes over as much of the pixel across as the edge would cover, were it
// straight: where it ends, on either side, says how far it has crossed the pixel by here. What
// is thinner than a pixel is told from the pixels around, and takes over some of them.
//
// Against 64 sub-pixel offsets pictures of `direct` err by .64 (stairs), .45 (courtyard), .79
// (cornell_meso) and .66 (colonnade) of what they did, RMS of linear light, for 11 ms of processor
// time at 640x360; with five steps for four by .65, .33, .88 and .66, for 12 ms; the form without
// a search for ends (Lottes 2009) by .73, .71, .87 and .82, for 6 ms.

// Steps of 1, 2, 4 and 8 pixels to either side.
const int END_STEPS = 4;
// Least contrast that is an edge, and the least part of the brightest pixel: less is a gradient.
const float LEAST_CONTRAST = 0.03;
const float LEAST_RELATIVE_CONTRAST = 0.1;
// How much an isolated pixel takes over, at most, of the one across: with more, grain blurs.
const float SUB_PIXEL_SHARE = 0.5;

// As bright as an eye finds it: the root of luminance, Rec. 709.
float brightness(sampler2D image, vec2 uv, float weight)
{
    vec3 c = weight * textureLod(image, uv, 0.0).rgb;
    return sqrt(clamp(dot(c, vec3(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
}

// The image, times `weight`, at `uv`. Of the smoothing `share` is done, in [0, 1].
vec4 smoothed(sampler2D image, vec2 uv, float weight, float share)
{
    vec2 pixel = 1.0 / vec2(textureSize(image, 0));
#define NEXT(X, Y) brightness(image, uv + pixel * vec2(X, Y), weight)
    float here = NEXT(0, 0);
    float n = NEXT(0, 1), s = NEXT(0, -1), e = NEXT(1, 0), w = NEXT(-1, 0);
    float ne = NEXT(1, 1), nw = NEXT(-1, 1), se = NEXT(1, -1), sw = NEXT(-1, -1);
#undef NEXT
    float brightest = max(here, max(max(n, s), max(e, w)));
    float contrast = brightest - min(here, min(min(n, s), min(e, w)));
    bool is_edge = contrast >= max(LEAST_CONTRAST, LEAST_RELATIVE_CONTRAST * brightest);

    float across_rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * here)
        + abs(ne + se - 2.0 * e);
    float across_columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(e + w - 2.0 * here)
        + abs(sw + se - 2.0 * s);
    bool is_level = across_rows >= across_columns;
    vec2 across = is_level ? vec2(0.0, pixel.y) : vec2(pixel.x, 0.0);
    vec2 along = is_level ? vec2(pixel.x, 0.0) : vec2(0.0, pixel.y);
    float before = is_level ? s : w;
    float after = is_level ? n : e;
    bool is_before = abs(before - here) >= abs(after - here);
    across = is_before ? -across : across;
    float other = is_before ? before : after;
    float middle = 0.5 * (here + other);
    float most_change = 0.25 * abs(other - here);

    // Between two rows (columns) of pixels, until their mean is no longer that of the edge.
    vec2 between = uv + 0.5 * across;
    vec2 reached = vec2(0.0);
    vec2 change = vec2(0.0);
    bvec2 has_ended = bvec2(false);
    int i = 0;
    do {
        reached += vec2(not(has_ended)) * float(1 << i);
        vec2 found = vec2(brightness(image, between - reached.x * along, weight),
                          brightness(image, between + reached.y * along, weight)) - middle;
        change = mix(found, change, vec2(has_ended));
        has_ended = bvec2(abs(change.x) >= most_change, abs(change.y) >= most_change);
        ++i;
    } while (i < END_STEPS);

    bool is_first = reached.x < reached.y;
    // Beyond the nearer end the edge goes on one row up, or down: only on one side it crosses this.
    bool crosses = (is_first ? change.x < 0.0 : change.y < 0.0) != (here < middle);
    float length_px = max(reached.x + reached.y, 1.0);
    float covered = crosses ? 0.5 - min(reached.x, reached.y) / length_px : 0.0;

    float around = (2.0 * (n + s + e + w) + ne + nw + se + sw) / 12.0;
    float apart = smoothstep(0.0, 1.0, abs(around - here) / max(contrast, 1e-6));
    float taken = max(covered, SUB_PIXEL_SHARE * apart * apart);
    return weight * textureLod(image, uv + (is_edge ? share * taken : 0.0) * across, 0.0);
}
