#version 330 core
// The surface nearest to the camera: linear depth, normals, albedo, emission, gloss.
//
// HAS_SHADING_NORMALS, HAS_TANGENTS, HAS_VERTEX_COLORS, HAS_ALPHA_CUTOUT, HAS_GLOSS, HAS_<NAME>_IMAGE: what
// the objects of this draw call have; <NAME>_ON_SECOND_UVS: where on its images a point lies;
// WIDE_DEPTH_RANGE: see lib/depth_test.glsl; <NAME>_LOCATION: the target that each output goes
// to, 0 where nobody reads it.
#include "lib/space.glsl"
#include "lib/octahedral.glsl"
#include "lib/depth_test.glsl"
#include "lib/coverage.glsl"
#include "lib/normals.glsl"
#if GLOSS_LOCATION || FINISH_LOCATION
#define GLOSSY 1
#else
#define GLOSSY 0
#endif
#include "lib/brdf.glsl"
#include "lib/bump.glsl"
#include "lib/material_uvs.glsl"

flat in vec3 v_face_normal_vs;
flat in vec4 v_albedo;
flat in vec4 v_emission;
flat in vec2 v_emission_side_cutoff;
#if HAS_GLOSS
flat in vec4 v_dielectric;
#endif
#if HAS_GLOSS || HAS_NORMAL_IMAGE || HAS_OCCLUSION_IMAGE
flat in vec4 v_gloss;
#endif
#if HAS_SHADING_NORMALS
in vec3 v_normal_vs;
#if LIFT_LOCATION
in float v_height_vs;
#endif
#endif
#if HAS_TANGENTS && HAS_SHADING_NORMALS
in vec4 v_tangent_vs;
#endif
#if HAS_VERTEX_COLORS
in vec4 v_color;
#endif
#if HAS_UVS
in vec2 v_uv;
#endif
#if HAS_SECOND_UVS
in vec2 v_second_uv;
#endif
uniform sampler2D t_albedo_image;
uniform sampler2D t_emission_image;
uniform sampler2D t_metallic_roughness_image;
uniform sampler2D t_specular_image;
uniform sampler2D t_specular_color_image;
uniform sampler2D t_normal_image;
uniform sampler2D t_occlusion_image;

#if ALBEDO_ON_SECOND_UVS
#define ALBEDO_UV v_second_uv
#else
#define ALBEDO_UV v_uv
#endif
#if EMISSION_ON_SECOND_UVS
#define EMISSION_UV v_second_uv
#else
#define EMISSION_UV v_uv
#endif
#if METALLIC_ROUGHNESS_ON_SECOND_UVS
#define METALLIC_ROUGHNESS_UV v_second_uv
#else
#define METALLIC_ROUGHNESS_UV v_uv
#endif
#if SPECULAR_ON_SECOND_UVS
#define SPECULAR_UV v_second_uv
#else
#define SPECULAR_UV v_uv
#endif
#if SPECULAR_COLOR_ON_SECOND_UVS
#define SPECULAR_COLOR_UV v_second_uv
#else
#define SPECULAR_COLOR_UV v_uv
#endif
#if NORMAL_ON_SECOND_UVS
#define NORMAL_UV v_second_uv
#else
#define NORMAL_UV v_uv
#endif
#if OCCLUSION_ON_SECOND_UVS
#define OCCLUSION_UV v_second_uv
#else
#define OCCLUSION_UV v_uv
#endif

layout(location = 0) out float o_z_vs;
#if NORMALS_LOCATION
layout(location = NORMALS_LOCATION) out vec4 o_normals_vs;
#endif
#if ALBEDO_LOCATION
layout(location = ALBEDO_LOCATION) out vec4 o_albedo;
#endif
#if EMISSION_LOCATION
layout(location = EMISSION_LOCATION) out vec4 o_emission;
#endif
#if GLOSS_LOCATION
layout(location = GLOSS_LOCATION) out vec4 o_gloss;
#endif
#if FINISH_LOCATION
layout(location = FINISH_LOCATION) out vec2 o_finish;
#endif
#if LIFT_LOCATION
layout(location = LIFT_LOCATION) out float o_lift_vs;

// Lifts below this, relative to the distance from the eye, are what rasterizers round.
const float LIFT_ROUNDING = 4e-5;
#endif

