// Whether a shading normal belongs to the other side of its triangle.

// Files may hold normals that contradict the winding; they are turned around. One that lies
// in the triangle's plane does not: by the sign alone, rounding would turn it over from
// one pixel to the next. 1e-3 is far above rounding (1e-6, or 3e-5 from 16 bits).
bool faces_back(vec3 shading, vec3 unit_front)
{
    return dot(shading, unit_front) < -1e-3 * length(shading);
}
