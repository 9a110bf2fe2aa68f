"""Per-pixel rays while the camera moves: a few in each frame, averaged over frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import moderngl

from ssdo_gl.effects.moving_light import averaged, guide_of
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import Dtype
from ssdo_gl.passes.environment_uniforms import environment_defines, environment_uniforms
from ssdo_gl.passes.far_probes import FarFieldSettings, mean_radiance
from ssdo_gl.passes.own_lookup import SeenSurfaces
from ssdo_gl.passes.own_textures import fill, textures_of
from ssdo_gl.passes.rays import radius_ns, ray_defines, ray_uniforms, stream_of
from ssdo_gl.passes.surfels import bright_reads, opening_uniforms, pieces_of
from ssdo_gl.passes.temporal import is_framed_alike, versions
from ssdo_gl.passes.temporal import uniforms as past_uniforms
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind

# Channels of the light from beyond R and within, and of all together, and whose rays found it.
FORMATS: tuple[tuple[int, Dtype], ...] = ((4, "f4"), (4, "f4"), (2, "f4"))
# How many frames tell how bright pixels are, and where more than the camera moves.
GUIDE_FRAMES, BRIEF_GUIDE_FRAMES = 16, 3


class RayCounts(NamedTuple):
    """How many rays pixels trace."""

    few: int
    at_contacts: int
    at_outlines: int
    where_lost: int  # at most, where the last frame shows little of their surface
    aimed: int  # at bright pieces, and as many at an image of the sky
    is_brief: bool  # few frames are averaged


def ray_counts(settings: FarFieldSettings, *, is_brief: bool) -> RayCounts:
    """Return how many rays pixels trace.

    Parameters
    ----------
    is_brief : bool
        Few frames are averaged: then as many as at contacts at rest, at contacts four times as
        many, and at outlines no more than elsewhere.
    """
    few, many = settings.moving_rays, settings.moving_edge_rays
    lost = settings.moving_lost_rays
    if is_brief:
        # Powers of two, which pixels trace in step. Carousel's temporal error is .332 of the
        # `bounce` of 398b93d; with 9 and 48 it is .347, in .88 of a frame's time.
        few = max(few, settings.pixel_rays, settings.edge_rays)
        most = max(few, many, 4 * settings.edge_rays)
        return RayCounts(few, most, few, lost, settings.aimed_rays, is_brief)
    outline = max(few, settings.moving_outline_rays)
    aimed = -(-settings.aimed_rays // 4)
    return RayCounts(few, max(few, many), outline, lost, aimed, is_brief)


def moving_rays(
    context: PassContext,
    radius: float,
    counts: RayCounts,
    features: RayFeatures,
    environment: EnvironmentKind,
    stride: int,
    reads: tuple[str, ...],
    past: SeenSurfaces | None,
) -> tuple[tuple[moderngl.Texture, ...], SeenSurfaces]:
    """Return `own_far` and `own_near` of a frame, and what it sees.

    Parameters
    ----------
    stride : int
        Pixels from one that light is gathered at to the next.
    reads : tuple of str
        Resources of the surfaces in view, and of all that rays read.
    past : SeenSurfaces or None
        What the last frame has seen.
    """
    frame = context.frame
    made = [make_texture(context.gl, frame.view.size, *form) for form in FORMATS]
    has_past = past is not None and is_framed_alike(past.view, frame.view)
    past = past if has_past else None
    numbers, known = numbers_of_rays(context, radius, counts, stride, past)
    more = {"t_numbers": numbers}
    trace(context, made, radius, counts.aimed, features, environment, stride, reads, more)
    far, near, light = made
    most_frames = BRIEF_GUIDE_FRAMES if counts.is_brief else GUIDE_FRAMES
    seen = guide_of(context, light, stride, known, most_frames)
    far, near = averaged(context, far, near, seen.guide, stride)
    return (far, near), seen


def trace(
    context: PassContext,
    made: Sequence[moderngl.Texture],
    radius: float,
    aimed: int,
    features: RayFeatures,
    environment: EnvironmentKind,
    stride: int,
    reads: Iterable[str],
    textures: Mapping[str, moderngl.Texture],
    many: int | None = None,
) -> None:
    """Trace rays of all pixels, or of those that share none, spread evenly.

    Parameters
    ----------
    aimed : int
        How many more are aimed.
    textures : mapping of str to Texture
        `t_numbers`, or those that hold what pixels share.
    many : int or None
        How many rays have those that share none; None: all have rays of this very frame.
    """
    frame = context.frame
    defines = {
        "SHARES_RAYS": int(many is not None),
        **ray_defines(context, features),
        **environment_defines(environment),
        "BRIGHT_PIECES": int(pieces_of(context) is not None),
    }
    uniforms = {
        **ray_uniforms(context),
        **environment_uniforms(frame),
        "u_radius_ns": radius_ns(radius, context),
        "u_stream": stream_of(frame.pattern, 0),
        "u_sky": mean_radiance(frame.scene.environment),
        "u_receiver_stride": stride,
    }
    defines["OPENINGS"], aims = opening_uniforms(context) if aimed else (0, {})
    uniforms |= aims
    if environment == "map" or aims:
        uniforms["u_sky_rays"] = aimed
    if pieces := pieces_of(context):
        uniforms |= {"u_tree_levels": pieces.tree.levels, "u_aimed_rays": aimed}
    if many is not None:
        uniforms["u_ray_count"] = many
    textures = {**textures_of(context, reads), **bright_reads(context), **textures}
    fill(context, made, "effects/moving_rays.frag", defines, uniforms, textures)


def numbers_of_rays(
    context: PassContext, radius: float, counts: RayCounts, stride: int, past: SeenSurfaces | None
) -> tuple[moderngl.Texture, moderngl.Texture]:
    """Return how many rays each pixel traces, negative at contacts, and what was known of it."""
    frame = context.frame
    numbers = make_texture(context.gl, frame.view.size, 1, "i4")
    known = make_texture(context.gl, frame.view.size, 4, "f4")
    uniforms: dict[str, object] = {
        **frame.view.uniforms(),
        "u_radius": radius,
        "u_receiver_stride": stride,
        "u_few_rays": counts.few,
        "u_many_rays": counts.at_contacts,
        "u_outline_rays": counts.at_outlines,
        "u_lost_rays": counts.where_lost,
    }
    textures = textures_of(context, ("z_vs", "normals_vs"))
    if past is not None:
        is_still = past.versions == versions(frame)
        uniforms |= past_uniforms(frame, past.view, is_still=is_still)
        textures |= {"t_past_surfaces": past.texture, "t_past_guide": past.guide}
    defines = {"HAS_PAST": int(past is not None)}
    fill(context, [numbers, known], "effects/moving_numbers.frag", defines, uniforms, textures)
    return numbers, known
