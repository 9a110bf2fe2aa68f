"""Scenes in which bodies move: hierarchies as good as any, whatever was built before."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hierarchy_walk import check_hierarchy
from meshes import soup

from ssdo_gl.raytracing import moving_bodies
from ssdo_gl.raytracing.bvh import Bvh, build_bvh, build_from_triangles
from ssdo_gl.raytracing.split import half_area
from ssdo_gl.raytracing.triangles import scene_triangles
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, sphere
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 9.0), (0.0, 0.0, 0.0))
TIMES = (0.0, 0.4, 3.0)


def placed(*shift: float, mirrored: bool = False) -> np.ndarray:
    matrix = np.diag([-1.0 if mirrored else 1.0, 1.0, 1.0, 1.0])
    matrix[:3, 3] = shift
    return matrix


def scene(has_still: bool = True) -> Scene:
    """Return a turning ball, three swaying boxes of which one is mirrored, and two that stand."""
    three = np.stack([placed(-2, 0, 0), placed(-3, 2, 0, mirrored=True), placed(-4, 0, 0)])
    moving = (
        SceneObject(0, 0, placed(2, 0, 0)[None], motion=Motion(orbit=(0, 90, 0))),
        SceneObject(1, 0, three, motion=Motion(sway=(1, 1, 0))),
    )
    still = (SceneObject(2, 0, placed(0, -3, 0)[None]), SceneObject(1, 0, placed(0, 3, 0)[None]))
    objects = (still[0], *moving, still[1]) if has_still else moving
    return Scene((sphere(8), box(), soup(300)), (Material(),), objects, CAMERA)


@pytest.fixture(autouse=True)
def nothing_is_kept():
    moving_bodies._kept.clear()


def on_ground() -> Scene:
    """Return bodies that all move, as of an animated model, over a floor that was laid."""
    ground = SceneObject(0, 0, placed(0, -9, 0)[None], is_ground=True)
    moving = scene(has_still=False)
    return dataclasses.replace(moving, objects=(*moving.objects, ground))


@pytest.mark.parametrize("make", [scene, lambda: scene(has_still=False), on_ground])
def test_boxes_hold_their_children_and_every_triangle_is_there_once(make):
    for seconds in TIMES:
        now = scene_at(make(), seconds)
        check_hierarchy(build_bvh(now), scene_triangles(now).count)


def test_it_depends_on_the_scene_alone():
    first, *_, last = (scene_at(scene(), seconds) for seconds in TIMES)
    alone = build_bvh(last)
    moving_bodies._kept.clear()
    build_bvh(first)
    after = build_bvh(last)
    np.testing.assert_array_equal(after.records(), alone.records())
    for name in ("primitive_triangles", "primitive_corners", "node_records"):
        np.testing.assert_array_equal(getattr(after, name), getattr(alone, name))


def test_bodies_are_split_once(monkeypatch):
    counts: list[int] = []
    original = moving_bodies.build_binary

    def counted(low, high, *report):
        counts.append(len(low))
        return original(low, high, *report)

    monkeypatch.setattr(moving_bodies, "build_binary", counted)
    build_bvh(scene_at(scene(), 0.0))
    # What stands, a ball, boxes and their mirror images, and what is above all five.
    assert len(counts) == 5
    for seconds in TIMES[1:]:
        counts.clear()
        build_bvh(scene_at(scene(), seconds))
        assert counts == [5]


def test_a_triangle_that_has_area_in_one_place_alone_is_no_fault():
    """A sliver at the edge of its body, where float32 is coarse, and in the middle of the scene."""
    far = 1e6
    corners = [[far, 0, 0], [far + 0.01, 0, 0], [far, 1, 0], [-far, 0, 0], [-far, 1, 0]]
    mesh = Mesh(np.array(corners), np.array([[0, 1, 2], [0, 3, 4]]))
    objects = (
        SceneObject(0, 0, motion=Motion(sway=(1, 0, 0))),
        SceneObject(1, 0, placed(3 * far, 0, 0)[None]),
    )
    sliver = Scene((mesh, box()), (Material(),), objects, CAMERA)
    alone = dataclasses.replace(sliver, objects=objects[:1])
    assert scene_triangles(alone).count == 1
    assert scene_triangles(sliver).count == 2 + len(box().triangles)
    check_hierarchy(build_bvh(sliver), 2 + len(box().triangles))


def cost(bvh: Bvh) -> float:
    """Return the summed surface of the nodes' boxes: how many a random ray opens, about."""
    words = bvh.records()[bvh.node_records]
    step = np.exp2((words[:, 3:4] >> np.array([0, 8, 16], np.uint32) & 255) - 127.0)
    sides = [words[:, 4 + 3 * end : 7 + 3 * end] for end in (0, 1)]
    children = words[:, 3] >> 28
    low, high = (
        np.stack([side >> np.uint32(8 * child) & 255 for child in range(4)], axis=1)
        for side in sides
    )
    is_child = np.arange(4) < children[:, None]
    area = half_area(low * step[:, None], high * step[:, None])
    return float(area[is_child].sum())


def test_trees_are_as_good_as_of_all_triangles_at_once():
    carousel = load_scene("carousel")
    for seconds in TIMES:
        now = scene_at(carousel, seconds)
        of_all = build_from_triangles(scene_triangles(now))
        assert cost(build_bvh(now)) < 1.15 * cost(of_all)


def test_scenes_in_which_nothing_moves_have_one_tree():
    still = dataclasses.replace(
        scene(), objects=tuple(dataclasses.replace(i, motion=None) for i in scene().objects)
    )
    found, wanted = build_bvh(still), build_from_triangles(scene_triangles(still))
    np.testing.assert_array_equal(found.records(), wanted.records())
