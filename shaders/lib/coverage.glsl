// Which fragments of a surface are drawn whose alpha says how much of it there is.
//
// Translucent surfaces keep the share `alpha` of their fragments, by chance, at different
// places in each frame: stochastic transparency (Enderton et al. 2010). Any number of layers
// comes out right on average, and every effect sees surfaces only.
uniform float u_frame_chance;  // [0, 1), differs between frames by the golden ratio

bool is_left_out(float alpha, float cutoff)
{
    if (cutoff >= 0.0) {
        return alpha < cutoff;
    }
    // Layers that cover each other need thresholds of their own: depth tells them apart.
    uint layer = (floatBitsToUint(gl_FragCoord.w) >> 14) * 0x9e3779b9u;
    layer = (layer ^ layer >> 15) * 0x2c1b3c6du;
    layer ^= layer >> 12;
    // Interleaved gradient noise (Jimenez 2014): each 3 x 3 pixels hold all thresholds.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float turns = float(1u + (layer & 15u));
    float start = float(layer >> 8) * (1.0 / 16777216.0);
    return alpha <= fract(noise + start + turns * u_frame_chance);
}
