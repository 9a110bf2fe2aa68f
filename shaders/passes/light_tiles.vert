#version 330 core
// A point as large as a tile on each tile of one kind; on the others one beside the picture.
uniform sampler2D t_light_tiles;
uniform float u_kind;
uniform vec2 u_viewport_px;  // wider than the picture

void main()
{
    int columns = textureSize(t_light_tiles, 0).x;
    ivec2 tile = ivec2(gl_VertexID % columns, gl_VertexID / columns);
    bool is_drawn = abs(texelFetch(t_light_tiles, tile, 0).x - u_kind) < 0.5;
    float size = float(TILE_PIXELS);
    vec2 centre = is_drawn ? (vec2(tile) + 0.5) * size : u_viewport_px - 0.5 * size;
    gl_PointSize = size;
    gl_Position = vec4(2.0 * centre / u_viewport_px - 1.0, 0.0, 1.0);
}
