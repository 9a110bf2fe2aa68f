// Light of surfels added up by quarters of the hemisphere, for lobes: direction times the sum of
// its colours, and that sum.
#if LOBES
layout(location = 1) out vec4 o_quarter_0;
layout(location = 2) out vec4 o_quarter_1;
layout(location = 3) out vec4 o_quarter_2;
layout(location = 4) out vec4 o_quarter_3;

struct QuarterSums {
    vec4 of[4];
};

const QuarterSums EMPTY_QUARTERS = QuarterSums(vec4[](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0)));

void add_to_quarter(inout QuarterSums sums, vec3 normal, vec3 w, vec3 irradiance)
{
    mat3 frame = frame_from_z(normal);
    int quarter = (dot(w, frame[0]) > 0.0 ? 1 : 0) + (dot(w, frame[1]) > 0.0 ? 2 : 0);
    vec4 more = vec4(w, 1.0) * (irradiance.r + irradiance.g + irradiance.b);
    for (int q = 0; q < 4; ++q) {
        sums.of[q] += q == quarter ? more : vec4(0.0);
    }
}

void write_quarters(QuarterSums sums, float scale)
{
    o_quarter_0 = scale * sums.of[0];
    o_quarter_1 = scale * sums.of[1];
    o_quarter_2 = scale * sums.of[2];
    o_quarter_3 = scale * sums.of[3];
}
#endif
