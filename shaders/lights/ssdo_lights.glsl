// Lights that arrive through SSDO's open directions, as uniforms: they are few, and a
// loop over directions reads them far more often than a texture should be read.
//
// SSDO_AREA_COUNT, SSDO_POINT_COUNT: how many have an area, first of all, and how many not.
#include "lights/lights.glsl"

#define SSDO_LIGHT_COUNT (SSDO_AREA_COUNT + SSDO_POINT_COUNT)

#if SSDO_LIGHT_COUNT > 0
uniform vec4 u_ssdo_lights[SSDO_LIGHT_COUNT * UNSHADOWED_ROWS];

Light ssdo_light(int i)
{
    vec4 rows[UNSHADOWED_ROWS];
    for (int row = 0; row < UNSHADOWED_ROWS; ++row) {
        rows[row] = u_ssdo_lights[i * UNSHADOWED_ROWS + row];
    }
    return light_from_rows(rows);
}
#endif
