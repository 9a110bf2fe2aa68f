// Squares of the frame in which no direction of any point is blocked within R, found
// beforehand (open_tiles.frag).
//
// OPEN_TILE_SIZE: pixels along a square's sides, a power of two; 0 if none were looked for.
#if OPEN_TILE_SIZE > 0
uniform sampler2D t_open_tiles;  // 1 where nothing is blocked

bool is_in_open_tile(ivec2 texel)
{
    return texelFetch(t_open_tiles, texel / OPEN_TILE_SIZE, 0).x > 0.5;
}
#else
bool is_in_open_tile(ivec2 texel)
{
    return false;
}
#endif
