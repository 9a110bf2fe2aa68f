// Vertex stage: the place of an instance. All programs that draw the scene share it,
// so that they agree on every position to the last bit.
//
// Positions come relative to the centre of their mesh, matrices relative to the eye
// (subtracted in float64 on the CPU): float32 only ever holds small numbers here.

in vec3 a_position_os;              // relative to the centre of the mesh
in vec4 a_view_from_object_row_0;   // rows of an affine matrix
in vec4 a_view_from_object_row_1;
in vec4 a_view_from_object_row_2;

vec3 instance_position_vs()
{
    vec4 p = vec4(a_position_os, 1.0);
    return vec3(dot(a_view_from_object_row_0, p),
                dot(a_view_from_object_row_1, p),
                dot(a_view_from_object_row_2, p));
}

// Rows of the matrix without its size, by a power of two: squares of what the scale of a model in
// other units, 1e10 or 1e-12, makes of cofactors are no float32.
mat3 instance_rows()
{
    mat3 rows = mat3(a_view_from_object_row_0.xyz, a_view_from_object_row_1.xyz,
                     a_view_from_object_row_2.xyz);
    vec3 most = max(abs(rows[0]), max(abs(rows[1]), abs(rows[2])));
    float size = max(most.x, max(most.y, most.z));
    return size > 0.0 ? rows * exp2(-floor(log2(size))) : rows;
}

// Normals turn with the inverse transpose, here det * it (the cofactors), which exists
// for flattened objects too. The sign of det is taken out again, so that the front of
// a mirrored instance stays the outside of the mesh.
vec3 instance_normal_vs(vec3 normal_os)
{
    mat3 rows = instance_rows();
    vec3 row_0 = rows[0];
    vec3 row_1 = rows[1];
    vec3 row_2 = rows[2];
    vec3 cofactor_0 = cross(row_1, row_2);
    vec3 n = vec3(dot(cofactor_0, normal_os),
                  dot(cross(row_2, row_0), normal_os),
                  dot(cross(row_0, row_1), normal_os));
    float side = dot(row_0, cofactor_0) < 0.0 ? -1.0 : 1.0;
    float size = length(n);
    // Zero only where the transform flattens the triangle to a line: never drawn.
    return size > 0.0 ? n * (side / size) : vec3(0.0, 0.0, 1.0);
}

// Tangents lie in the surface and move with it. A mirror changes their handedness.
vec4 instance_tangent_vs(vec4 tangent_os)
{
    mat3 rows = instance_rows();
    vec3 row_0 = rows[0];
    vec3 row_1 = rows[1];
    vec3 row_2 = rows[2];
    vec3 t = vec3(dot(row_0, tangent_os.xyz), dot(row_1, tangent_os.xyz),
                  dot(row_2, tangent_os.xyz));
    float side = dot(row_0, cross(row_1, row_2)) < 0.0 ? -1.0 : 1.0;
    float size = length(t);
    return vec4(size > 0.0 ? t / size : vec3(0.0), side * tangent_os.w);
}
