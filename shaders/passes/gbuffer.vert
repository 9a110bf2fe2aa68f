#version 330 core
// Places a vertex in view space and turns its normals there.
#include "lib/instance.glsl"

uniform mat4 u_clip_from_view;

in vec3 a_normal_face_os;
flat out vec3 v_face_normal_vs;   // outward

// Every number handed on costs time for each triangle, so what is the same for a whole
// draw call comes to the fragments as a uniform.
#if HAS_INSTANCE_MATERIALS
in vec4 a_albedo;                 // rgb, alpha factor
in vec4 a_emission;               // radiance, 1 if no light delivers it
in vec2 a_emission_side_cutoff;   // 1 if both sides emit; alpha cutoff
flat out vec4 v_albedo;
flat out vec4 v_emission;
flat out vec2 v_emission_side_cutoff;
#endif
#if HAS_SHADING_NORMALS
in vec3 a_normal_os;
out vec3 v_normal_vs;
#endif
#if HAS_SHADING_NORMALS && WRITES_LIFT
out float v_height_vs;
#endif
#if HAS_VERTEX_COLORS
in vec4 a_color;
out vec4 v_color;
#endif
#if HAS_ALBEDO_TEXTURE || HAS_EMISSION_TEXTURE
in vec2 a_uv;
out vec2 v_material_uv;
#endif
#if HAS_EMISSION_UVS
in vec2 a_emission_uv;
out vec2 v_emission_uv;
#endif

void main()
{
    vec3 position_vs = instance_position_vs();
    gl_Position = u_clip_from_view * vec4(position_vs, 1.0);
#if WIDE_DEPTH_RANGE
    // The fragment writes depth. Hyperbolic depth of what is far rounds to 1 and above
    // here, where clipping would tear holes into it.
    gl_Position.z = 0.0;
#endif
    v_face_normal_vs = instance_normal_vs(a_normal_face_os);
#if HAS_INSTANCE_MATERIALS
    v_albedo = a_albedo;
    v_emission = a_emission;
    v_emission_side_cutoff = a_emission_side_cutoff;
#endif
#if HAS_SHADING_NORMALS
    v_normal_vs = instance_normal_vs(a_normal_os);
#if WRITES_LIFT
    v_height_vs = dot(position_vs, v_normal_vs);
#endif
#endif
#if HAS_VERTEX_COLORS
    v_color = a_color;
#endif
#if HAS_ALBEDO_TEXTURE || HAS_EMISSION_TEXTURE
    v_material_uv = a_uv;
#endif
#if HAS_EMISSION_UVS
    v_emission_uv = a_emission_uv;
#endif
}
