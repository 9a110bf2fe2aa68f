"""A recorded camera path: keys in time, a smooth curve through them, a file. Pure."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ssdo_gl import math3d
from ssdo_gl.math3d import Vector, add, difference, vector
from ssdo_gl.scene.camera import Camera

# Keys recorded per second; what the user does between two of them, the curve restores.
KEYS_PER_SECOND = 10.0
# An hour of flight; a recording that was forgotten must not fill the memory.
MAX_KEYS = 36_000
# A target nearer than this part of the camera's distance from the origin has no direction.
RESOLUTION = 1e-12
FARTHEST = 1e30


@dataclass(frozen=True)
class Key:
    """Where the camera was at a time.

    Attributes
    ----------
    seconds : float
        Since the beginning of the path.
    position, forward : Vector
        World space; `forward` has unit length.
    reach : float
        Distance of the target, scene units.
    fov_y : float
        Degrees.
    height : float or None
        Of what parallel rays show, scene units; None: a pinhole camera.
    """

    seconds: float
    position: Vector
    forward: Vector
    reach: float
    fov_y: float
    height: float | None = None


@dataclass(frozen=True)
class CameraPath:
    """Keys in order of time, the first at 0."""

    keys: tuple[Key, ...] = ()

    @property
    def seconds(self) -> float:
        """How long it takes to fly it."""
        return self.keys[-1].seconds if self.keys else 0.0

    def recorded(self, seconds: float, camera: Camera) -> CameraPath:
        """Return the path with the camera at `seconds`, if a key is due by then."""
        if self.keys and seconds < self.keys[-1].seconds + 1.0 / KEYS_PER_SECOND:
            return self
        if len(self.keys) >= MAX_KEYS:
            return self
        return CameraPath((*self.keys, key_of(seconds, camera)))

    def camera(self, seconds: float, base: Camera) -> Camera:
        """Return the camera at `seconds`, held at either end.

        A cubic through the keys (Catmull and Rom 1974, for uneven times): position and
        direction are continuous with their first derivatives. Up and exposure are those
        of `base`.
        """
        if not self.keys:
            return base
        seconds = min(max(seconds, 0.0), self.seconds)
        i = bisect.bisect_right(self.keys, seconds, key=lambda key: key.seconds) - 1
        i = min(i, max(len(self.keys) - 2, 0))
        # A stretch and the tangents at its ends depend on four keys.
        first = max(i - 1, 0)
        near = self.keys[first : i + 3]
        i -= first
        times = [key.seconds for key in near]
        position = _curve([key.position for key in near], times, i, seconds)
        forward = _curve([key.forward for key in near], times, i, seconds)
        if math.hypot(*forward) < 1e-6:
            # Opposite directions at the two keys cancel half-way between them.
            forward = near[i].forward
        shown = [(key.reach, key.fov_y, key.height or 0.0) for key in near]
        reach, fov_y, height = _curve(shown, times, i, seconds)
        ends = near[i : i + 2]
        # The cubic may overshoot its keys; what must stay positive may not.
        reach = max(reach, min(key.reach for key in ends))
        fov_y = min(max(fov_y, min(k.fov_y for k in ends)), max(k.fov_y for k in ends))
        target = add(position, vector(math3d.normalized(forward)), reach)
        heights = [k.height for k in ends if k.height is not None]
        # Where the kind of camera changes there is nothing in between.
        is_parallel = ends[int(seconds >= ends[-1].seconds and len(ends) > 1)].height is not None
        height = min(max(height, min(heights)), max(heights)) if is_parallel else 0.0
        return replace(base, position=position, target=target, fov_y=fov_y, height=height or None)

    def to_data(self) -> list[list[float]]:
        """Return the keys as plain lists, for a JSON file."""
        return [
            [
                k.seconds,
                *k.position,
                *k.forward,
                k.reach,
                k.fov_y,
                *([k.height] if k.height else []),
            ]
            for k in self.keys
        ]

    @staticmethod
    def from_data(data: object) -> CameraPath:
        """Return the path that `to_data` wrote; raises ValueError if it is none."""
        rows = data if isinstance(data, list) else [None]
        keys = []
        for row in rows:
            numbers = _numbers(row)
            if len(numbers) not in (9, 10) or not all(map(math.isfinite, numbers)):
                raise ValueError("a key of a camera path is nine or ten finite numbers")
            seconds, px, py, pz, dx, dy, dz, reach, fov_y, *height = numbers
            forward = vector(math3d.normalized((dx, dy, dz)))
            keys.append(Key(seconds, (px, py, pz), forward, reach, fov_y, *height))
        times = [key.seconds for key in keys]
        if any(b <= a for a, b in itertools.pairwise(times)):
            raise ValueError("the times of a camera path must increase")
        if not all(_is_sound(key.position, key.reach, key.fov_y, key.height) for key in keys):
            raise ValueError("a camera path has a key without distance or field of view")
        return CameraPath(tuple(keys))


def _numbers(row: object) -> list[float]:
    """Return a row of numbers; an empty one if it is something else."""
    try:
        return [float(n) for n in row] if isinstance(row, list) else []
    except (ValueError, TypeError, OverflowError):
        return []


def key_of(seconds: float, camera: Camera) -> Key:
    """Return the key that says what `camera` sees at `seconds`."""
    offset = difference(camera.target, camera.position)
    forward = vector(math3d.normalized(offset))
    reach = math.hypot(*offset)
    return Key(seconds, vector(camera.position), forward, reach, camera.fov_y, camera.height)


def camera_data(camera: Camera) -> dict[str, Any]:
    """Return a camera as plain data, for a JSON file."""
    return {
        "position": list(camera.position),
        "target": list(camera.target),
        "fov_y": camera.fov_y,
        **({} if camera.height is None else {"height": camera.height}),
    }


def camera_from_data(data: Mapping[str, Any], base: Camera) -> Camera:
    """Return the camera that `camera_data` wrote; raises ValueError if it is none."""
    try:
        position, target = vector(data["position"]), vector(data["target"])
        fov_y = float(data["fov_y"])
        height = float(data["height"]) if "height" in data else None
    except (KeyError, TypeError, ValueError):
        raise ValueError("a camera has position, target and fov_y") from None
    if not _is_sound(position, math.dist(position, target), fov_y, height):
        raise ValueError("a camera has two finite, different points and a field of view")
    return replace(base, position=position, target=target, fov_y=fov_y, height=height)


def _is_sound(position: Vector, reach: float, fov_y: float, height: float | None) -> bool:
    """Whether there is a direction from `position` to a target `reach` away, and an angle.

    Float64 must tell the two points apart, and float32 hold them; NaN fails every comparison.
    """
    far = math.hypot(*position)
    is_seen = 0.0 < fov_y < 180.0 and (height is None or RESOLUTION < height < FARTHEST)
    return RESOLUTION * far < reach < FARTHEST and far < FARTHEST and is_seen


def _curve(values: Sequence[Vector], times: Sequence[float], i: int, seconds: float) -> Vector:
    """Return the cubic between keys `i` and `i` + 1 at `seconds`."""
    if len(values) == 1:
        return values[0]
    span = times[i + 1] - times[i]
    u = (seconds - times[i]) / span
    tangents = [_tangent(values, times, j) for j in (i, i + 1)]
    # Hermite's basis.
    h00, h10 = (1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2
    h01, h11 = u * u * (3 - 2 * u), u * u * (u - 1)
    x, y, z = (
        h00 * p + h01 * q + span * (h10 * a + h11 * b)
        for p, q, a, b in zip(values[i], values[i + 1], *tangents, strict=True)
    )
    return x, y, z


def _tangent(values: Sequence[Vector], times: Sequence[float], i: int) -> Vector:
    """Return the derivative at key `i`, units per second, of the parabola through three keys.

    Plain differences across uneven times would be wrong by half the acceleration times
    the unevenness. At the ends there are two keys, and a straight line.
    """
    slopes = []
    for j in (i - 1, i):
        if 0 <= j < len(values) - 1:
            span = times[j + 1] - times[j]
            slopes.append([d / span for d in difference(values[j + 1], values[j])])
    weight = 0.0
    if len(slopes) == 2:
        # The slope of the shorter stretch is nearer to the key, and counts for more.
        weight = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1])
    x, y, z = (a + weight * (b - a) for a, b in zip(slopes[0], slopes[-1], strict=True))
    return x, y, z
