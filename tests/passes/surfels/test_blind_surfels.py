"""Surfels lie where light goes from surface to surface, not outside of rooms and within walls.

What sees nothing is found by `passes/surfel_surroundings.frag`.
"""

from __future__ import annotations

import numpy as np
import pytest
from passes.cache_harness import fill

from ssdo_gl.passes.surfels import surfel_rays
from ssdo_gl.passes.surfels.surfel_textures import SurfaceCacheSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.1, 0.0, 0.2), (0.0, 0.0, 0.0))
FEW = SurfaceCacheSettings(surfels=4096, texel=0.08, light_samples=64)
# Half of the room's width, and how thick its walls are.
HALF, WALL = 1.0, 0.1


def room_of_boxes() -> Scene:
    """Return a closed room of six boxes, a lamp in its middle."""
    places = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            place = np.eye(4)
            size = np.full(3, 2.0 * (HALF + WALL))
            size[axis] = WALL
            place[:3, :3] = np.diag(size)
            place[axis, 3] = side * (HALF + 0.5 * WALL)
            places.append(place)
    light = PointLight((0.0, 0.0, 0.0), (5.0, 5.0, 5.0))
    return Scene((box(),), (Material(),), (SceneObject(0, 0, np.array(places)),), CAMERA, (light,))


def test_most_surfels_of_a_room_face_its_inside(device, shaders) -> None:
    filled = fill(device, shaders, room_of_boxes(), SurfaceCacheSettings(texel=0.05))
    # A wall goes on behind the next one.
    inside = np.all(np.abs(filled.positions) < HALF + 0.01, axis=1) & (filled.direct[:, 0] > 0.0)
    # Of all sides of all faces they are a fifth.
    assert inside.mean() > 0.4


@pytest.mark.parametrize("is_turned", [False, True], ids=["backs", "fronts"])
def test_light_is_looked_up_where_it_is_on_coarse_sides(
    device, shaders, monkeypatch, is_turned: bool
) -> None:
    """The other side is dark, and corners are darker than middles."""
    mesh = box()
    mesh = Mesh(mesh.positions, mesh.triangles[:, ::-1]) if is_turned else mesh
    light = PointLight((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    scene = Scene((mesh,), (Material(),), (SceneObject(0, 0),), CAMERA, (light,))
    means = []
    for blind in ([False, False], [is_turned, not is_turned]):
        monkeypatch.setattr(
            surfel_rays,
            "blind_sides",
            lambda _, bvh, *__, blind=blind: np.tile(blind, (bvh.triangles.count, 1)),
        )
        filled = fill(device, shaders, scene, FEW)
        inside = filled.direct[:, 0] > 0.0
        assert np.all(filled.irradiance[~inside] == 0.0)
        means.append(filled.irradiance[inside].mean())
    assert inside.mean() < 0.1
    assert means[1] == pytest.approx(means[0], rel=0.02)
