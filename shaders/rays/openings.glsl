// Rays aimed at openings through which a room sees the sky: ssdo_gl/raytracing/openings.py.
//
// Rays start at p of a surface with that normal. OPENINGS: how many there are.
#if OPENINGS
uniform vec3 u_openings[3 * OPENINGS];  // of each: a corner, and both edges

// Of a bound on the cosine, so that none is left out whose middle alone is below the horizon.
const float LEAST_FACING_OPENING = 0.05;

// How often rays are to go to each: about by what it sends, if all of it is open.
float weight_of_opening(vec3 p, vec3 n, int i)
{
    vec3 u = u_openings[3 * i + 1], v = u_openings[3 * i + 2];
    vec3 normal = cross(u, v);
    vec3 d = u_openings[3 * i] + 0.5 * (u + v) - p;
    float radius2 = 0.25 * (dot(u, u) + dot(v, v));
    float distance2 = dot(d, d) + radius2;
    float facing = max(dot(d, n) + sqrt(radius2), 0.0) * inversesqrt(distance2);
    float turned = abs(dot(d, normal)) * inversesqrt(distance2);
    return (facing + LEAST_FACING_OPENING) * (turned + LEAST_FACING_OPENING * length(normal)) / distance2;
}

float weight_of_openings(vec3 p, vec3 n)
{
    float sum = 0.0;
    for (int i = 0; i < OPENINGS; ++i)
        sum += weight_of_opening(p, n, i);
    return sum;
}

// The density over solid angle with which a ray aimed at openings goes along w, of that sum.
float density_of_openings(vec3 p, vec3 n, vec3 w, float sum)
{
    float density = 0.0;
    for (int i = 0; i < OPENINGS; ++i) {
        vec3 u = u_openings[3 * i + 1], v = u_openings[3 * i + 2];
        vec3 normal = cross(u, v);
        float square = dot(normal, normal);
        float facing = dot(w, normal);
        vec3 to_corner = u_openings[3 * i] - p;
        float along = dot(to_corner, normal) / (facing == 0.0 ? 1e-30 : facing);
        vec3 d = along * w - to_corner;
        vec2 place = vec2(dot(cross(d, v), normal), dot(cross(u, d), normal)) / square;
        bool is_within = all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(1.0)));
        if (is_within && along > 0.0)
            density += weight_of_opening(p, n, i) * along * along / max(abs(facing), 1e-30);
    }
    return density / max(sum, 1e-30);
}

// The direction of a point of them.
vec3 towards_opening(vec3 p, vec3 n, float choice, vec2 u, float sum)
{
    int chosen = 0;
    choice *= sum;
    for (int i = 0; i < OPENINGS; ++i) {
        chosen = choice > 0.0 ? i : chosen;
        choice -= weight_of_opening(p, n, i);
    }
    return normalize(
        u_openings[3 * chosen] + u.x * u_openings[3 * chosen + 1] + u.y * u_openings[3 * chosen + 2] - p
    );
}
#endif
