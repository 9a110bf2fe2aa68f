"""Motion that an object or a light of a scene may carry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray


class Trajectory(Protocol):
    """Where something is at a time, told from where it rests."""

    @property
    def is_rigid(self) -> bool:
        """Whether it moves without a change of size."""

    def world_from_rest(self, seconds: float) -> FloatArray:
        """Return the (4, 4) matrix that moves the resting object to `seconds`."""


@dataclass(frozen=True)
class Motion:
    """A periodic motion, a function of time alone.

    Attributes
    ----------
    spin : tuple of 3 floats
        Rotation about the object's own x, y and z axes through `pivot`,
        degrees per second.
    orbit : tuple of 3 floats
        Rotation about the world axes through `orbit_center`, degrees per second.
    pivot, orbit_center : tuple of 3 floats
        World space, scene units.
    sway : tuple of 3 floats
        Amplitude of a sinusoidal displacement along the world axes, scene units.
    period : float
        Period of the sway in seconds, > 0.
    """

    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orbit: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orbit_center: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sway: tuple[float, float, float] = (0.0, 0.0, 0.0)
    period: float = 4.0
    is_rigid: ClassVar[bool] = True

    def world_from_rest(self, seconds: float) -> FloatArray:
        """Return the (4, 4) matrix that moves the resting object to `seconds`."""
        spin = _about(self.pivot, np.multiply(self.spin, seconds))
        orbit = _about(self.orbit_center, np.multiply(self.orbit, seconds))
        sway = np.multiply(self.sway, np.sin(2.0 * np.pi * seconds / self.period))
        return np.asarray(math3d.translation(sway) @ orbit @ spin)


@dataclass(frozen=True, eq=False)
class Carried:
    """A motion of its own, placed somewhere else, and moved besides.

    Attributes
    ----------
    place : ndarray, shape (4, 4)
        What places the object, with its motion, in the world; has an inverse.
    outer : Trajectory or None
        What moves it there.
    """

    own: Trajectory
    place: FloatArray
    outer: Trajectory | None = None

    @property
    def is_rigid(self) -> bool:
        """Whether its own motion is."""
        return self.own.is_rigid

    def world_from_rest(self, seconds: float) -> FloatArray:
        """Return the (4, 4) matrix that moves the resting object to `seconds`."""
        moved = self.place @ self.own.world_from_rest(seconds) @ np.linalg.inv(self.place)
        return moved if self.outer is None else self.outer.world_from_rest(seconds) @ moved


def _about(center: tuple[float, float, float], degrees: FloatArray) -> FloatArray:
    rotation = math3d.rotation_euler(degrees)
    return np.asarray(
        math3d.translation(center) @ rotation @ math3d.translation(np.negative(center))
    )
