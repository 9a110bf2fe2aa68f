"""Polygons into triangles: convex, concave, bent, degenerate."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.scene.formats.triangulate import triangulated

CHEVRON = [(-1, -1, 0), (0, -0.3, 0), (1, -1, 0), (0, 1, 0)]
# Half the cross product of the diagonals (1,-1)-(-1,-1) and (0,1)-(0,-0.3).
CHEVRON_AREA = 1.3


def pieces(points: list[tuple[float, ...]]) -> np.ndarray:
    """Return the corners (T, 3, 3) of the triangles of one polygon."""
    positions = np.array(points, dtype=np.float64)
    corners = np.arange(len(points))
    triangles, _ = triangulated(positions, corners, np.array([len(points)]))
    return positions[corners[triangles]]


def vector_areas(triangles: np.ndarray) -> np.ndarray:
    a, b, c = (triangles[:, i] for i in range(3))
    return np.asarray(0.5 * np.cross(b - a, c - a))


def drawn_area(points: list[tuple[float, ...]]) -> float:
    return float(np.linalg.norm(vector_areas(pieces(points)), axis=1).sum())


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("step", [1, -1])
@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e100])
def test_a_chevron_keeps_its_area_and_side(first: int, step: int, scale: float) -> None:
    points = np.roll(CHEVRON, first, axis=0)[::step] * scale
    areas = vector_areas(pieces([tuple(point) for point in points / scale]))
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(CHEVRON_AREA)
    assert np.all(areas[:, 2] * step > 0.0)
    assert len(pieces([tuple(point) for point in points])) == 2


def test_convex_polygons_stay_fans() -> None:
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.0)])
    triangles, polygons = triangulated(square, np.array([0, 1, 2, 3, 0, 1, 2]), np.array([4, 3]))
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6]]
    assert polygons.tolist() == [0, 0, 1]


def test_polygons_keep_their_order_among_others() -> None:
    positions = np.array([*CHEVRON, (5, 0, 0), (6, 0, 0), (5, 1, 0)], dtype=np.float64)
    corners = np.array([4, 5, 6, 0, 1, 2, 3, 6, 5, 4])
    triangles, polygons = triangulated(positions, corners, np.array([3, 4, 3]))
    assert polygons.tolist() == [0, 1, 1, 2]
    assert sorted(set(triangles[1:3].reshape(-1).tolist())) == [3, 4, 5, 6]
    assert triangles[3].tolist() == [7, 8, 9]


def test_points_and_edges_give_nothing() -> None:
    triangles, _ = triangulated(np.eye(3), np.array([0, 1, 2]), np.array([1, 2, 0]))
    assert len(triangles) == 0


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        # An L: the fan around the first corner leaves it.
        ([(0, 2, 0), (0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0)], 3.0),
        # A corner in the middle of an edge, and one that stands twice.
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], 4.0),
        ([(0, 0, 0), (2, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], 4.0),
        ([*CHEVRON, CHEVRON[-1]], CHEVRON_AREA),
        # No area: on a line, in a point.
        ([(0, 0, 0), (1, 0, 0), (3, 0, 0), (2, 0, 0)], 0.0),
        ([(1, 1, 1)] * 5, 0.0),
    ],
)
def test_odd_polygons(points: list[tuple[float, ...]], expected: float) -> None:
    assert drawn_area(points) == pytest.approx(expected)


def test_a_bent_chevron_is_cut_as_seen_from_its_front() -> None:
    bent = [(x, y, 0.2 * x * x) for x, y, _ in CHEVRON]
    assert abs(vector_areas(pieces(bent))[:, 2]).sum() == pytest.approx(CHEVRON_AREA)


def test_not_a_number_and_bow_ties_are_survived() -> None:
    assert len(pieces([(0, 0, 0), (np.nan, 0, 0), (1, 1, 0), (0, 1, 0)])) == 2
    assert np.isfinite(pieces([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)])).all()


def test_a_corner_beyond_the_vertices_is_refused() -> None:
    with pytest.raises(ValueError, match="vertex 3 of 3"):
        triangulated(np.eye(3), np.array([0, 1, 3]), np.array([3]))


def test_polygons_that_cross_themselves_end_in_time() -> None:
    points = np.random.default_rng(1).random((100_000, 3)) * [1, 1, 0]
    start = time.process_time()
    for count in (1_000, 100_000):
        triangulated(points, np.arange(100_000), np.full(100_000 // count, count))
    assert time.process_time() - start < 10.0


@given(
    st.lists(st.floats(0.1, 1.0), min_size=3, max_size=40),
    st.integers(0, 39),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: float(np.linalg.norm(v)) > 0.1),
)
def test_stars_keep_their_area(
    radii: list[float], first: int, normal: tuple[float, float, float]
) -> None:
    angle = np.arange(len(radii)) * 2 * np.pi / len(radii)
    flat = np.stack([radii * np.cos(angle), radii * np.sin(angle)], axis=1)
    expected = 0.5 * np.sum(
        flat[:, 0] * np.roll(flat[:, 1], -1) - flat[:, 1] * np.roll(flat[:, 0], -1)
    )
    z = np.array(normal) / np.linalg.norm(normal)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    points = np.roll(flat @ np.stack([x, np.cross(z, x)]), first, axis=0)
    areas = vector_areas(pieces([tuple(point) for point in points]))
    assert (areas @ z).sum() == pytest.approx(expected, abs=1e-9)
    # Three corners cannot hold the middle: then the outline may turn the other way.
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(abs(expected), abs=1e-7)
