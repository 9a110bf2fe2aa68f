#version 330 core
// Places a vertex in the frame of one face of a shadow map (looking along -z).
//
// EMITTING_SIDES: of a light that shares its body with others, on how many sides of its plane
// something may block it; else 0: everywhere. ALBEDO_ON_SECOND_UVS: where the image of holes lies.
#include "lib/instance.glsl"
#include "lib/layer.glsl"

uniform mat4 u_clip_from_view;

out float v_depth;  // along the face's axis
#if EMITTING_SIDES > 0
uniform vec4 u_light_plane;  // unit normal on the side that emits, clearance
#endif
#if HAS_ALPHA_CUTOUT
in vec4 a_albedo;
in vec2 a_emission_side_cutoff;
flat out float v_alpha;
flat out float v_alpha_cutoff;
#if HAS_VERTEX_COLORS
in vec4 a_color;
out float v_vertex_alpha;
#endif
#if HAS_ALBEDO_TEXTURE
out vec2 v_material_uv;
#if ALBEDO_ON_SECOND_UVS
in vec2 a_second_uv;
#else
in vec2 a_uv;
#endif
#endif
#endif

void main()
{
    vec3 position = instance_position_vs();
    gl_Position = u_clip_from_view * vec4(position, 1.0);
    v_depth = -position.z;
#if EMITTING_SIDES > 0
    float height = dot(u_light_plane.xyz, position);
    gl_ClipDistance[0] = (EMITTING_SIDES == 2 ? abs(height) : height) - u_light_plane.w;
#endif
#if HAS_ALPHA_CUTOUT
    v_layer = layer_at(position);
    v_alpha = a_albedo.a;
    v_alpha_cutoff = a_emission_side_cutoff.y;
#if HAS_VERTEX_COLORS
    v_vertex_alpha = a_color.a;
#endif
#if HAS_ALBEDO_TEXTURE
#if ALBEDO_ON_SECOND_UVS
    v_material_uv = a_second_uv;
#else
    v_material_uv = a_uv;
#endif
#endif
#endif
}
