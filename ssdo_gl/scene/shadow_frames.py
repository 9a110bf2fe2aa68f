"""Where the shadow map of each light looks from, as plain data in float64."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.light import DirectionalLight, Light, RectangleLight, SpotLight

# Rows are the axes (u, v, w) of a face in the frame of its light, whose +z is where the
# light shines; w is the axis that depth runs along. Order: +z, +x, -x, +y, -y, -z.
FACE_FROM_LIGHT = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
        [[0, 1, 0], [0, 0, 1], [-1, 0, 0]],
        [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, -1]],
    ],
    dtype=np.float64,
)
# A wider cone in one picture would waste most texels on its rim: at 60 degrees the rim
# has 1/4 of the centre's density, and the five faces of a half cube do better beyond.
WIDEST_SINGLE_FACE = 60.0
# Tangent of half a face's angle for rectangles: the shadow of one receiver is looked up
# in one face, so faces reach into their neighbours by the width of a penumbra.
OVERLAP = 1.25
# Bounds of a scene along a light, grown by this much so that nothing sits on a border.
BOUNDS_MARGIN = 1e-3

BoundsOf = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True, eq=False)
class ShadowFrame:
    """The shadow map of one light, or several maps of the parts of a rectangle.

    Attributes
    ----------
    origin_ws : ndarray, shape (3,)
        Depth 0 of the map; the apex of its pyramids. Of a rectangle: its centre.
    light_from_world : ndarray, shape (3, 3)
        Rotation; +z is where the light shines.
    is_parallel : bool
        Parallel rays (a directional light) instead of rays from the origin.
    half_size : (float, float)
        Half the width and height of a face: tangents, or scene units if parallel.
    depth : float
        Of a parallel map: how far it reaches, scene units; else 0.
    face_count : int
        Faces in use, the first of `FACE_FROM_LIGHT`.
    tile : (int, int)
        Column and row of its first face in the atlas.
    span : int
        Tiles along each side of a face.
    parts : ndarray, shape (P, 3)
        Where the maps of a rectangle's P parts look from, relative to `origin_ws`, world
        space. They divide each tile into as many squares, row by row from the bottom
        left. One zero for all other lights.
    """

    origin_ws: FloatArray
    light_from_world: FloatArray
    is_parallel: bool
    half_size: tuple[float, float]
    depth: float
    face_count: int
    tile: tuple[int, int]
    span: int
    parts: FloatArray

    @property
    def parts_per_side(self) -> int:
        """Return into how many parts each edge of a rectangle is divided."""
        return math.isqrt(len(self.parts))


def face_count(light: Light) -> int:
    """Return how many tiles of the atlas `light` needs; 0 if it has no shadow map."""
    if light.shadow != "map":
        return 0
    if isinstance(light, DirectionalLight):
        return 1
    if isinstance(light, SpotLight):
        return 1 if light.outer_angle <= WIDEST_SINGLE_FACE else 5
    if isinstance(light, RectangleLight):
        return 6 if light.two_sided else 5
    return 6


def tile_span(light: Light) -> int:
    """Return how many tiles a face of `light` is wide and high.

    Only soft shadows, those of rectangles, hide their map's texels. The edges of others are
    as sharp as their map, and a map of one face may spend on that what others spend on six.
    """
    if isinstance(light, RectangleLight):
        return 1
    return 4 if face_count(light) == 1 else 2


@dataclass(frozen=True)
class AtlasLayout:
    """Where the faces of all shadow maps lie, in tiles from the bottom left.

    Attributes
    ----------
    columns, rows : int
        At least 1 each.
    tiles : tuple of (int, int) or None
        For each light column and row of its first face; the others follow to the right.
    """

    columns: int
    rows: int
    tiles: tuple[tuple[int, int] | None, ...]


def atlas_layout(lights: Sequence[Light]) -> AtlasLayout:
    """Return a layout about as wide as high that keeps each light's faces in one row."""
    sizes = [(face_count(light) * tile_span(light), tile_span(light)) for light in lights]
    area = sum(width * height for width, height in sizes)
    columns = max([math.isqrt(max(area, 1) - 1) + 1, *(width for width, _ in sizes)])
    tops = [0] * columns  # rows in use in each column
    tiles: list[tuple[int, int] | None] = []
    for width, height in sizes:
        if width == 0:
            tiles.append(None)
            continue
        # The lowest place; the leftmost of several.
        places = [(max(tops[i : i + width]), i) for i in range(columns - width + 1)]
        row, column = min(places)
        tops[column : column + width] = [row + height] * width
        tiles.append((column, row))
    return AtlasLayout(columns, max(1, *tops), tuple(tiles))


def light_axes(light: Light) -> FloatArray:
    """Return the (3, 3) rotation light_from_world; +z is where the light shines."""
    if isinstance(light, RectangleLight):
        if not np.any(np.cross(light.edge_u, light.edge_v)):
            return np.eye(3)  # No area, no light: any axes will do.
        x = math3d.normalized(light.edge_u)
        z = math3d.normalized(np.cross(x, math3d.normalized(light.edge_v)))
        return np.stack([x, np.cross(z, x), z])
    if isinstance(light, SpotLight | DirectionalLight):
        return math3d.frame_from_z(light.direction).T
    return np.eye(3)


def shadow_frames(
    lights: Sequence[Light], bounds_of: BoundsOf, parts_per_side: int = 1
) -> list[ShadowFrame | None]:
    """Return the shadow map of each light, None for those without.

    Parameters
    ----------
    bounds_of : callable
        Returns the corners (low, high) of the scene in the frame of a (3, 3) rotation.
    parts_per_side : int
        Into how many parts with a map each the edges of rectangles are divided.
    """
    return [
        None if tile is None else _shadow_frame(light, bounds_of, tile, parts_per_side)
        for light, tile in zip(lights, atlas_layout(lights).tiles, strict=True)
    ]


def _shadow_frame(
    light: Light, bounds_of: BoundsOf, tile: tuple[int, int], parts_per_side: int
) -> ShadowFrame:
    axes, count = light_axes(light), face_count(light)
    parts = np.zeros((1, 3))
    if isinstance(light, DirectionalLight):
        low, high = bounds_of(axes)
        # A flat scene has no extent along some axis; any is right that is not zero.
        extent = np.maximum(high - low, BOUNDS_MARGIN * float(np.max(high - low)))
        extent = np.where(extent > 0.0, extent, 1.0) * (1.0 + BOUNDS_MARGIN)
        middle = 0.5 * (low + high)
        origin = np.array([middle[0], middle[1], middle[2] - 0.5 * extent[2]]) @ axes
        half = (0.5 * float(extent[0]), 0.5 * float(extent[1]))
        return ShadowFrame(
            origin, axes, True, half, float(extent[2]), count, tile, tile_span(light), parts
        )
    tangent = 1.0
    if isinstance(light, RectangleLight):
        tangent = OVERLAP
        origin = np.asarray(light.corner) + 0.5 * np.add(light.edge_u, light.edge_v)
        place = (np.arange(parts_per_side) + 0.5) / parts_per_side - 0.5
        v, u = (axis.reshape(-1, 1) for axis in np.meshgrid(place, place, indexing="ij"))
        parts = u * np.asarray(light.edge_u) + v * np.asarray(light.edge_v)
    else:
        origin = np.asarray(light.position, np.float64)
        if isinstance(light, SpotLight) and count == 1:
            tangent = math.tan(math.radians(light.outer_angle))
    return ShadowFrame(
        origin, axes, False, (tangent, tangent), 0.0, count, tile, tile_span(light), parts
    )
