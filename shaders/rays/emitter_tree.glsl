// Which of many emitters light comes from: chosen by chance, those that matter most to a point
// the likeliest. A walk down a tree weighs what its nodes can send at most (Conty Estevez, Kulla
// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting").
//
// The tree: ssdo_gl/raytracing/emitter_tree.py.
#include "rays/emitters.glsl"

uniform sampler2D t_glow_nodes;
uniform isampler2D t_glow_order;  // entries of the table of emitters, leaf by leaf
uniform int u_tree_levels;
uniform int u_tree_count;         // of emitters
uniform int u_tree_groups;        // whose: EMITTER_UNLIT and EMITTER_STAND_IN as bits

const int TREE_ROW = 1024;  // texels of both textures, as ssdo_gl/passes/rays/glow_tree.py fills them

ivec2 row_address(int texel)
{
    return ivec2(texel % TREE_ROW, texel / TREE_ROW);
}

// The cosine of the difference of two angles in [0, pi], 1 where the first is the smaller one.
float cosine_of_rest(float cosine, float less_cosine, float less_sine)
{
    float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    return cosine > less_cosine ? 1.0 : cosine * less_cosine + sine * less_sine;
}

// About how much light of a node arrives at `p`; 0 only where none can.
float node_importance(int node, vec3 p, vec3 normal)
{
    ivec2 place = row_address(2 * node);
    vec4 sphere = texelFetch(t_glow_nodes, place, 0);
    vec4 cone = texelFetch(t_glow_nodes, place + ivec2(1, 0), 0);
    float power = length(cone.xyz);
    vec3 to_node = sphere.xyz - p;
    float distance_2 = dot(to_node, to_node);
    float radius_2 = sphere.w * sphere.w;
    vec3 w = to_node * inversesqrt(max(distance_2, 1e-30));
    float sine_2 = radius_2 / max(distance_2, 1e-30);
    bool is_within = sine_2 >= 1.0;
    float sine = sqrt(min(sine_2, 1.0));
    float cosine = sqrt(max(1.0 - sine_2, 0.0));
    float cone_sine = sqrt(max(1.0 - cone.w * cone.w, 0.0));
    float facing = -dot(cone.xyz, w) / max(power, 1e-30);
    float sending = cosine_of_rest(facing, cone.w, cone_sine);
    sending = cosine_of_rest(sending, cosine, sine);
    float receiving = cosine_of_rest(dot(normal, w), cosine, sine);
    float response = is_within ? 1.0 : max(sending, 0.0) * max(receiving, 0.0);
    return power * response / max(distance_2, max(radius_2, 1e-30));
}

// How many emitters the leaves before one have, count * leaf / leaves without overflow.
int tree_emitters_before(int leaf)
{
    int whole = u_tree_count >> u_tree_levels;
    int rest = u_tree_count - (whole << u_tree_levels);
    return whole * leaf + (rest * leaf >> u_tree_levels);
}

// The entry that u in [0, 1) falls on, or -1, and the probability of it.
int draw_from_tree(vec3 p, vec3 normal, inout float u, out float probability)
{
    int node = 0;
    probability = 1.0;
    for (int level = 0; level < u_tree_levels; ++level) {
        float left = node_importance(2 * node + 1, p, normal);
        float right = node_importance(2 * node + 2, p, normal);
        float share = left / max(left + right, 1e-37);
        if (!(left + right > 0.0))
            return -1;
        bool is_left = u < share;
        u = is_left ? u / share : (u - share) / max(1.0 - share, 1e-7);
        u = clamp(u, 0.0, 1.0 - FLOAT_EPSILON);
        probability *= is_left ? share : 1.0 - share;
        node = 2 * node + (is_left ? 1 : 2);
    }
    int leaf = node + 1 - (1 << u_tree_levels);
    // Of a leaf's emitters each is as likely: they lie together.
    int first = tree_emitters_before(leaf);
    int count = tree_emitters_before(leaf + 1) - first;
    probability /= float(max(count, 1));
    int place = first + min(int(u * float(count)), count - 1);
    return count > 0 ? texelFetch(t_glow_order, row_address(place), 0).x : -1;
}

// A point of light as `p` sees it, on a surface with that normal; probabilities are divided out.
LightSample sample_tree(vec3 p, vec3 normal, vec2 choice, vec2 u)
{
    float probability;
    int entry = draw_from_tree(p, normal, choice.x, probability);
    LightSample light = NO_LIGHT;
    if (entry >= 0) {
        light = sample_surface_emitter(emitter_at(entry), entry, u, p);
        light.radiance /= max(probability, 1e-30);
    }
    return light;
}

bool is_in_tree(EmitterGroup group)
{
    return (group.tree & u_tree_groups) != 0;
}
