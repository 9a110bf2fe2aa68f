// Vertex stage: a number for each triangle that is drawn by chance, see lib/coverage.glsl.
//
// HAS_ALPHA_CUTOUT: 0 if all that is drawn is whole.
#if HAS_ALPHA_CUTOUT

flat out uint v_layer;

// By where its last vertex lies (the hash of Teschner et al. 2003): the same in all frames of a
// view, however pixels are shifted.
uint layer_at(vec3 position)
{
    uvec3 bits = floatBitsToUint(position) * uvec3(73856093u, 19349663u, 83492791u);
    uint layer = bits.x ^ bits.y ^ bits.z;
    layer = (layer ^ layer >> 15) * 0x2c1b3c6du;
    return layer ^ layer >> 12;
}
#endif
