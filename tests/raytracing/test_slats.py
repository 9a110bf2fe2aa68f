"""Lamps behind slats, and slats, are told from those before walls, single bars or far things."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing import slats
from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.slats import lamps_behind, slat_faces, slats_of
from ssdo_gl.raytracing.surfel_patches import patches_of
from ssdo_gl.raytracing.surfel_points import NOTHING_MET, POINT_COUNT
from ssdo_gl.raytracing.surfels import build_surfels
from ssdo_gl.raytracing.triangles import scene_triangles
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.geometry.shapes import box
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# In the plane y = 2, shining down.
LAMP = RectangleLight((0, 2, 0), (1.5, 0, 0), (0, 0, 1), (1, 1, 1))


def behind(
    count: int = 12,
    size: tuple[float, float, float] = (0.01, 0.1, 1.0),
    height: float = 1.8,
    lamp: RectangleLight = LAMP,
) -> frozenset[int]:
    """Return which of a lamp and a point are behind boxes of a size, side by side at a height."""
    places = np.tile(np.diag([*size, 1.0]), (count, 1, 1))
    places[:, :3, 3] = [0.0, height, 0.0]
    places[:, 0, 3] = np.linspace(0.1, 1.4, count)
    unit = box()
    unit = dataclasses.replace(unit, positions=unit.positions - unit.positions.min(axis=0))
    objects = (SceneObject(0, 0, places),)
    camera = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    triangles = scene_triangles(Scene((unit,), (Material(),), objects, camera))
    return lamps_behind(slats_of(triangles), (PointLight((0, 1.9, 0), (1, 1, 1)), lamp))


def test_a_lamp_behind_slats_is_found() -> None:
    assert behind() == {1}


@pytest.mark.parametrize(
    "others",
    [
        {"count": 3},
        {"size": (0.1, 0.1, 0.1)},
        {"size": (0.4, 0.6, 1.0)},
        {"height": 0.2},
        {"height": 2.2},
        {"lamp": RectangleLight((5, 2, 0), (1.5, 0, 0), (0, 0, 1), (1, 1, 1))},
    ],
    ids=["few", "short", "wide", "far", "behind it", "elsewhere"],
)
def test_other_lamps_are_not(others: dict[str, object]) -> None:
    assert not behind(**others)  # type: ignore[arg-type]


def test_what_lies_behind_a_lamp_of_two_sides_counts() -> None:
    assert behind(height=2.2, lamp=dataclasses.replace(LAMP, two_sided=True)) == {1}


def test_triangles_without_a_size_are_no_slats() -> None:
    mesh = box()
    flat = dataclasses.replace(mesh, positions=np.zeros_like(mesh.positions))
    objects = SceneObject(0, 0), SceneObject(1, 0)
    scene = Scene((mesh, flat), (Material(),), objects, Camera((0, 1, 5), (0, 1, 0)))
    found = slats_of(scene_triangles(scene))
    assert np.isfinite(found).all()


def test_slats_are_the_same_however_many_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    places = np.tile(np.diag([0.01, 0.1, 1.0, 1.0]), (7, 1, 1))
    places[:, 0, 3] = np.linspace(0.0, 1.5, 7)
    scene = Scene(
        (box(),), (Material(),), (SceneObject(0, 0, places),), Camera((0, 1, 5), (0, 1, 0))
    )
    triangles = scene_triangles(scene)
    whole = slats_of(triangles)
    monkeypatch.setattr(slats, "CHUNK", 10)
    np.testing.assert_array_equal(slats_of(triangles), whole)
    assert len(whole) == 7 * 12


# One over another, and how far apart.
SLAT, GAP = (1.0, 0.01, 0.1), 0.2


def faces_of_slats(
    size: tuple[float, float, float] = SLAT, distance: float = GAP, share: float = 0.5
) -> np.ndarray:
    """Return the chosen patches of two boxes, a share of whose rays meets the top of one."""
    places = np.tile(np.diag([*size, 1.0]), (2, 1, 1))
    places[1, 1, 3] = GAP
    objects = (SceneObject(0, 0, places),)
    bvh = build_bvh(Scene((box(),), (Material(),), objects, Camera((0, 1, 5), (0, 1, 0))))
    patches = patches_of(bvh)
    top = int(patches.slots[np.argmax(np.abs(patches.normals[:, 1])), 0])
    surfels = build_surfels(bvh, 65535, 0.05)
    met = np.full((surfels.count, POINT_COUNT), NOTHING_MET, dtype=np.int64)
    met[:, : round(share * POINT_COUNT)] = top
    distances = np.full(met.shape, distance / bvh.triangles.half_diagonal)
    is_flat = np.abs(patches.normals[:, 1]) > 0.5
    found = slat_faces(surfels, patches, met, distances)
    assert len(found) == 12
    assert not found[~is_flat].any()
    return found[is_flat]


@pytest.mark.parametrize(("width", "rays"), [(0.1, 8), (0.17, 3)])
def test_faces_between_slats_are_found(width: float, rays: int) -> None:
    assert faces_of_slats((1.0, 0.01, width), share=rays / POINT_COUNT).all()


@pytest.mark.parametrize(
    "others",
    [
        {"size": (1.0, 0.01, 0.3)},
        {"distance": 0.4},
        {"distance": -0.01},
        {"share": 2 / POINT_COUNT},
    ],
    ids=["wide", "far", "from within", "open"],
)
def test_other_faces_are_not(others: dict[str, object]) -> None:
    assert not faces_of_slats(**others).any()  # type: ignore[arg-type]
