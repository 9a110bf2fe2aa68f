"""Temporal accumulation: averages filtered images over frames while view or bodies move."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.far_probes import ProbeRays
from ssdo_gl.passes.own_lookup import GATHERED, OwnRays
from ssdo_gl.settings.fields import setting

TEMPORAL = "temporal"

# How many footprints of a pixel off its plane a surface may have been. With 1 the bottom of a
# groove is taken for its rim, with .1 curved surfaces forget too much; but bodies that move are
# looked for where they are now.
PLANE_TOLERANCE = 0.3
MOVING_TOLERANCE = 1.0


@dataclass(frozen=True)
class TemporalSettings:
    """Settings of what is averaged over frames."""

    # Errors of the bounce over four motions fall up to here; 20 frames change less from one
    # to the next by a twentieth, and lag behind by twice as much.
    frames: int = setting(10, "frames averaged while the camera alone moves", low=1, high=64)
    # The longest that is nowhere worse than single frames beside the bodies of carousel.
    # With half as many rays more where history is poor, averages of 10 to 32 frames err alike, and
    # from 16 on change as little.
    frames_of_rays: int = setting(
        16, "the same where every pixel traces rays of its own", low=1, high=64
    )
    frames_of_moving_bodies: int = setting(
        3, "frames averaged while bodies move, whose shadows lag behind", low=1, high=64
    )

    # Errors of pictures of 64 samples in four motions, with shares of .25, .5 and .75: .96, .93 and
    # .91 of those without; temporal errors .99, .99 and 1.00, the worst of them 1.00, 1.02, 1.03.
    unfiltered: float = setting(
        0.5, "share of light without the filter in averages over frames", low=0.0, high=1.0
    )


@dataclass(frozen=True, eq=False)
class Averages:
    """What the frames until now have left.

    Attributes
    ----------
    made_from : hashable
        What an image must have been made from in order to be averaged with it.
    view : FrameView
        Of the last of them.
    versions : tuple of hashable
        Of bodies, lights and environment in the last of them.
    ends : tuple of hashable
        Of what they cannot be averaged over in the last of them.
    target : Framebuffer
        Over the averages, one for each image, and last the surfaces that they belong to:
        z, frames averaged, and the shading normal.
    spare : Framebuffer or None
        The one before, to be drawn into next.
    rest : ProbeRays or None
        Whose per-pixel rays they show, of a view at rest.
    is_long : bool
        Nothing but the camera has moved, so that nothing in them lags behind.
    """

    made_from: Hashable
    view: FrameView
    versions: tuple[Hashable, ...]
    ends: tuple[Hashable, ...]
    target: moderngl.Framebuffer
    spare: moderngl.Framebuffer | None = None
    rest: ProbeRays | None = None
    is_long: bool = False

    @property
    def textures(self) -> list[moderngl.Texture]:
        """The averages, then the surfaces."""
        found = self.target.color_attachments
        assert isinstance(found, tuple)
        return [item for item in found if isinstance(item, moderngl.Texture)]

    def goes_on_with(self, view: FrameView, ends: tuple[Hashable, ...]) -> bool:
        """Return whether nothing has changed since but where camera, bodies and such lamps are."""
        return is_framed_alike(self.view, view) and self.ends == ends

    def is_still_in(self, frame: Frame) -> bool:
        """Return whether neither bodies nor lights nor environment have changed since."""
        return self.versions == versions(frame)

    def are_of(self, frame: Frame) -> bool:
        """Return whether they show that very frame."""
        return self.view.key() == frame.view.key() and self.is_still_in(frame)


def versions(frame: Frame) -> tuple[Hashable, ...]:
    """Return the versions of bodies, materials, lights and environment."""
    return tuple(map(frame.versions.get, TemporalPass.depends_on[1:-1]))


def is_framed_alike(last: FrameView, view: FrameView) -> bool:
    """Return whether two views have the same size, in pixels and in what they show."""
    sizes = [(v.size, v.tan_half_fov, v.half_frame) for v in (last, view)]
    return sizes[0] == sizes[1]


def uniforms(frame: Frame, last: FrameView, *, is_still: bool) -> dict[str, object]:
    """Return the uniforms of `lib/past_surfaces.glsl`: where `last` saw a point of `frame`.

    Parameters
    ----------
    is_still : bool
        No body has moved since.
    """
    view = frame.view
    turn = last.view_from_world @ view.view_from_world.T
    jitter = np.subtract(view.jitter_ndc, last.jitter_ndc)
    return {
        **view.uniforms(),
        "u_last_from_view": turn,
        "u_last_offset_vs": last.point_vs(view.position_ws),
        "u_jitter_uv": 0.5 * jitter,
        "u_plane_tolerance": PLANE_TOLERANCE if is_still else MOVING_TOLERANCE,
    }


class TemporalPass(RenderPass):
    """Averages images with the history of the same surfaces, found by reprojection.

    A frame that stands still, or whose lights have changed, comes out as it is. But where there
    are per-pixel rays, the last average is shown until all of those at rest are traced, and what
    these show is what the next motion goes on from. Values that are not finite are left out.

    Parameters
    ----------
    images : mapping of str to str
        From the image of one frame to the average, one or two of them.
    made_from : hashable
        Frames are averaged only where this is equal.
    unfiltered : (str, str, float) or None
        The image of one frame that is known without its filter, too; that; and how much of it
        enters an average of many frames.
    lit_by : str
        The domain of lights whose change ends the past: ``lights``, or ``light_sources``, which
        are the same while an animation moves them.
    has_own_rays : bool
        There are per-pixel rays.
    camera_alone : bool
        Frames are averaged only while nothing else moves: the images have sharp shadows.
    """

    depends_on = ("view", "geometry", "materials", "lights", "environment", "seed")
    is_gradual = True

    def __init__(
        self,
        name: str,
        settings: TemporalSettings,
        images: Mapping[str, str],
        made_from: Hashable = None,
        unfiltered: tuple[str, str, float] | None = None,
        lit_by: str = "lights",
        *,
        has_own_rays: bool = False,
        camera_alone: bool = False,
    ) -> None:
        self.name = name
        self.settings = settings
        self.camera_alone = camera_alone
        self.images = dict(images)
        self.made_from = made_from
        self.unfiltered = unfiltered
        self.lit_by = lit_by
        source = () if unfiltered is None else (unfiltered[1],)
        own = GATHERED[1:] if has_own_rays else ()
        self.reads = (*images, *source, "z_vs", "normals_vs", *own)
        self.writes = {result: TextureSpec(4, own=True) for result in images.values()}

    def execute(self, context: PassContext) -> Produced:
        """Average, or hand the images on as they are."""
        frame = context.frame
        current = [context.inputs[name] for name in self.images]
        known = self._known(context, current)
        if frame.moves == 0:
            return self._at_rest(context, current, known)
        most, is_long = 0, False
        if known is not None and known.goes_on_with(frame.view, self._ends(frame)):
            is_long = context.is_complete and known.is_still_in(frame)
            most = self._most_frames(is_long=is_long)
        made = self._draw(context, current, known, most, is_long=is_long)
        return self._made(made.textures[:-1], made)

    def _most_frames(self, *, is_long: bool) -> int:
        """Return how many frames are averaged; `is_long` where the camera alone moves."""
        chosen = self.settings
        if not is_long:
            return 0 if self.camera_alone else chosen.frames_of_moving_bodies
        return chosen.frames_of_rays if GATHERED[1] in self.reads else chosen.frames

    def _at_rest(
        self, context: PassContext, current: list[moderngl.Texture], known: Averages | None
    ) -> Produced:
        """Hand the images on, or the last average while per-pixel rays are being traced."""
        frame, rays = context.frame, context.facts.get(GATHERED[1])
        if not isinstance(rays, OwnRays):
            return self._made(current, known)
        if rays.is_known and (known is None or known.rest is not rays.source):
            # As many rays as so many frames in motion have.
            drawn = self._draw(context, current, known, 0, float(self.settings.frames))
            known = replace(drawn, rest=rays.source, is_long=True)
        if rays.is_known or known is None or not known.is_long or not known.are_of(frame):
            return self._made(current, known)
        return self._made(known.textures[:-1], known)

    def _known(self, context: PassContext, current: list[moderngl.Texture]) -> Averages | None:
        """Return what earlier frames have left of such images."""
        last = context.last.get(next(iter(self.writes)))
        known = None if last is None else last.facts
        if not isinstance(known, Averages) or known.made_from != self.made_from:
            return None
        have = [(item.size, item.components) for item in known.textures[:-1]]
        return known if have == [(item.size, item.components) for item in current] else None

    def _made(self, textures: list[moderngl.Texture], averages: Averages | None) -> Produced:
        return {
            name: TextureWithFacts(texture, averages)
            for name, texture in zip(self.writes, textures, strict=True)
        }

    def _draw(
        self,
        context: PassContext,
        current: list[moderngl.Texture],
        known: Averages | None,
        most_frames: int,
        frames: float = 1.0,
        *,
        is_long: bool = False,
    ) -> Averages:
        """Return the averages with this frame; without a past, it counts for `frames`."""
        frame = context.frame
        target = None if known is None else known.spare
        if target is None:
            shapes = [(item.size, item.components) for item in current]
            shapes.append((frame.view.size, 4))
            target = make_framebuffer(
                context.gl, [make_texture(context.gl, *shape, "f4") for shape in shapes]
            )
        is_averaged = known is not None and most_frames > 0
        textures = {f"t_value_{i}": item for i, item in enumerate(current)}
        textures |= {f"t_{name}": context.inputs[name] for name in ("z_vs", "normals_vs")}
        values = {**frame.view.uniforms(), "u_frames": frames}
        if is_averaged:
            assert known is not None
            *past, surfaces = known.textures
            textures |= {f"t_past_{i}": item for i, item in enumerate(past)}
            textures["t_past_surfaces"] = surfaces
            values = uniforms(frame, known.view, is_still=known.is_still_in(frame))
            values["u_most_frames"] = float(most_frames)
            if GATHERED[1] in self.reads:
                textures[f"t_{GATHERED[1]}"] = context.inputs[GATHERED[1]]
        defines = {
            "IMAGE_COUNT": len(current),
            "HAS_PAST": int(is_averaged),
            "UNFILTERED": 0,
            "HAS_CONTACTS": int(f"t_{GATHERED[1]}" in textures),
        }
        if is_averaged and self.unfiltered is not None:
            image, source, share = self.unfiltered
            defines["UNFILTERED"] = 1 + [*self.images].index(image)
            textures["t_unfiltered"] = context.inputs[source]
            values = {**values, "u_unfiltered_share": share}
        program = context.shaders.fullscreen("passes/temporal.frag", defines)
        draw_fullscreen(context.gl, program, target, values, textures)
        spare = None if known is None else known.target
        ends = self._ends(frame)
        return Averages(
            *(self.made_from, frame.view, versions(frame), ends, target, spare), is_long=is_long
        )

    def _ends(self, frame: Frame) -> tuple[Hashable, ...]:
        """Return the versions of what frames are not averaged over."""
        return tuple(map(frame.versions.get, ("materials", "environment", self.lit_by)))
