"""Light of per-pixel rays in motion, averaged over pixels that are in the same light."""

from __future__ import annotations

import moderngl

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings, uniforms
from ssdo_gl.passes.own_lookup import SeenSurfaces
from ssdo_gl.passes.own_textures import fill, textures_of
from ssdo_gl.passes.surfels import pieces_of
from ssdo_gl.passes.temporal import versions

# Pixels from one of 3 x 3 taps to the next; the filter of all that is shown closes the gaps. Where
# little is so bright that rays are aimed at it, what others meet by chance is less even.
STEPS, UNEVEN_STEPS = (4,), (1, 2, 4)
# Squared differences of what two pixels are known to receive, in the variance of both, from which
# on they are in other light.
TOLERANCE = 1.0
# Of `lib/edge_aware_filter.glsl`: taps apart, of two images of irradiance, of which the second
# holds depths, negative at contacts, and whose light and its variance are known.
DEFINES = {
    "STAGE": 4,
    "STRIDE": 1,
    "SIGNAL_COUNT": 2,
    "Z_SIGNALS": 2,
    "IS_VISIBILITY": 0,
    "IS_OF_GLOSS": 0,
    "PARTS_EDGES": 1,
    "USE_NORMALS": 1,
    "KNOWS_NOISE": 1,
    "LEAVES_NOISE": 0,
    "HAS_FACTOR": 0,
}
SURFACES = ("z_vs", "normals_vs")


def guide_of(
    context: PassContext,
    light: moderngl.Texture,
    stride: int,
    past: moderngl.Texture,
    most_frames: int,
) -> SeenSurfaces:
    """Return how bright pixels are known to be, by this frame and those before.

    Parameters
    ----------
    light : Texture
        What pixels have gathered, as `effects/moving_rays.frag` writes it.
    stride : int
        Pixels from one that light is gathered at to the next.
    past : Texture
        What the last frame knew of them, as `effects/moving_numbers.frag` writes it.
    most_frames : int
        Averaged at most.
    """
    frame = context.frame
    guide = make_texture(context.gl, frame.view.size, 2, "f4")
    surfaces = make_texture(context.gl, frame.view.size, 4, "f4")
    values = {
        **frame.view.uniforms(),
        "u_receiver_stride": stride,
        "u_most_frames": float(most_frames),
    }
    textures = {**textures_of(context, SURFACES), "t_own_light": light, "t_past": past}
    fill(context, (guide, surfaces), "effects/moving_guide.frag", {}, values, textures)
    return SeenSurfaces(surfaces, guide, frame.view, versions(frame))


def averaged(
    context: PassContext,
    far: moderngl.Texture,
    near: moderngl.Texture,
    guide: moderngl.Texture,
    stride: int,
) -> tuple[moderngl.Texture, moderngl.Texture]:
    """Return light from beyond R and from within, averaged over pixels in the same light.

    The frames before tell what is the same light, not the few rays of this one: what these have
    found by chance would else choose its neighbours, and light that is rare be lost.
    """
    size, settings = context.frame.view.size, EdgeAwareFilterSettings()
    steps = STEPS if pieces_of(context) is None else UNEVEN_STEPS
    for number, step in enumerate(steps):
        made = [make_texture(context.gl, size, 4, "f4") for _ in range(2)]
        textures = {**textures_of(context, SURFACES), "t_light": guide}
        textures |= {"t_value_0": far, "t_value_1": near}
        defines = {**DEFINES, "STEP": step * stride, "IS_FIRST": int(number == 0)}
        values = {
            **uniforms(settings, context.frame),
            "u_depth_tolerance": step * stride * settings.depth_tolerance,
            "u_noise_tolerance": TOLERANCE,
        }
        fill(context, made, "passes/edge_aware_filter.frag", defines, values, textures)
        far, near = made
    return far, near
