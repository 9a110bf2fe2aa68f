"""Points on a triangle: uniform over its solid angle, which is exact."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

TRIANGLES = {
    "above": ((-0.5, -0.5, 1.0), (0.8, -0.4, 1.1), (0.0, 0.9, 0.7)),
    "other way round": ((0.0, 0.9, 0.7), (0.8, -0.4, 1.1), (-0.5, -0.5, 1.0)),
    "nearly in contact": ((-0.4, -0.3, 1e-3), (0.9, 0.0, 1e-3), (0.1, 1.1, 1e-3)),
    "edge-on": ((1.0, -0.5, 0.01), (1.0, 0.5, 0.01), (0.2, 0.1, 0.05)),
    "sliver": ((-1.0, 0.0, 0.5), (1.0, 0.02, 0.5), (1.0, -0.02, 0.5)),
}
# Of angles good to 3e-7 relative, of cosines good to 1e-7.
ANGLE_TOLERANCE = 3e-6
FILES = ["lights/spherical_triangle.glsl"]


def exact_solid_angle(corners: np.ndarray) -> float:
    """Girard's theorem: the sum of the inner angles of the outline, less pi."""
    unit = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    angles = []
    for i in range(3):
        a, b, c = np.roll(unit, -i, axis=0)
        planes = np.cross(a, b), np.cross(a, c)
        sine = np.linalg.norm(np.cross(*planes))
        angles.append(np.arctan2(sine, planes[0] @ planes[1]))
    return float(np.sum(angles) - np.pi)


@pytest.mark.parametrize("name", list(TRIANGLES))
def test_solid_angle_is_exact(gl, shaders, name: str) -> None:
    a, b, c = TRIANGLES[name]
    out = evaluate(
        gl,
        shaders,
        FILES,
        "spherical_triangle(a, b, c).solid_angle",
        {"a": [a], "b": [b], "c": [c]},
    )
    exact = exact_solid_angle(np.array(TRIANGLES[name]))
    assert float(out[0, 0]) == pytest.approx(exact, abs=ANGLE_TOLERANCE)


@pytest.mark.parametrize("name", list(TRIANGLES))
def test_directions_share_out_the_solid_angle(gl, shaders, name: str) -> None:
    corners = np.array(TRIANGLES[name])
    side = 128
    g = (np.arange(side) + 0.5) / side
    u = np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)
    numbers = {key: np.tile(v, (len(u), 1)) for key, v in zip("abc", corners, strict=True)}
    w = evaluate(
        gl,
        shaders,
        FILES,
        "spherical_triangle_direction(spherical_triangle(a, b, c), u)",
        {**numbers, "u": u},
        3,
    ).astype(np.float64)
    # Next to a corner a root takes what two squares are short of one.
    np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1.0, atol=1e-5)
    # Weights of the corners at which the direction leaves through the triangle.
    weights = np.linalg.solve(corners.T, w.T).T
    weights /= weights.sum(axis=1, keepdims=True)
    assert weights.min() >= -1e-3
    whole = exact_solid_angle(corners)
    for first in range(3):
        order = [first, (first + 1) % 3, (first + 2) % 3]
        a, b, c = corners[order]
        of_b, of_c = weights[:, order[1]], weights[:, order[2]]
        for share in (0.15, 0.5, 0.8):
            cut = b + share * (c - b)
            expected = exact_solid_angle(np.array([a, b, cut])) / whole
            found = np.mean(of_c < share * (of_b + of_c))
            # Half a row of the grid either way, and as much for the curved outlines.
            assert found == pytest.approx(expected, abs=1.5 / side)
