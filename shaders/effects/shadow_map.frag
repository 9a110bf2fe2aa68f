#version 330 core
// Depth along the axis of a shadow map's face, linear.
//
// IS_PARALLEL: a directional light's map. HAS_ALPHA_CUTOUT, and with it HAS_VERTEX_COLORS
// and HAS_ALBEDO_TEXTURE: where the objects' alpha comes from.
#include "lib/depth_test.glsl"
#include "lib/coverage.glsl"

in float v_depth;
#if HAS_ALPHA_CUTOUT
flat in float v_alpha;
flat in float v_alpha_cutoff;
#if HAS_VERTEX_COLORS
in float v_vertex_alpha;
#endif
#if HAS_ALBEDO_TEXTURE
in vec2 v_material_uv;
uniform sampler2D t_albedo_image;
#endif
#endif

layout(location = 0) out float o_depth;

void main()
{
#if HAS_ALPHA_CUTOUT
    float alpha = v_alpha;
#if HAS_VERTEX_COLORS
    alpha *= v_vertex_alpha;
#endif
#if HAS_ALBEDO_TEXTURE
    alpha *= texture(t_albedo_image, v_material_uv).a;
#endif
    if (is_left_out(alpha, v_alpha_cutoff)) {
        discard;
    }
#endif
#if IS_PARALLEL
    float depth = v_depth;
#else
    // clip.w is the depth; see projections/perspective.glsl.
    float depth = 1.0 / gl_FragCoord.w;
#endif
    o_depth = depth;
    write_depth(depth);
}
