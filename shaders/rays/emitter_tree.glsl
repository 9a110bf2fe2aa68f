// Which of many emitters light comes from: chosen by chance, those that matter most to a point
// the likeliest. A walk down a tree weighs what its nodes can send at most (Conty Estevez, Kulla
// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting").
//
// The tree: ssdo_gl/raytracing/emitter_tree.py.
#include "rays/emitters.glsl"
#include "lib/random.glsl"

uniform sampler2D t_glow_nodes;
// r: entries of the table of emitters, leaf by leaf; g, b: entry and leaf of each of the tree; a: how
// many are of the leaves up to each
uniform isampler2D t_glow_order;
uniform int u_tree_levels;
uniform int u_tree_count;         // of emitters
uniform int u_tree_groups;        // whose: EMITTER_UNLIT and EMITTER_STAND_IN as bits

const int TREE_ROW = 1023;  // texels of both textures, as ssdo_gl/passes/rays/glow_tree.py fills them

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

// Who asks for light, and what of it counts: all that arrives at a surface, or, where there is a
// lobe, what that reflects to the camera.
struct LitPoint {
    vec3 p;
    vec3 normal;
    vec3 w_out;
    vec3 mirrored;
    float alpha;    // < 0: there is no lobe
};

LitPoint lit_point(vec3 p, vec3 normal)
{
    return LitPoint(p, normal, normal, normal, -1.0);
}

// Which of the directions up to an angle from w reflects the most light, about: the one next to
// the mirrored direction.
float lobe_toward(LitPoint r, vec3 w, float cosine, float sine)
{
    float facing = dot(r.mirrored, w);
    vec3 aside = r.mirrored - facing * w;
    vec3 next = cosine * w + sine * aside * inversesqrt(max(dot(aside, aside), 1e-30));
    next = facing > cosine ? r.mirrored : next;
    vec3 h = normalize(next + r.w_out);
    float cos_h = dot(h, r.normal);
    vec3 sin_h = cross(h, r.normal);
    float a_2 = r.alpha * r.alpha;
    float height = a_2 / (a_2 * cos_h * cos_h + dot(sin_h, sin_h));
    return height * height;
}

// Of a node whose normals enclose less with its axis all look the same way: emitter_tree.py makes
// the cosine that much smaller for rounding.
const float FLAT_COSINE = 1.0 - 1.5e-5;

// About how much light of a node arrives, or is reflected; 0 only where none can be.
float node_importance(int node, LitPoint r)
{
    ivec2 place = row_address(3 * node);
    vec4 middle = texelFetch(t_glow_nodes, place, 0);
    vec4 cone = texelFetch(t_glow_nodes, place + ivec2(1, 0), 0);
    vec4 sends = texelFetch(t_glow_nodes, place + ivec2(2, 0), 0);
    vec3 reach = sends.xyz;
    vec3 to_node = middle.xyz - r.p;
    float distance_2 = dot(to_node, to_node);
    float radius_2 = dot(reach, reach);
    vec3 w = to_node * inversesqrt(max(distance_2, 1e-30));
    float sine_2 = radius_2 / max(distance_2, 1e-30);
    bool is_within = sine_2 >= 1.0;
    float sine = sqrt(min(sine_2, 1.0));
    float cosine = sqrt(max(1.0 - sine_2, 0.0));
    float cone_sine = sqrt(max(1.0 - cone.w * cone.w, 0.0));
    float sending = cosine_of_rest(-dot(cone.xyz, w), cone.w, cone_sine);
    sending = cosine_of_rest(sending, cosine, sine);
    float receiving = cosine_of_rest(dot(r.normal, w), cosine, sine);
    float response = is_within ? 1.0 : max(sending, 0.0) * max(receiving, 0.0);
    if (r.alpha >= 0.0 && !is_within)
        response = receiving > 0.0 ? max(sending, 0.0) * lobe_toward(r, w, cosine, sine) : 0.0;
    // All of the box lies below the horizon, or all that is flat looks away.
    bool is_below = dot(r.normal, to_node) + dot(abs(r.normal), reach) <= 0.0;
    bool is_behind = cone.w > FLAT_COSINE && dot(cone.xyz, to_node) >= dot(abs(cone.xyz), reach);
    // A long strip close by is much nearer than its middle.
    vec3 gap = max(abs(to_node) - reach, 0.0);
    float near_2 = dot(gap, gap) + middle.w;
    float share = inversesqrt(max(near_2 * max(distance_2, radius_2), 1e-30));
    return is_below || is_behind ? 0.0 : sends.w * response * share;
}

