#version 330 core
// One triangle that covers the viewport, made from gl_VertexID: no vertex buffer.
// A triangle rather than a quad, because a quad shades the pixels along its diagonal twice.

out vec2 v_uv;  // 0..1 across the viewport, (0, 0) at the bottom left

void main()
{
    // Corners (0,0), (2,0), (0,2): the half beyond 1 is clipped away.
    vec2 corner = vec2(float((gl_VertexID & 1) << 1), float(gl_VertexID & 2));
    v_uv = corner;
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
