#version 330 core
// The surface nearest to the camera: linear depth, normals, albedo, emission.
//
// HAS_SHADING_NORMALS, HAS_VERTEX_COLORS, HAS_ALBEDO_TEXTURE, HAS_EMISSION_TEXTURE,
// HAS_ALPHA_CUTOUT: what the objects of this draw call have; HAS_INSTANCE_MATERIALS:
// whether they differ in their material; WIDE_DEPTH_RANGE: see
// lib/depth_test.glsl; WRITES_NORMALS, WRITES_ALBEDO, WRITES_EMISSION, WRITES_LIFT: what is
// read.
#include "lib/space.glsl"
#include "lib/octahedral.glsl"
#include "lib/depth_test.glsl"
#include "lib/normals.glsl"

flat in vec3 v_face_normal_vs;
#if HAS_INSTANCE_MATERIALS
flat in vec4 v_albedo;
flat in vec4 v_emission;
flat in vec2 v_emission_side_cutoff;
#define MATERIAL_ALBEDO v_albedo
#define MATERIAL_EMISSION v_emission
#define MATERIAL_SIDE_CUTOFF v_emission_side_cutoff
#else
uniform vec4 u_albedo;
uniform vec4 u_emission;
uniform vec2 u_emission_side_cutoff;
#define MATERIAL_ALBEDO u_albedo
#define MATERIAL_EMISSION u_emission
#define MATERIAL_SIDE_CUTOFF u_emission_side_cutoff
#endif
#if HAS_SHADING_NORMALS
in vec3 v_normal_vs;
#if WRITES_LIFT
in float v_height_vs;
#endif
#endif
#if HAS_VERTEX_COLORS
in vec4 v_color;
#endif
#if HAS_ALBEDO_TEXTURE || HAS_EMISSION_TEXTURE
in vec2 v_material_uv;
#endif
#if HAS_EMISSION_UVS
in vec2 v_emission_uv;
#define EMISSION_UV v_emission_uv
#else
#define EMISSION_UV v_material_uv
#endif
#if HAS_ALBEDO_TEXTURE
uniform sampler2D t_albedo;
#endif
#if HAS_EMISSION_TEXTURE
uniform sampler2D t_emission;
#endif

// Targets are numbered without gaps.
#if WRITES_NORMALS
#define ALBEDO_LOCATION 2
#else
#define ALBEDO_LOCATION 1
#endif
#if WRITES_NORMALS && WRITES_ALBEDO
#define EMISSION_LOCATION 3
#elif WRITES_NORMALS || WRITES_ALBEDO
#define EMISSION_LOCATION 2
#else
#define EMISSION_LOCATION 1
#endif
#if WRITES_NORMALS && WRITES_ALBEDO && WRITES_EMISSION
#define LIFT_LOCATION 4
#elif WRITES_NORMALS && (WRITES_ALBEDO || WRITES_EMISSION) || WRITES_ALBEDO && WRITES_EMISSION
#define LIFT_LOCATION 3
#elif WRITES_NORMALS || WRITES_ALBEDO || WRITES_EMISSION
#define LIFT_LOCATION 2
#else
#define LIFT_LOCATION 1
#endif

layout(location = 0) out float o_z_vs;
#if WRITES_NORMALS
layout(location = 1) out vec4 o_normals_vs;
#endif
#if WRITES_ALBEDO
layout(location = ALBEDO_LOCATION) out vec4 o_albedo;
#endif
#if WRITES_EMISSION
layout(location = EMISSION_LOCATION) out vec4 o_emission;
#endif

#if WRITES_LIFT
layout(location = LIFT_LOCATION) out float o_lift_vs;

// Lifts below this, relative to the distance from the eye, are what rasterizers round.
const float LIFT_ROUNDING = 4e-5;
#endif

void main()
{
    vec4 albedo = MATERIAL_ALBEDO;
#if HAS_VERTEX_COLORS
    albedo *= v_color;
#endif
#if HAS_ALBEDO_TEXTURE
    albedo *= texture(t_albedo, v_material_uv);
#endif
#if HAS_ALPHA_CUTOUT
    if (albedo.a < MATERIAL_SIDE_CUTOFF.y) {
        discard;
    }
#endif
    // clip.w is z, and the rasterizer interpolates 1 / w linearly over the screen.
    float z = 1.0 / gl_FragCoord.w;
    vec3 ray = view_ray_at(gl_FragCoord.xy / u_frame_size_px);
    // From the ray through this pixel, not from the winding on screen: right for
    // mirrored instances, and the same for all pixels of a triangle.
    bool is_front = dot(v_face_normal_vs, ray) <= 0.0;
    vec2 face_code = oct_encode(is_front ? v_face_normal_vs : -v_face_normal_vs);
    vec2 shading_code = face_code;
#if HAS_SHADING_NORMALS
    bool is_turned = faces_back(v_normal_vs, v_face_normal_vs);
    vec3 normal = is_turned == is_front ? -v_normal_vs : v_normal_vs;
    // Opposite vertex normals can cancel in between: then the face's own.
    shading_code = dot(normal, normal) > 0.0 ? oct_encode(normal) : face_code;
#endif
    vec3 emission = MATERIAL_EMISSION.rgb;
#if HAS_EMISSION_TEXTURE
    emission *= texture(t_emission, EMISSION_UV).rgb;
#endif
    bool emits = is_front || MATERIAL_SIDE_CUTOFF.x > 0.5;

    o_z_vs = z;
#if WRITES_NORMALS
    o_normals_vs = vec4(shading_code, face_code);
#endif
#if WRITES_ALBEDO
    o_albedo = vec4(albedo.rgb, 1.0);
#endif
#if WRITES_EMISSION
    o_emission = vec4(emits ? emission : vec3(0.0), MATERIAL_EMISSION.a);
#endif
#if WRITES_LIFT
    o_lift_vs = 0.0;
#if HAS_SHADING_NORMALS
    // How far the planes across the corners' normals lie above the triangle: the mean of
    // n . (corner - p), weighted as the normal is.
    float lift = v_height_vs - dot(ray * z, v_normal_vs);
    lift = is_turned == is_front ? -lift : lift;
    o_lift_vs = lift > LIFT_ROUNDING * z * length(ray) ? lift : 0.0;
#endif
#endif
    write_depth(z);
}