void main()
{
    vec4 albedo = v_albedo;
#if HAS_VERTEX_COLORS
    albedo *= v_color;
#endif
#if HAS_ALBEDO_IMAGE
    albedo *= texture(t_albedo_image, ALBEDO_UV);
#endif
    float z = fragment_z_vs();
    vec2 uv = gl_FragCoord.xy / u_frame_size_px;
    vec3 ray = view_ray_at(uv);
#if HAS_NORMAL_IMAGE
    // Before any pixel of the quad is cut out, while there are differences between them.
    vec3 position_vs = position_vs_at(uv, z);
    vec3 dp_1 = dFdx(position_vs), dp_2 = dFdy(position_vs);
    vec2 duv_1 = dFdx(NORMAL_UV), duv_2 = dFdy(NORMAL_UV);
#endif
#if HAS_ALPHA_CUTOUT
    if (is_left_out(albedo.a, v_emission_side_cutoff.y)) {
        discard;
    }
#endif
    // From the ray through this pixel, not from the winding on screen: right for
    // mirrored instances, and the same for all pixels of a triangle.
    bool is_front = dot(v_face_normal_vs, ray) <= 0.0;
    vec3 face_normal = is_front ? v_face_normal_vs : -v_face_normal_vs;
    vec2 face_code = oct_encode(face_normal);
    vec2 shading_code = face_code;
    vec3 shading_normal = face_normal;
#if HAS_SHADING_NORMALS
    bool is_turned = faces_back(v_normal_vs, v_face_normal_vs);
    vec3 normal = is_turned == is_front ? -v_normal_vs : v_normal_vs;
    // Opposite vertex normals can cancel in between: then the face's own.
    shading_normal = dot(normal, normal) > 0.0 ? normal : face_normal;
    shading_code = dot(normal, normal) > 0.0 ? oct_encode(normal) : face_code;
#endif
#if HAS_NORMAL_IMAGE
    vec4 normal_texel = texture(t_normal_image, NORMAL_UV);
    vec3 mapped = mapped_normal(normal_texel.rgb, v_gloss.z);
    // The map shows the front; seen from behind, all of it is turned.
    shading_normal = normalize(shading_normal);
    TangentFrame tangents = frame_of_steps(shading_normal, dp_1, dp_2, duv_1, duv_2,
                                           is_front ? 1.0 : -1.0);
#if HAS_TANGENTS && HAS_SHADING_NORMALS
    tangents = frame_of_tangent(shading_normal, v_tangent_vs, is_turned == is_front ? -1.0 : 1.0,
                                tangents);
#endif
    shading_normal = bumped_normal(shading_normal, face_normal, tangents, mapped);
    shading_code = oct_encode(shading_normal);
#endif
    vec3 emission = v_emission.rgb;
#if HAS_EMISSION_IMAGE
    emission *= texture(t_emission_image, EMISSION_UV).rgb;
#endif
    bool emits = is_front || v_emission_side_cutoff.x > 0.5;

#if GLOSSY
#if HAS_GLOSS
    float metallic = v_gloss.x;
    float roughness = v_gloss.y;
    vec4 dielectric = v_dielectric;
#if HAS_METALLIC_ROUGHNESS_IMAGE
    vec4 metal = texture(t_metallic_roughness_image, METALLIC_ROUGHNESS_UV);
    metallic *= metal.b;
    roughness *= metal.g;
#endif
#if HAS_SPECULAR_IMAGE
    dielectric.a *= texture(t_specular_image, SPECULAR_UV).a;
#endif
#if HAS_SPECULAR_COLOR_IMAGE
    dielectric.rgb = min(dielectric.rgb * texture(t_specular_color_image, SPECULAR_COLOR_UV).rgb,
                         vec3(1.0));
#endif
    Brdf brdf = metallic_roughness_brdf(albedo.rgb, metallic, roughness,
                                        dielectric.rgb * dielectric.a, dielectric.a);
#if HAS_NORMAL_IMAGE
    brdf.roughness = widened_roughness(brdf.roughness, v_gloss.z * normal_texel.a);
#endif
#else
    Brdf brdf = diffuse_brdf(albedo.rgb);
#endif
    albedo.rgb = brdf.albedo;
#endif

    if (v_emission_side_cutoff.x > 1.5) {
        // Unlit: it shows its own colour, whatever the light.
        emission = albedo.rgb;
        albedo.rgb = vec3(0.0);
    }

    o_z_vs = z;
#if NORMALS_LOCATION
    o_normals_vs = vec4(shading_code, face_code);
#endif
#if ALBEDO_LOCATION
    o_albedo = vec4(albedo.rgb, 1.0);
#endif
#if EMISSION_LOCATION
    o_emission = vec4(emits ? emission : vec3(0.0), v_emission.a);
#endif
#if GLOSS_LOCATION
    o_gloss = vec4(brdf.f0, brdf.roughness);
#endif
#if FINISH_LOCATION
    o_finish = vec2(brdf.f90, 1.0);
#if HAS_OCCLUSION_IMAGE
    o_finish.y += v_gloss.w * (texture(t_occlusion_image, OCCLUSION_UV).r - 1.0);
#endif
#endif
#if LIFT_LOCATION
    o_lift_vs = 0.0;
#if HAS_SHADING_NORMALS
    // How far the planes across the corners' normals lie above the triangle: the mean of
    // n . (corner - p), weighted as the normal is.
    float lift = v_height_vs - dot(position_vs_at(uv, z), v_normal_vs);
    lift = is_turned == is_front ? -lift : lift;
    o_lift_vs = lift > LIFT_ROUNDING * z * length(ray) ? lift : 0.0;
#endif
#endif
    write_depth(z);
}
