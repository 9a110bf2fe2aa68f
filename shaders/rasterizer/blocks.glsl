// Triangles that are too large for one invocation, and the blocks of pixels that they may cover.
const int BLOCK_SIDE = 64;
const uint NO_RECORD = 0xffffffffu;

// Triangles, and blocks, that there is room for; what is too much one invocation draws.
uniform uvec2 u_room;

struct Record {
    vec4 edge_0;  // w: the corner
    vec4 edge_1;
    vec4 edge_2;
    vec4 normal;  // w: the number, as bits
    vec4 depths;
};

layout(std430, binding = 2) buffer Records {
    uint u_record_count;
    uint u_block_count;
    uint u_unused[2];
    Record u_records[];
};

// Record, and column and row of the block as halves of a number.
layout(std430, binding = 3) buffer Blocks {
    uvec2 u_blocks[];
};

bool is_overfull()
{
    return u_record_count > u_room.x || u_block_count > u_room.y;
}
