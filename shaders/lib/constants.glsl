// Mathematical constants, each rounded to the nearest float32 by the compiler.

const float PI = 3.14159265358979323846;
const float TWO_PI = 6.28318530717958647693;
const float HALF_PI = 1.57079632679489661923;
const float INV_PI = 0.31830988618379067154;
const float INV_TWO_PI = 0.15915494309189533577;

// Distance from 1 to the next float32: the unit for relative tolerances.
const float FLOAT_EPSILON = 1.1920928955078125e-7;

// Largest finite float32.
const float FLOAT_MAX = 3.40282346638528859812e38;
