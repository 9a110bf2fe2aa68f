"""Reads single pixels of what was drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.texture import drawing_into, unpack
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.images.surface_arrays import world_normals
from ssdo_gl.math3d import Vector, vector
from ssdo_gl.render_result import Drawing, Plane

# What the inspector shows beyond the image itself.
INSPECTED = ("normal_ws", "albedo", "visibility", "beauty")


@dataclass(frozen=True)
class Reading:
    """What is at one pixel.

    Attributes
    ----------
    pixel : (int, int)
        Column and row of the rendered image, row 0 at the top.
    depth : float
        Distance from the camera along the view axis, scene units; 0 = background.
    position_ws, normal_ws : Vector or None
        None at the background.
    values : dict of image name to tuple of floats
        Of the last frame, not averaged.
    """

    pixel: tuple[int, int]
    depth: float
    position_ws: Vector | None
    normal_ws: Vector | None
    values: dict[str, tuple[float, ...]]

    @property
    def is_finite(self) -> bool:
        """Whether everything that was read is a plain number."""
        numbers = [self.depth, *(n for group in self.values.values() for n in group)]
        return all(map(math.isfinite, numbers))


def read_texel(gl: moderngl.Context, texture: moderngl.Texture, x: int, y: int) -> list[float]:
    """Return the channels of texel (x, y), y counted from the bottom as OpenGL does."""
    return [float(value) for value in _row(gl, texture, x, y, 1)[0]]


def _row(
    gl: moderngl.Context, texture: moderngl.Texture, x: int, y: int, count: int
) -> NDArray[Any]:
    """Return `count` texels to the right of (x, y), y counted from the bottom."""
    channels, viewport = texture.components, (x, y, count, 1)
    with drawing_into(gl, texture) as target:
        data = target.read(viewport=viewport, components=channels, alignment=1, dtype=texture.dtype)
    row: NDArray[Any] = unpack(data, (1, count, channels), texture.dtype)[0]
    return row


def surface_point(gl: moderngl.Context, drawing: Drawing, uv: tuple[float, float]) -> Vector | None:
    """Return the world-space point under a place of the picture; None at the background.

    Parameters
    ----------
    uv : (float, float)
        0..1 from the top left.
    """
    texture = drawing.planes["depth"].texture
    assert texture is not None, "the G-buffer always has depth"
    x, y = _texel(texture.size, uv)
    z_vs = read_texel(gl, texture, x, y)[0]
    return _position(drawing.view, texture.size, x, y, z_vs)


def clearance(gl: moderngl.Context, drawing: Drawing) -> float | None:
    """Return the distance of the nearest surface around the middle of the picture.

    None if there is only sky. The middle third of one row is enough to notice a wall
    ahead, and one read-back is all that a frame in motion can spare.
    """
    texture = drawing.planes["depth"].texture
    assert texture is not None, "the G-buffer always has depth"
    width, height = texture.size
    count = max(1, width // 3)
    depths = _row(gl, texture, (width - count) // 2, height // 2, count)[:, 0]
    depths = depths[depths > 0.0]
    return float(depths.min()) + drawing.view.depth_offset if depths.size else None


def inspect(gl: moderngl.Context, drawing: Drawing, uv: tuple[float, float]) -> Reading | None:
    """Return what is at a place of the picture, 0..1 from the top left; None outside it."""
    if not (0.0 <= uv[0] < 1.0 and 0.0 <= uv[1] < 1.0):
        return None
    texture = drawing.planes["depth"].texture
    assert texture is not None, "the G-buffer always has depth"
    x, y = _texel(texture.size, uv)
    z_vs = read_texel(gl, texture, x, y)[0]
    normal: Vector | None = None
    encoded = drawing.planes["normal_ws"].texture if "normal_ws" in drawing.planes else None
    if encoded is not None and z_vs > 0.0:
        array = np.array([[read_texel(gl, encoded, x, y)]], np.float32)
        normal = vector(
            world_normals(array, np.full((1, 1, 1), z_vs, np.float32), drawing.view)[0, 0]
        )
    values = {
        name: _channels(gl, plane, name, x, y)
        for name, plane in drawing.planes.items()
        if name not in ("depth", "normal_ws", "display")
    }
    position = _position(drawing.view, texture.size, x, y, z_vs)
    depth = z_vs + drawing.view.depth_offset if z_vs > 0.0 else 0.0
    return Reading((x, texture.height - 1 - y), depth, position, normal, values)


def _texel(size: tuple[int, int], uv: tuple[float, float]) -> tuple[int, int]:
    x = min(max(int(uv[0] * size[0]), 0), size[0] - 1)
    y = min(max(int(uv[1] * size[1]), 0), size[1] - 1)
    return x, size[1] - 1 - y


def _position(view: FrameView, size: tuple[int, int], x: int, y: int, z_vs: float) -> Vector | None:
    """Return the world-space point seen through the centre of a texel, float64."""
    if z_vs <= 0.0:
        return None
    ndc = [
        2.0 * (texel + 0.5) / count - 1.0 + offset
        for texel, count, offset in zip((x, y), size, view.jitter_ndc, strict=True)
    ]
    half_x, half_y = (
        half + tangent * z_vs
        for half, tangent in zip(view.half_frame, view.tan_half_fov, strict=True)
    )
    position_vs = np.array([ndc[0] * half_x, ndc[1] * half_y, -z_vs])
    return vector(position_vs @ view.view_from_world + view.position_ws)


def _channels(gl: moderngl.Context, plane: Plane, name: str, x: int, y: int) -> tuple[float, ...]:
    count = 1 if name == "visibility" else 3
    if plane.texture is None:
        return (plane.neutral,) * count
    first = plane.first_channel
    return tuple(read_texel(gl, plane.texture, x, y)[first : first + count])


def shown_values(values: Sequence[float]) -> str:
    """Return numbers in a form that a person can compare: four digits."""
    return "  ".join(f"{value:.4g}" for value in values)
