#version 330 core
// Places a vertex in view space and turns its normals there.
#include "lib/instance.glsl"
#include "lib/material_uvs.glsl"
#include "lib/layer.glsl"

uniform mat4 u_clip_from_view;

in vec3 a_normal_face_os;
flat out vec3 v_face_normal_vs;   // outward

in vec4 a_albedo;                 // rgb, alpha factor
in vec4 a_emission;               // radiance, 1 if no light delivers it
in vec2 a_emission_side_cutoff;   // 1 if both sides emit; alpha cutoff
flat out vec4 v_albedo;
flat out vec4 v_emission;
flat out vec2 v_emission_side_cutoff;
#if HAS_GLOSS
in vec4 a_dielectric;             // reflectance at normal incidence, strength
flat out vec4 v_dielectric;
#endif
#if HAS_GLOSS || HAS_NORMAL_IMAGE || HAS_OCCLUSION_IMAGE
in vec4 a_gloss;                  // metallic, roughness, scale of normals, strength of occlusion
flat out vec4 v_gloss;
#endif
#if HAS_SHADING_NORMALS
in vec3 a_normal_os;
out vec3 v_normal_vs;
#endif
#if HAS_SHADING_NORMALS && LIFT_LOCATION
out float v_height_vs;
#endif
#if HAS_TANGENTS
in vec4 a_tangent_os;             // direction, handedness
out vec4 v_tangent_vs;
#endif
#if HAS_VERTEX_COLORS
in vec4 a_color;
out vec4 v_color;
#endif
#if HAS_UVS
in vec2 a_uv;
out vec2 v_uv;
#endif
#if HAS_SECOND_UVS
in vec2 a_second_uv;
out vec2 v_second_uv;
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
#if HAS_ALPHA_CUTOUT
    v_layer = layer_at(position_vs);
#endif
    v_albedo = a_albedo;
    v_emission = a_emission;
    v_emission_side_cutoff = a_emission_side_cutoff;
#if HAS_GLOSS
    v_dielectric = a_dielectric;
#endif
#if HAS_GLOSS || HAS_NORMAL_IMAGE || HAS_OCCLUSION_IMAGE
    v_gloss = a_gloss;
#endif
#if HAS_SHADING_NORMALS
    v_normal_vs = instance_normal_vs(a_normal_os);
#if LIFT_LOCATION
    v_height_vs = dot(position_vs, v_normal_vs);
#endif
#endif
#if HAS_TANGENTS
    v_tangent_vs = instance_tangent_vs(a_tangent_os);
#endif
#if HAS_VERTEX_COLORS
    v_color = a_color;
#endif
#if HAS_UVS
    v_uv = a_uv;
#endif
#if HAS_SECOND_UVS
    v_second_uv = a_second_uv;
#endif
}
