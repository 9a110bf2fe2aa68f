// Which fragments of a surface are drawn whose alpha says how much of it there is.
//
// Translucent surfaces keep the share `alpha` of their fragments, by chance, at different
// places in each frame: stochastic transparency (Enderton et al. 2010). Any number of layers
// comes out right on average, and every effect sees surfaces only.
//
// HAS_ALPHA_CUTOUT: 0 if all that is drawn is whole.
#if HAS_ALPHA_CUTOUT

uniform uvec3 u_frame_of_picture;  // its number, how many there are, the picture's seed
// Tells triangles apart: layers that cover each other need thresholds of their own.
flat in uint v_layer;

// Place of item `i` in an order of `count` items: Kensler 2013, "Correlated Multi-Jittered
// Sampling".
uint permuted(uint i, uint count, uint order)
{
    uint mask = count - 1u;
    mask |= mask >> 1;
    mask |= mask >> 2;
    mask |= mask >> 4;
    mask |= mask >> 8;
    do {
        i ^= order;
        i *= 0xe170893du;
        i ^= order >> 16;
        i ^= (i & mask) >> 4;
        i ^= order >> 8;
        i *= 0x0929eb3fu;
        i ^= order >> 23;
        i ^= (i & mask) >> 1;
        i *= 1u | order >> 27;
        i *= 0x6935fa69u;
        i ^= (i & mask) >> 11;
        i *= 0x74dcb303u;
        i ^= (i & mask) >> 2;
        i *= 0x9e501cc3u;
        i ^= (i & mask) >> 2;
        i *= 0xc860a3dfu;
        i &= mask;
        i ^= i >> 5;
    } while (i >= count);
    return (i + order) % count;
}

bool is_left_out(float alpha, float cutoff)
{
    if (cutoff >= 0.0) {
        return alpha < cutoff;
    }
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint order = v_layer ^ (pixel.x | pixel.y << 16) * 0x9e3779b9u ^ u_frame_of_picture.z;
    order = (order ^ order >> 15) * 0x2c1b3c6du;
    order ^= order >> 12;
    // Of n frames each takes another n-th of the thresholds, in an order of the pixel's and the
    // layer's own. After 16 a layer's share is .026 off (RMS), a second one's .049; .068 and .070
    // by multiples of the golden ratio, .10 and .09 if each threshold is drawn by itself.
    uint count = u_frame_of_picture.y;
    float turn = float(permuted(u_frame_of_picture.x, count, order) + count
                       - permuted(0u, count, order)) / float(count);
    // Interleaved gradient noise (Jimenez 2014): each 3 x 3 pixels hold all thresholds.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float start = float(v_layer >> 8) * (1.0 / 16777216.0);
    return alpha <= fract(noise + start + turn);
}
#endif
