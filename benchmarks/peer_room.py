"""The room that peers draw, as arrays, and what is asked of a peer."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.mitsuba_scene import compared_scene
from ssdo_gl.raytracing.triangles import scene_triangles
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.scene import Scene

# One lamp below the ceiling and the same light from everywhere: what every peer knows.
LAMP, INTENSITY, SKY = (0.0, 0.8, 0.4), 1.2, 0.5


class NoPeerError(Exception):
    """A peer that cannot be measured here: why, and what would help."""


@dataclass(frozen=True, eq=False)
class Room:
    """One description for all, made from a scene of ours.

    Attributes
    ----------
    scene : Scene
        What we draw.
    positions : ndarray, shape (T, 3, 3)
        Corners of triangles, counter-clockwise seen from the front, world space.
    albedo : ndarray, shape (T, 3)
        Linear, of each triangle.
    size : (width, height)
    radius : float
        Reach of occlusion, scene units.
    near, far : float
        Between them lies all that is seen; peers' depth buffers need them.
    """

    scene: Scene
    positions: NDArray[np.float64]
    albedo: NDArray[np.float64]
    size: tuple[int, int]
    radius: float
    near: float
    far: float


def make_room(size: tuple[int, int], radius: float) -> Room:
    """Return the built-in room with one lamp and a constant sky, all flat and diffuse."""
    scene = compared_scene("cornell_meso")
    lamp = PointLight(LAMP, (INTENSITY,) * 3, shadow="map")
    sky = ConstantEnvironment((SKY,) * 3)
    scene = dataclasses.replace(scene, lights=(lamp,), environment=sky)
    triangles = scene_triangles(scene)
    positions = triangles.positions * triangles.half_diagonal + triangles.centre
    albedo = np.array([material.albedo for material in scene.materials])[triangles.material]
    distance = np.linalg.norm(positions - np.array(scene.camera.position), axis=2)
    return Room(scene, positions, albedo, size, radius, 0.05, 1.05 * float(distance.max()))


@dataclass(frozen=True)
class PeerTimes:
    """Milliseconds of one frame: until it is there, and of all processors."""

    wall_ms: float
    process_ms: float


class Peer(Protocol):
    """Another renderer with the room loaded, warm."""

    variants: Mapping[str, str]  # what is timed, and what it draws beyond one lamp
    device: str  # what OpenGL calls what draws
    notes: Sequence[str]

    def depth(self) -> NDArray[np.float64]:
        """Return distances along the view axis, shape (height, width), row 0 at the top."""

    def visibility(self, variant: str) -> NDArray[np.float64] | None:
        """Return occlusion alone, 1 = open, shape (height, width); None if it has none."""

    def timed(self, variant: str, frames: int) -> PeerTimes:
        """Draw `frames` frames; return means."""

    def close(self) -> None:
        """End it."""
