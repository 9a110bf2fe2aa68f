"""Points on a rectangle: uniform over its solid angle, which is exact."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

RECTANGLES = {
    "above": ((-0.5, -0.5, -1.0), 1.0, 1.0),
    "aside": ((0.3, -0.2, -0.6), 0.7, 2.0),
    "nearly in contact": ((-0.4, -0.3, -1e-3), 0.9, 1.1),
    "corner": ((1e-6, 1e-6, -0.8), 0.5, 1.5),
    "far": ((2.0, 1.0, -3.0), 1.0, 1.0),
}
# Angles are good to 3e-7 each, and four of them are added.
ANGLE_TOLERANCE = 2e-6


def exact_solid_angle(corner, length_x, length_y) -> float:
    """Sum of arctangents over the four corners (for instance Mathar 2015)."""
    x0, y0, z = corner

    def part(x: float, y: float) -> float:
        return float(np.arctan2(x * y, abs(z) * np.sqrt(x * x + y * y + z * z)))

    x1, y1 = x0 + length_x, y0 + length_y
    return part(x1, y1) - part(x0, y1) - part(x1, y0) + part(x0, y0)


@pytest.mark.parametrize("name", list(RECTANGLES))
def test_solid_angle_is_exact(gl, shaders, name: str) -> None:
    corner, length_x, length_y = RECTANGLES[name]
    out = evaluate(
        gl,
        shaders,
        ["lights/spherical_rectangle.glsl"],
        "spherical_rectangle(corner, size.x, size.y).solid_angle",
        {"corner": [corner], "size": [(length_x, length_y)]},
    )
    exact = exact_solid_angle(corner, length_x, length_y)
    assert float(out[0, 0]) == pytest.approx(exact, abs=ANGLE_TOLERANCE)


@pytest.mark.parametrize("name", list(RECTANGLES))
def test_points_share_out_the_solid_angle(gl, shaders, name: str) -> None:
    corner, length_x, length_y = RECTANGLES[name]
    # A regular grid: any part of the solid angle holds its share of points up to those
    # in the cells that its outline crosses.
    side = 128
    g = (np.arange(side) + 0.5) / side
    u = np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)
    point = evaluate(
        gl,
        shaders,
        ["lights/spherical_rectangle.glsl"],
        "spherical_rectangle_point(spherical_rectangle(corner, size.x, size.y), u)",
        {
            "corner": np.tile(corner, (len(u), 1)),
            "size": np.tile((length_x, length_y), (len(u), 1)),
            "u": u,
        },
        3,
    ).astype(np.float64)
    assert np.all(np.isfinite(point))
    np.testing.assert_allclose(point[:, 2], corner[2], rtol=1e-6)
    place = (point[:, :2] - corner[:2]) / (length_x, length_y)
    assert place.min() >= -1e-6
    assert place.max() <= 1.0 + 1e-6
    whole = exact_solid_angle(corner, length_x, length_y)
    for share in (0.1, 0.35, 0.8):
        for axis in range(2):
            sizes = [length_x, length_y]
            sizes[axis] *= share
            expected = exact_solid_angle(corner, *sizes) / whole
            found = np.mean(place[:, axis] < share)
            # Half a row of the grid either way, and as much for the curved outlines.
            assert found == pytest.approx(expected, abs=1.5 / side)
