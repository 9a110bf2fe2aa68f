// Visibility bitmask: Therrien, Levesque and Gilet 2023, "Screen Space Indirect Lighting
// with Visibility Bitmask"; sectors of equal cosine-weighted share, jittered together, after
// Salm 2024 ("GT-VBAO").
//
// What a step meets hides the directions between its front and its back, so that light
// passes behind it; what is nearer to the receiver hides what stands farther along the same
// direction.
//
// Departures. Where a solid ends is read from the back-face layer; one thickness for all
// stands in only where that has nothing. The stretch between front and back ends at R. What
// is hidden must rise above the tangent plane with its front. Slices are spread evenly about
// the view vector and weighed by their share of the hemisphere, all shares together 1; drawn
// by that share, as Salm does, they are less even: noise .028 for .015 (8 slices of 2 x 4
// reads, cornell_meso).
#include "screen_space/sectors.glsl"

#define FINDS_BLOCKERS 0
#define FINDS_SECTORS 1

// The view rays across a walk, in the slice's plane: x along the slice, y along v. The
// one at fraction s of the walk has direction receiver + s * taper * turn, by depth, and
// passes the receiver at s * width * turn, at the receiver's depth z.
struct Lines {
    vec2 receiver;
    vec2 turn;
    float taper;
    float width;
    float z;
};

Lines lines_across(Slice slice, Tangent t, vec3 view, Walk walk)
{
    vec2 end_px = walk_px(walk, 1.0);
    float z = -t.position_vs.z;
    vec3 turn = ray_change(t.position_vs, end_px / u_frame_size_px);
    vec2 taper_width = ray_taper_width(z);
    return Lines(vec2(0.0, -ray_slant(t.position_vs)),
                 vec2(dot(turn, slice.along_vs), dot(turn, view)),
                 taper_width.x, taper_width.y, z);
}

// The point of a line at `depth` behind the receiver.
vec2 point_on(Lines l, float s, float depth)
{
    return (l.width * s + depth * l.taper * s) * l.turn + depth * l.receiver;
}

// Between which depths behind the receiver a line is within R of it.
vec2 depths_within_radius(Lines l, float s)
{
    vec2 ray = l.receiver + s * l.taper * l.turn;
    vec2 beside = l.width * s * l.turn;
    float a = dot(ray, ray);
    float b = dot(ray, beside);
    float root = sqrt(max(b * b - a * (dot(beside, beside) - u_radius * u_radius), 0.0));
    return vec2(-b - root, -b + root) / a;
}

// The directions that the surface met by a step at x hides. A step stands for the stretch
// around it, as in screen_space/march.glsl: its front is taken to reach a part of a stride nearer to
// the receiver, and its back, where that is seen from below, a part of a stride farther.
uint sectors_hidden_at(Sectors s, Tangent t, Lines l, Walk walk, float x, float stride,
                       out ivec2 texel)
{
    float own = walk_fraction(walk, x);
    texel = ivec2(walk_px(walk, own));
    vec2 solid = solid_at(texel);
    vec2 within = depths_within_radius(l, own);
    float front = max(solid.x - l.z, within.x);
    float back = min(min(solid_end(t, solid) - l.z, within.y), FAR_REACH * l.z);
    if (solid.x <= 0.0 || front >= back || !is_above(t, vec2(texel) + 0.5, solid.x))
        return 0u;
    float nearer = walk_fraction(walk, max(x - u_front_slack * stride, 0.0));
    float farther = walk_fraction(walk, x + u_back_slack * stride);
    bool is_seen_from_below = point_on(l, own, back).y > 0.0;
    return sectors_between(s, point_on(l, nearer, front),
                           point_on(l, is_seen_from_below ? farther : own, back));
}

// Slice `i` of DIRECTION_COUNT.
Sectors estimator_sectors(Receiver r, vec3 view, int i)
{
    vec3 along = slice_direction(view, PI * slice_turn(r, i));
    return sectors_of(slice_along(along, view, r.normal_vs), sample_point(r, i).y);
}

// What one of the 32 directions of a slice with weight 1 stands for, of the hemisphere.
float estimator_sector_share(Receiver r, vec3 view)
{
    float all = 0.0;
    for (int i = 0; i < DIRECTION_COUNT; ++i)
        all += sector_weight(estimator_sectors(r, view, i));
    return 1.0 / (SECTOR_COUNT * all);
}

// Which directions of a slice are blocked. Adds to `sent` the radiance that each of them
// receives from what blocks it, if GATHERS_SENDERS: steps go outwards, so that the first to
// hide a direction is the nearest.
uint estimator_hidden(Sectors s, Tangent t, vec3 view, float jitter, inout vec3 sent)
{
    uint hidden = 0u;
#if !IS_OPEN
    float stride = 1.0 / float(STEP_COUNT);
    for (int side = 0; side < 2; ++side) {
        Walk walk = walk_along(t.origin, side == 0 ? s.slice.along_vs : -s.slice.along_vs);
        Lines lines = lines_across(s.slice, t, view, walk);
        float moved = side == 0 ? jitter : fract(jitter + 0.5);
        int i = 0;
        do {
            ivec2 texel;
            float x = (float(i) + moved) * stride;
            uint found = sectors_hidden_at(s, t, lines, walk, x, stride, texel);
#if GATHERS_SENDERS
            float count = float(bit_count(found & ~hidden));
            if (count > 0.0)
                sent += count * share_sent(t.position_vs, texel) * bounded_radiance(texel);
#endif
            hidden |= found;
        } while (++i < STEP_COUNT);
    }
#endif
    return hidden;
}

float estimator_visibility(Receiver r, ivec2 centre)
{
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    vec3 view = toward_camera(r.position_vs);
    float blocked = 0.0;
    vec3 sent = vec3(0.0);
    int i = 0;
    do {
        Sectors s = estimator_sectors(r, view, i);
        uint hidden = estimator_hidden(s, t, view, sample_point(r, i).z, sent);
        blocked += sector_weight(s) * float(bit_count(hidden));
    } while (++i < DIRECTION_COUNT);
    // Not below 0, by rounding, where all are blocked.
    return max(1.0 - blocked * estimator_sector_share(r, view), 0.0);
}

#if GATHERS_SENDERS
// Irradiance from all blockers.
vec3 estimator_gathered(Receiver r, Tangent t)
{
    vec3 view = toward_camera(r.position_vs);
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        Sectors s = estimator_sectors(r, view, i);
        vec3 sent = vec3(0.0);
        estimator_hidden(s, t, view, sample_point(r, i).z, sent);
        sum += sector_weight(s) * sent;
    } while (++i < DIRECTION_COUNT);
    return PI * estimator_sector_share(r, view) * sum;
}
#endif