// How many emitters the leaves before one have.
int tree_emitters_before(int leaf)
{
    return leaf > 0 ? texelFetch(t_glow_order, row_address(leaf - 1), 0).a : 0;
}

const float UNIT_GAP = 1.0 / 16777216.0;  // between numbers of random_2d

// The entry that two numbers in [0, 1) fall on, or -1, and the probability of it. Each decides half
// of the steps. What a step leaves of a number is spread over [0, 1) again, and with it the gaps
// between floats: they are filled by chance, or what next to no light comes from would be drawn far
// too often.
int draw_from_tree(LitPoint r, vec2 choice, out float probability)
{
    uint bits = floatBitsToUint(choice.x) ^ floatBitsToUint(choice.y);
    float u = choice.x;
    float gap = UNIT_GAP;
    int node = 0;
    probability = 1.0;
    for (int level = 0; level < u_tree_levels; ++level) {
        u = level == u_tree_levels / 2 ? choice.y : u;
        gap = level == u_tree_levels / 2 ? UNIT_GAP : gap;
        float left = node_importance(2 * node + 1, r);
        float right = node_importance(2 * node + 2, r);
        float share = left / max(left + right, 1e-37);
        if (!(left + right > 0.0))
            return -1;
        bool is_left = u < share;
        float taken = (is_left ? left : right) / max(left + right, 1e-37);
        bits = random_hash(bits);
        gap = min(gap / max(taken, 1e-7), 1.0);
        u = (is_left ? u : u - share) / max(taken, 1e-7) + gap * unit_float(bits);
        u = clamp(u, 0.0, 1.0 - FLOAT_EPSILON);
        probability *= taken;
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

// The chance with which that draws an emitter of the leaf.
float chance_of_leaf(LitPoint r, int leaf)
{
    int node = 0;
    float probability = 1.0;
    for (int level = u_tree_levels - 1; level >= 0; --level) {
        float left = node_importance(2 * node + 1, r);
        float right = node_importance(2 * node + 2, r);
        int side = leaf >> level & 1;
        probability *= (side == 0 ? left : right) / max(left + right, 1e-37);
        node = 2 * node + 1 + side;
    }
    int count = tree_emitters_before(leaf + 1) - tree_emitters_before(leaf);
    return probability / float(max(count, 1));
}

// A point of light as the receiver sees it, and the area of the emitter that it is of; probabilities
// are divided out of its radiance.
LightSample sample_tree(LitPoint r, vec2 choice, vec2 u, out float area)
{
    float probability;
    int entry = draw_from_tree(r, choice, probability);
    LightSample light = NO_LIGHT;
    area = 0.0;
    if (entry >= 0) {
        Emitter e = emitter_at(entry);
        area = e.edge_v.w;
        light = sample_surface_emitter(e, entry, u, r.p);
        light.radiance /= max(probability, 1e-30);
        light.density *= probability;
    }
    return light;
}

LightSample sample_tree(LitPoint r, vec2 choice, vec2 u)
{
    float area;
    return sample_tree(r, choice, u, area);
}

// By the cosine of what arrives alone.
LightSample sample_tree(vec3 p, vec3 normal, vec2 choice, vec2 u)
{
    return sample_tree(lit_point(p, normal), choice, u);
}

bool is_in_tree(EmitterGroup group)
{
    return (group.tree & u_tree_groups) != 0;
}
