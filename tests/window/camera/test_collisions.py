"""Walls that stop a flight, and along which it slides."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.window.camera.collisions import MOST_TRIANGLES, Obstacles

KEEP = 0.1


def box_room(size: float = 2.0) -> Scene:
    """A closed cube from -1 to 1, seen from within, out of two meshes and an instance."""
    half = 0.5 * size
    corners = half * np.array(
        [[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    )
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    mesh = Mesh(corners, np.array(triangles))
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    return Scene((mesh,), (), (SceneObject(0, 0),), camera)


@pytest.fixture(scope="module")
def room() -> Obstacles:
    return Obstacles(box_room())


def test_ray_finds_the_wall_and_its_side(room: Obstacles) -> None:
    assert room.hit((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)) == (1.0, (-1.0, 0.0, 0.0))
    distance, normal = room.hit((3.0, 0.1, 0.0), (-1.0, 0.0, 0.0))
    assert distance == pytest.approx(2.0)
    assert normal == pytest.approx((1.0, 0.0, 0.0))
    assert room.hit((3.0, 0.0, 0.0), (1.0, 0.0, 0.0)) is None


def test_free_step_is_not_changed(room: Obstacles) -> None:
    assert room.moved((0.0, 0.0, 0.0), (0.5, 0.2, -0.1), KEEP) == pytest.approx((0.5, 0.2, -0.1))


def test_head_on_step_stops_before_the_wall(room: Obstacles) -> None:
    assert room.moved((0.0, 0.0, 0.0), (5.0, 0.0, 0.0), KEEP) == pytest.approx((0.9, 0.0, 0.0))


def test_slanting_step_slides_along_the_wall(room: Obstacles) -> None:
    end = room.moved((0.5, 0.0, 0.0), (1.5, 0.4, 0.0), KEEP)
    assert end[0] == pytest.approx(0.9)
    assert end[1] == pytest.approx(0.4)


def test_corner_of_three_walls_stops(room: Obstacles) -> None:
    end = room.moved((0.0, 0.0, 0.0), (9.0, 8.0, 7.0), KEEP)
    assert max(end) <= 0.9 + 1e-9
    assert min(end) > 0.5


def test_many_small_steps_never_get_through(room: Obstacles) -> None:
    generator = np.random.default_rng(3)
    position = (0.0, 0.0, 0.0)
    for _ in range(3000):
        step = generator.normal(scale=0.3, size=3)
        position = room.moved(position, tuple(np.add(position, step)), KEEP)
        # One ray is cast, so that a second wall may come nearer than the distance kept.
        assert max(map(abs, position)) < 1.0


def test_who_is_too_near_may_leave_but_not_go_on(room: Obstacles) -> None:
    near = (0.97, 0.0, 0.0)
    assert room.moved(near, (0.5, 0.0, 0.0), KEEP) == pytest.approx((0.5, 0.0, 0.0))
    assert room.moved(near, (2.0, 0.0, 0.0), KEEP)[0] == pytest.approx(0.97)


def test_instances_and_transforms_are_where_they_are_drawn() -> None:
    scene = box_room()
    matrices = np.stack([np.eye(4), np.eye(4)])
    matrices[1, :3, 3] = (10.0, 0.0, 0.0)
    item = dataclasses.replace(scene.objects[0], world_from_object=matrices)
    obstacles = Obstacles(dataclasses.replace(scene, objects=(item,)))
    distance, _ = obstacles.hit((5.0, 0.1, 0.2), (1.0, 0.0, 0.0))
    assert distance == pytest.approx(4.0)


def test_nothing_to_bump_into_stops_nothing() -> None:
    scene = dataclasses.replace(box_room(), objects=())
    obstacles = Obstacles(scene)
    assert obstacles.hit((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)) is None
    assert obstacles.moved((0.0, 0.0, 0.0), (5.0, 0.0, 0.0), KEEP) == (5.0, 0.0, 0.0)


def test_too_many_triangles_are_refused() -> None:
    scene = box_room()
    count = MOST_TRIANGLES // 12 + 1
    matrices = np.broadcast_to(np.eye(4), (count, 4, 4))
    item = dataclasses.replace(scene.objects[0], world_from_object=matrices)
    with pytest.raises(ValueError, match="too many"):
        Obstacles(dataclasses.replace(scene, objects=(item,)))


def test_room_of_the_built_in_scene_holds() -> None:
    scene = load_scene("cornell_meso")
    obstacles = Obstacles(scene)
    end = obstacles.moved((0.0, 0.0, 0.5), (0.0, 0.0, -50.0), KEEP)
    assert end[2] > -1.0
    assert math.isfinite(sum(end))
