"""Where the shadow map of each light looks from, as plain data in float64."""

from __future__ import annotations

import functools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.lights import BoundsOf, Form, Light

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

# Wider atlases than the narrowest one that are tried, and the share of an atlas that may be left
# over without trying another. Of many lights it is less from the first: a thousand take 25 ms to
# place once, and .4 s in all widths.
WIDTHS_TRIED, LEFT_OVER = 8, 0.02


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

    @property
    def side(self) -> int:
        """Return the longer side."""
        return max(self.columns, self.rows)


def atlas_layout(lights: Sequence[Light], unread: Collection[int] = ()) -> AtlasLayout:
    """Return a small layout that keeps each light's faces in one row.

    Lights whose maps are `unread` have none.
    """
    sizes = ((one.face_count * one.tile_span, one.tile_span) for one in lights)
    return _layout(tuple((0, 0) if i in unread else size for i, size in enumerate(sizes)))


# For views at rest and in motion, of a planned frame and a full one.
@functools.lru_cache(maxsize=4)
def _layout(sizes: tuple[tuple[int, int], ...]) -> AtlasLayout:
    area = sum(width * height for width, height in sizes)
    narrowest = max([math.isqrt(max(area, 1) - 1) + 1, *(width for width, _ in sizes)])
    # In one order and one width alone, the others of a light that is left out needed a larger
    # atlas at times, and were drawn coarser.
    given = range(len(sizes))
    by_size = sorted(given, key=lambda i: (-sizes[i][1], -sizes[i][0]))
    best = _placed(sizes, given, narrowest)
    # Tiles are halved until all fit: how often is what their number along a side matters for.
    for order in (given, by_size):
        widest = min(_power_above(best.side), narrowest + WIDTHS_TRIED)
        for columns in range(narrowest, widest + 1):
            if area >= (1.0 - LEFT_OVER) * best.columns * best.rows:
                return best
            best = min(best, _placed(sizes, order, columns), key=_halvings_and_area)
    return best


def _power_above(side: int) -> int:
    return 1 << (side - 1).bit_length()


def _halvings_and_area(layout: AtlasLayout) -> tuple[int, int]:
    return _power_above(layout.side), layout.columns * layout.rows


def _placed(sizes: Sequence[tuple[int, int]], order: Sequence[int], columns: int) -> AtlasLayout:
    """Place rectangles (width, height), one after another, as low as each can lie."""
    tops = [0] * columns  # rows in use in each column
    tiles: list[tuple[int, int] | None] = [None] * len(sizes)
    for index in order:
        width, height = sizes[index]
        if width > 0:
            # The lowest place; the leftmost of several.
            places = [(max(tops[i : i + width]), i) for i in range(columns - width + 1)]
            row, column = min(places)
            tops[column : column + width] = [row + height] * width
            tiles[index] = (column, row)
    return AtlasLayout(columns, max(1, *tops), tuple(tiles))


def shadow_frames(
    lights: Sequence[Light],
    bounds_of: BoundsOf,
    parts_per_side: int = 1,
    unread: Collection[int] = (),
) -> list[ShadowFrame | None]:
    """Return the shadow map of each light, None for those without.

    Parameters
    ----------
    bounds_of : callable
        Returns the corners (low, high) of the scene in the frame of a (3, 3) rotation.
    parts_per_side : int
        Into how many parts with a map each the edges of rectangles are divided.
    unread : collection of int
        Lights whose maps nobody reads: they have none.
    """
    return [
        None if tile is None else _shadow_frame(light, bounds_of, tile, parts_per_side)
        for light, tile in zip(lights, atlas_layout(lights, unread).tiles, strict=True)
    ]


def _shadow_frame(
    light: Light, bounds_of: BoundsOf, tile: tuple[int, int], parts_per_side: int
) -> ShadowFrame:
    view = light.shadow_view(bounds_of, parts_per_side)
    return ShadowFrame(
        view.origin_ws,
        light.light_from_world,
        light.form is Form.PARALLEL,
        view.half_size,
        view.depth,
        light.face_count,
        tile,
        light.tile_span,
        view.parts,
    )
