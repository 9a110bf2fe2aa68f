"""Rays of surfels start beside what lies flat on them or close before them, not behind it.

What lies there is found by `passes/surfel_surroundings.frag`.
"""

from __future__ import annotations

import numpy as np
import pytest
from passes.cache_harness import fill

from ssdo_gl.passes.surfels.surfel_textures import SurfaceCacheSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.geometry.shapes import parallelogram_matrix, quad
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
# Texels a quarter of a unit wide, or so.
LARGE = SurfaceCacheSettings(surfels=4096, texel=0.2)
# Of the wall's 2 units each way: the picture covers some texels, and others in part.
LOW, HIGH = -0.37, 0.41


def points_on_the_wall(device, shaders, height: float, tilt: float = 0.0) -> np.ndarray:
    """Return the points before a wall, (S, 16, 3), with a picture so high over it."""
    edge = HIGH - LOW
    wall = parallelogram_matrix((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    picture = parallelogram_matrix((LOW, LOW, height), (edge, 0.0, tilt * edge), (0.0, edge, 0.0))
    objects = tuple(SceneObject(0, 0, place[None]) for place in (wall, picture))
    at = fill(device, shaders, Scene((quad(),), (Material(),), objects, CAMERA), LARGE).points
    return at[(np.abs(at[..., 2]) < 1e-3).all(axis=1) & (at[..., 2] > 0.0).all(axis=1)]


def is_behind(at: np.ndarray) -> np.ndarray:
    """Return which points (S, 16, 3) lie behind the picture."""
    return np.asarray(((at[..., :2] > LOW) & (at[..., :2] < HIGH)).all(axis=-1))


def test_points_behind_a_picture_move_beside_it(device, shaders) -> None:
    behind = is_behind(points_on_the_wall(device, shaders, 0.005))
    # What a picture covers all of has nowhere else to start from.
    assert set(behind.mean(axis=1)) == {0.0, 1.0}


@pytest.mark.parametrize(("height", "tilt"), [(0.2, 0.0), (0.005, 0.2)], ids=["far", "tilted"])
def test_points_behind_what_is_far_or_not_flat_stay(device, shaders, height, tilt) -> None:
    at = points_on_the_wall(device, shaders, height, tilt)
    behind = is_behind(at)
    # Along the edge at which the tilted one is near, too.
    at_edge = (behind & (at[..., 0] < LOW + 0.05)).any(axis=1)
    assert np.any(at_edge & ~behind.all(axis=1))
