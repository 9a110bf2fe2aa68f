// Bounds of squares of a shadow map's texels, at several sizes (passes/shadow_blocks.py).
//
// Nearness is the inverse of depth, in which planes stay planes, or minus the depth of parallel
// light. Of each square: (a, b, high, low). Where (x, y) counts texels from the square's centre, the
// nearness of all its texels lies between a * x + b * y + low and a * x + b * y + high.
const int BLOCK_TEXELS = 8;
const int BLOCK_LEVELS = 7;

// Squares of the lowest level, multiples of 2^(levels - 1). Each level has half as many.
uniform ivec2 u_block_grid;

// Where a level begins: beside the lowest, one above the other.
ivec2 block_corner(int level)
{
    int above = u_block_grid.y - (u_block_grid.y >> max(level - 1, 0));
    return level == 0 ? ivec2(0) : ivec2(u_block_grid.x, above);
}
