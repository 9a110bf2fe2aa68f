"""What a frame is rendered from: the view, the scene at a time, the seed."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Region
from ssdo_gl.scene.scene import Scene

# Up to this far / near the hyperbolic depth resolves 1e-6 of z at the far plane, as the
# logarithmic one does at any ratio. That one gives up the early depth test of GPUs, yet
# costs nothing that can be measured on llvmpipe.
HYPERBOLIC_DEPTH_RATIO = 16.0
# The far plane lies this many times as far as the farthest bound. Clip space ends at
# z / w = 1, which a surface at the bound then misses by 2 near / far (1 - 1 / 4): 1.5e-6 at
# least, a dozen roundings of float32. With the plane at the bound, rounding alone would
# cut surfaces off.
FAR_PLANE_FACTOR = 4.0


def far_plane(far: float) -> float:
    """Return where to put the far plane so that nothing up to `far` is clipped."""
    return far * FAR_PLANE_FACTOR


def wide_depth_range(near: float, far: float) -> int:
    """Return the define ``WIDE_DEPTH_RANGE`` for clip distances `near` and `far`."""
    return int(far > HYPERBOLIC_DEPTH_RATIO * near)


def depth_uniforms(near: float, far: float) -> dict[str, object]:
    """Return the uniforms of ``lib/depth_test.glsl``."""
    if not wide_depth_range(near, far):
        return {}
    scale = 1.0 / math.log2(far / near)
    return {"u_log_depth": (scale, -math.log2(near) * scale)}


# Share of the frame that may be drawn twice for what surfaces there emit.
LARGEST_PART = 0.1
_CHOICES: Mapping[bool, Mapping[str, str]] = {
    is_orthographic: {"projection": f"projections/{name}.glsl"}
    for is_orthographic, name in ((True, "orthographic"), (False, "perspective"))
}


@lru_cache(maxsize=256)
def _perspective_uniforms(
    size: tuple[int, int], jitter_ndc: tuple[float, float], tan_half_fov: tuple[float, float]
) -> Mapping[str, object]:
    """Return `FrameView.uniforms`; those of a flight are the very same for all of its views."""
    return {
        "u_jitter_ndc": jitter_ndc,
        "u_frame_size_px": tuple(float(n) for n in size),
        "u_tan_half_fov": tan_half_fov,
    }


@dataclass(frozen=True, eq=False)
class FrameView:
    """The camera of one frame, float64, OpenGL view space (looks along -z).

    Views do not change, nor do their arrays: what follows from them is worked out once.

    Attributes
    ----------
    size : (int, int)
        Width and height in pixels.
    position_ws : ndarray, shape (3,)
    view_from_world : ndarray, shape (3, 3)
        Rotation only: world transforms are first made relative to `position_ws`.
    tan_half_fov : (float, float)
        Horizontal and vertical; 0 if rays are parallel.
    near, far : float
        Clip distances along the view axis, scene units.
    jitter_px : (float, float)
        Sub-pixel shift of the sample position from the pixel centre, pixels.
    half_frame : (float, float)
        Half of what the frame of parallel rays shows, scene units; else 0.
    depth_offset : float
        What to add to depths from `position_ws` for those from the camera. Where along
        its rays the eye of a parallel view stands is free: it is put a frame's height
        before what is nearest, so that no precision is lost on the way there.
    """

    size: tuple[int, int]
    position_ws: FloatArray
    view_from_world: FloatArray
    tan_half_fov: tuple[float, float]
    near: float
    far: float
    jitter_px: tuple[float, float] = (0.0, 0.0)
    half_frame: tuple[float, float] = (0.0, 0.0)
    depth_offset: float = 0.0

    @property
    def is_orthographic(self) -> bool:
        """Whether rays are parallel."""
        return self.half_frame[1] > 0.0

    @property
    def choices(self) -> Mapping[str, str]:
        """The files behind includes of shaders that look through this view."""
        return _CHOICES[self.is_orthographic]

    @property
    def jitter_ndc(self) -> tuple[float, float]:
        """The jitter in normalised device coordinates (2 across the frame)."""
        return 2.0 * self.jitter_px[0] / self.size[0], 2.0 * self.jitter_px[1] / self.size[1]

    @cached_property
    def clip_from_view(self) -> FloatArray:
        """The (4, 4) projection, jitter included; read-only."""
        # A ray through ndc + jitter must land on the pixel centre at ndc: jitter * w is
        # subtracted, where w is -z or 1.
        if self.is_orthographic:
            matrix = math3d.orthographic(self.half_frame, self.near, self.far)
            matrix[:2, 3] -= self.jitter_ndc
        else:
            matrix = math3d.perspective(self.tan_half_fov, self.near, far_plane(self.far))
            matrix[:2, 2] += self.jitter_ndc
        return math3d.read_only(matrix)

    @cached_property
    def world_from_view(self) -> FloatArray:
        """The (3, 3) rotation back to the world; read-only."""
        return math3d.read_only(self.view_from_world.T)

    def uniforms(self) -> Mapping[str, object]:
        """Return the uniforms that `shaders/lib/space.glsl` declares."""
        return self._uniforms

    @cached_property
    def _uniforms(self) -> Mapping[str, object]:
        if not self.is_orthographic:
            return _perspective_uniforms(self.size, self.jitter_ndc, self.tan_half_fov)
        return {
            "u_jitter_ndc": self.jitter_ndc,
            "u_frame_size_px": tuple(float(n) for n in self.size),
            "u_half_frame_vs": self.half_frame,
            "u_near_depth_vs": (self.near, self.far - self.near),
        }

    def depth_defines(self) -> Mapping[str, int]:
        """Return the defines of `shaders/lib/depth_test.glsl`."""
        return self._depth[0]

    def depth_uniforms(self) -> Mapping[str, object]:
        """Return the uniforms of `shaders/lib/depth_test.glsl`."""
        return self._depth[1]

    @cached_property
    def _depth(self) -> tuple[Mapping[str, int], Mapping[str, object]]:
        # The depth of parallel rays is linear, and as fine everywhere.
        if self.is_orthographic:
            return {"WIDE_DEPTH_RANGE": 0}, {}
        is_wide = wide_depth_range(self.near, self.far)
        return {"WIDE_DEPTH_RANGE": is_wide}, depth_uniforms(self.near, self.far)

    def raster_uniforms(self) -> Mapping[str, object]:
        """Return the uniforms of `shaders/rasterizer/triangle.glsl`."""
        return {
            **self._uniforms,
            "u_clip_from_view": self.clip_from_view,
            "u_unit": 1.0 / self.far,
            "u_near_vs": self.near,
        }

    def key(self) -> Hashable:
        """Return a value that is equal exactly when the view is the same."""
        return self._key

    @cached_property
    def _key(self) -> Hashable:
        return (
            self.size,
            self.position_ws.tobytes(),
            self.view_from_world.tobytes(),
            self.tan_half_fov,
            self.half_frame,
            self.near,
            self.far,
            self.jitter_px,
        )

    def jittered(self, jitter_px: tuple[float, float]) -> FrameView:
        """Return the view with its samples shifted."""
        return FrameView(
            self.size,
            self.position_ws,
            self.view_from_world,
            self.tan_half_fov,
            self.near,
            self.far,
            jitter_px,
            self.half_frame,
            self.depth_offset,
        )

    def point_vs(self, point_ws: FloatArray) -> FloatArray:
        """Return world-space points (..., 3) in view space."""
        return np.asarray((np.asarray(point_ws) - self.position_ws) @ self.view_from_world.T)


@dataclass(frozen=True, eq=False)
class Frame:
    """Everything that a pass may depend on besides the textures it reads.

    Attributes
    ----------
    scene : Scene
        As it stands at this frame's time.
    seed : int
        Selects the sample pattern, >= 0.
    versions : mapping
        For each domain a pass can name in ``depends_on`` (``view``, ``geometry``,
        ``materials``: how they shade what they cover, ``lights``, ``environment``,
        ``seed``), a value that changes exactly when that part of the input changes.
        ``light_sources`` stays the same while an animation moves the lights.
        ``steady_view`` and ``steady_seed`` are the same for all frames of one view that
        differ in their jitter alone.
    is_live : bool
        A frame of a window: passes that are gradual may do part of their work, starting
        from what they left last time. All other frames depend on nothing but their input.
    first_seed, count : int
        Seed of the first frame of this view, and of how many frames its picture is the mean.
    moves : int
        Of a live frame that may be averaged with those before it, its number among them:
        camera or bodies have moved since the last one, lights have not, but for those of `gi` that
        an animation moves. 0: it is to be as a single frame is.
    view_moves : int
        Of these frames, how many the camera has moved in.
    gloss_region : Region or None
        Outside it no surface in view is glossy. None: nothing is known of that.
    emission_region : Region or None
        The same of surfaces that show light of their own.
    """

    view: FrameView
    scene: Scene
    seed: int = 0
    versions: Mapping[str, Hashable] = field(default_factory=dict)
    is_live: bool = False
    first_seed: int = 0
    count: int = 1
    moves: int = 0
    view_moves: int = 0
    gloss_region: Region | None = None
    emission_region: Region | None = None

    @property
    def pattern(self) -> int:
        """What chooses the sample points of that which is averaged over frames.

        The same ones while the camera stands, so that what noise is left does not change.
        """
        return self.seed + (self.view_moves << 32 if self.moves else 0)

    @property
    def emitting_part(self) -> Region:
        """The part of the frame to which emission is worth keeping: little of it, or all."""
        width, height = self.view.size
        x, y, w, h = self.emission_region or (0, 0, width, height)
        is_little = w * h <= LARGEST_PART * width * height
        return (x, y, w, h) if is_little else (0, 0, width, height)

    def coverage_uniforms(self) -> dict[str, object]:
        """Return the uniforms of `lib/coverage.glsl`: what is translucent is drawn by chance."""
        number = (self.seed - self.first_seed) % self.count
        return {"u_frame_of_picture": (number, self.count, self.first_seed & 0xFFFFFFFF)}
