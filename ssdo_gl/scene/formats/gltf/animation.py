"""Animations of a glTF document: what moves which property of which node."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json
from ssdo_gl.scene.formats.gltf.ranges import Ranges
from ssdo_gl.scene.numbers import LARGEST_NUMBER
from ssdo_gl.settings.fields import shown

# How many numbers a value of a property has; weights have one for each morph target.
_WIDTHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": 0}
# The first is the format's default.
_INTERPOLATIONS = ("LINEAR", "STEP", "CUBICSPLINE")
_DAMAGED = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError)


@dataclass(frozen=True, eq=False)
class Channel:
    """A property of a node over time; it repeats.

    Attributes
    ----------
    times : ndarray, shape (K,)
        Seconds, increasing.
    values : ndarray, shape (K, N), or (K, 3, N) of a cubic spline
        A spline's are incoming tangent, value and outgoing tangent.
    period : float
        Of the whole animation, seconds.
    is_rotation : bool
        Values are quaternions (x, y, z, w).
    """

    times: FloatArray
    values: FloatArray
    interpolation: str
    period: float
    is_rotation: bool

    def at(self, seconds: float) -> FloatArray:
        """Return the value, shape (N,); before the first key it is that of the first."""
        now = seconds % self.period if self.period > 0.0 else 0.0
        row = int(np.searchsorted(self.times, now, side="right")) - 1
        last = len(self.times) - 1
        points = self.values[:, 1] if self.interpolation == "CUBICSPLINE" else self.values
        if row < 0 or row >= last or self.interpolation == "STEP":
            return np.asarray(points[min(max(row, 0), last)])
        span = float(self.times[row + 1] - self.times[row])
        u = (now - float(self.times[row])) / span
        if self.interpolation == "CUBICSPLINE":
            out, into = self.values[row, 2] * span, self.values[row + 1, 0] * span
            return _hermite(points[row], out, points[row + 1], into, u)
        if self.is_rotation:
            return _slerp(points[row], points[row + 1], u)
        return np.asarray((1.0 - u) * points[row] + u * points[row + 1])


Channels = dict[tuple[int, str], Channel]


def read_channels(document: Document, note: Callable[[str], None], ranges: Ranges) -> Channels:
    """Return the channels that are played, by node and property.

    Of several animations the first is played, and with it each later one that moves
    nothing of what is moved already: exporters split what moves together, and list apart
    what a figure can do.

    Parameters
    ----------
    note : callable
        Told in one line of what is not played.
    """
    played: Channels = {}
    left: list[str] = []
    animations = document.json.get("animations", [])
    for index, animation in enumerate(animations if isinstance(animations, list) else []):
        try:
            name = str(animation.get("name") or f"animation {index}")
            found = _channels_of(document, animation, note, ranges)
        except GltfError as error:
            note(f"animation not played: {error}")
            continue
        except _DAMAGED:
            note(f"animation not played: animation {index} is not valid glTF")
            continue
        if found.keys() & played.keys():
            left.append(name)
        else:
            played |= found
    if left:
        note(
            f"animations not played: {', '.join(left[:3])}"
            + (f" and {len(left) - 3} more" if len(left) > 3 else "")
            + ": they move what the first one moves"
        )
    return played


def _channels_of(
    document: Document, animation: Json, note: Callable[[str], None], ranges: Ranges
) -> Channels:
    wanted: list[tuple[tuple[int, str], Json]] = []
    for channel in animation["channels"]:
        target = channel["target"]
        path = target["path"]
        if path not in _WIDTHS:
            note(f"animations of {shown(path)} are not played")
        elif "node" in target:
            document.entry("nodes", target["node"])
            sampler = animation["samplers"][channel["sampler"]]
            wanted.append(((target["node"], path), sampler))
    times = [_times(document, sampler["input"]) for _, sampler in wanted]
    period = max((float(keys[-1]) for keys in times), default=0.0)
    return {
        key: Channel(
            keys,
            _values(document, sampler, key[1], len(keys)),
            ranges.word(sampler, "interpolation", _INTERPOLATIONS, f"node {key[0]}"),
            period,
            key[1] == "rotation",
        )
        for (key, sampler), keys in zip(wanted, times, strict=True)
    }


def _times(document: Document, index: int) -> FloatArray:
    times = document.accessor(index, (1,))[:, 0]
    usable = len(times) and times[0] >= 0.0 and times[-1] <= LARGEST_NUMBER
    if not (usable and np.all(times[1:] > times[:-1])):
        raise GltfError(f"accessor {index}: expected times that increase from 0 on")
    return times


def _values(document: Document, sampler: Json, path: str, count: int) -> FloatArray:
    """Return the values at `count` keys, as `Channel` holds them."""
    index, width = sampler["output"], _WIDTHS[path]
    values = document.accessor(index, (width or 1,))
    parts = 3 if sampler.get("interpolation") == "CUBICSPLINE" else 1
    width = width or len(values) // (count * parts)
    if values.size != count * parts * width or not np.all(np.abs(values) <= LARGEST_NUMBER):
        raise GltfError(f"accessor {index}: expected {count} numbers or vectors for {path}")
    return values.reshape((count, 3, width) if parts == 3 else (count, width))


def _hermite(
    start: FloatArray, out: FloatArray, end: FloatArray, into: FloatArray, u: float
) -> FloatArray:
    """Return the cubic with these ends and tangents, at u in 0..1."""
    u2, u3 = u * u, u * u * u
    return np.asarray(
        (2 * u3 - 3 * u2 + 1) * start
        + (u3 - 2 * u2 + u) * out
        + (3 * u2 - 2 * u3) * end
        + (u3 - u2) * into
    )


def _slerp(start: FloatArray, end: FloatArray, u: float) -> FloatArray:
    """Return the rotation a share `u` of the way along the shorter arc."""
    lengths = float(np.linalg.norm(start) * np.linalg.norm(end))
    cosine = float(start @ end) / lengths if lengths > 0.0 else 1.0
    if cosine < 0.0:
        end, cosine = -end, -cosine
    angle = float(np.arccos(min(cosine, 1.0)))
    # Of nearly equal rotations the arc is its chord, and a division by zero.
    if angle < 1e-6:
        return np.asarray((1.0 - u) * start + u * end)
    return np.asarray((np.sin((1.0 - u) * angle) * start + np.sin(u * angle) * end) / np.sin(angle))
