#version 330 core
// Where and by how much one image differs from another: blue is too dark, red too bright.
// KIND 0 compares radiance relative to the other's, KIND 1 a visibility as it is.

uniform sampler2D t_image;
uniform sampler2D t_other;        // what is held to be right
uniform sampler2D t_z_vs;
uniform float u_weight;           // 1 / frames summed in t_image
uniform float u_other_weight;
uniform int u_first_channel;
uniform int u_other_first_channel;
uniform float u_exposure_scale;   // 2^EV
uniform float u_range;            // difference at which the colour saturates

in vec2 v_uv;

layout(location = 0) out vec4 o_color;

// Relative to what would be white: below a hundredth of it nobody sees a difference, and
// a relative error there says nothing.
const float DARK = 0.01;

// Rec.709 luminance.
float luminance(vec3 c)
{
    return dot(c, vec3(0.2126, 0.7152, 0.0722));
}

// -1 .. 1 to sRGB, as `error_color` in ssdo_gl/window/canvas/presenter.py: from grey over blue or
// red to a pale tip, so that brightness alone tells the size.
vec3 error_color(float t)
{
    const vec3 neutral = vec3(0.08);
    vec3 middle = t < 0.0 ? vec3(0.10, 0.36, 0.90) : vec3(0.88, 0.24, 0.10);
    vec3 tip = t < 0.0 ? vec3(0.78, 0.93, 1.00) : vec3(1.00, 0.92, 0.62);
    float size = min(abs(t), 1.0);
    return size < 0.5 ? mix(neutral, middle, 2.0 * size) : mix(middle, tip, 2.0 * size - 1.0);
}

void main()
{
    vec4 image = u_weight * texture(t_image, v_uv);
    vec4 other = u_other_weight * texture(t_other, v_uv);
#if KIND == 0
    float is = u_exposure_scale * luminance(image.rgb);
    float right = u_exposure_scale * luminance(other.rgb);
    float difference = (is - right) / (right + DARK);
#else
    float difference = image[u_first_channel] - other[u_other_first_channel];
#endif
    // A comparison that fails for NaN shows it as nothing else looks: magenta.
    bool is_number = abs(difference) < 1e30;
    vec3 shown = is_number ? error_color(difference / u_range) : vec3(1.0, 0.0, 1.0);
    o_color = vec4(texture(t_z_vs, v_uv).r > 0.0 ? shown : vec3(0.0), 1.0);
}
