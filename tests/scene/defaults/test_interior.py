"""A place and a light in closed rooms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults import frame, room_around
from ssdo_gl.scene.defaults.framing import closed_room, wall_sides
from ssdo_gl.scene.formats import read_description
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces, shapes
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.load import load_scene

BOX = shapes.box()
INSIDE_OUT = Mesh(BOX.positions, BOX.triangles[:, ::-1])
MESHES = [BOX, INSIDE_OUT]
SIZE = np.array([5.0, 2.6, 4.0])


def placed(low: tuple[float, ...], high: tuple[float, ...], mesh: int = 0) -> SceneObject:
    ends = BOX.positions.min(axis=0), BOX.positions.max(axis=0)
    size = np.subtract(high, low) / (ends[1] - ends[0])
    matrix = math3d.translation(np.subtract(low, size * ends[0])) @ math3d.scaling(size)
    return SceneObject(mesh, 0, matrix[None])


def room(table: tuple[float, float] = (0.6, 0.5)) -> list[SceneObject]:
    low = (table[0], 0.2, table[1])
    board = placed(low, (table[0] + 1.2, 0.5, table[1] + 0.7))
    lamp = placed((table[0] + 0.3, 0.5, table[1] + 0.3), (table[0] + 0.4, 0.6, table[1] + 0.5))
    return [placed((0.0, 0.0, 0.0), tuple(SIZE), mesh=1), board, lamp]


def in_picture(items: list[SceneObject], point: FloatArray) -> bool:
    camera = frame(Surfaces(MESHES, items), 40.0, 0.0)
    local = (point - camera.position) @ camera.view_from_world_rotation().T
    x, y = camera.tan_half_fov(16.0 / 9.0)
    return bool(local[2] < 0.0 and abs(local[0]) < -x * local[2] and abs(local[1]) < -y * local[2])


@pytest.mark.parametrize("table", [(0.6, 0.5), (3.4, 0.5), (0.6, 2.9), (3.4, 2.9)])
def test_the_camera_stands_in_the_room_and_sees_what_is_in_it(table: tuple[float, float]) -> None:
    items = room(table)
    camera = frame(Surfaces(MESHES, items), 40.0, 0.0)
    assert (np.array(camera.position) > 0.05 * SIZE).all()
    assert (np.array(camera.position) < 0.95 * SIZE).all()
    assert camera.position[1] == pytest.approx(camera.target[1])
    assert in_picture(items, np.array([table[0] + 0.6, 0.5, table[1] + 0.35]))


def is_closed(items: list[SceneObject]) -> bool:
    return closed_room(Surfaces(MESHES, items), wall_sides(Surfaces(MESHES, items))) is not None


def test_bodies_are_seen_from_outside() -> None:
    body = [placed((0.0, 0.0, 0.0), tuple(SIZE)), *room()[1:]]
    assert not is_closed(body)
    assert not (np.array(frame(Surfaces(MESHES, body), 40.0, 0.0).position) < SIZE).all()
    # A house has walls of two sides.
    assert not is_closed([*body, *room()])
    # There is nothing to see in an empty box.
    assert not is_closed(room()[:1])
    assert is_closed(room())


def test_a_full_room_is_stood_in_where_something_sticks_out_of_a_wall() -> None:
    """Walls on five sides of the box that holds all: the sixth looks open, and is not."""
    walls = [placed((-0.1, -0.1, -0.1), tuple(SIZE + 0.1)), *room()]
    sill = placed((5.1, 0.9, 1.5), (6.0, 1.0, 2.5))
    things = [
        placed((x, 0.2, z), (x + 0.2, 0.7, z + 0.2)) for x in (1.0, 2.0, 3.0) for z in (1.0, 2.0)
    ]
    bare, full = [*walls, sill], [*walls, sill, *things * 8]
    for items, is_within in ((bare, False), (full, True)):
        place = np.array(frame(Surfaces(MESHES, items), 40.0, 0.0).position)
        assert bool(((place > 0.0) & (place < SIZE)).all()) is is_within
    # Without that wall one looks into it from there.
    open_side = [placed((-0.1, y, -0.1), (6.0, y + 0.01, 4.1)) for y in (-0.1, 2.7)]
    open_side += [placed((-0.1, -0.1, z), (6.0, 2.7, z + 0.01)) for z in (-0.1, 4.1)]
    open_side += [placed((-0.1, -0.1, -0.1), (-0.09, 2.7, 4.1)), *things * 8]
    assert frame(Surfaces(MESHES, open_side), 40.0, 0.0).position[0] > 6.0


def test_walls_all_around_a_camera_keep_light_out_however_they_face() -> None:
    house = [placed((-0.1, -0.1, -0.1), tuple(SIZE + 0.1)), *room()]
    middle = Camera((2.5, 1.3, 2.6), (2.5, 1.3, 0.0))
    assert room_around(Surfaces(MESHES, house), middle) is not None
    assert room_around(Surfaces(MESHES, house[:1]), middle) is not None, "an empty one is as dark"
    outside = Camera((2.5, 1.3, 9.0), (2.5, 1.3, 0.0))
    assert room_around(Surfaces(MESHES, house), outside) is None
    # Four walls and a floor: the sky comes in.
    thin = [placed((x, 0.0, 0.0), (x + 0.01, 2.6, 4.0)) for x in (0.0, 5.0)]
    thin += [placed((0.0, 0.0, z), (5.0, 2.6, z + 0.01)) for z in (0.0, 4.0)]
    floor = placed((0.0, 0.0, 0.0), (5.0, 0.01, 4.0))
    assert room_around(Surfaces(MESHES, [*thin, floor, *room()[1:]]), middle) is None


def write_room(path: Path) -> Path:
    text, first = "", 1
    for item in room():
        mesh = MESHES[item.mesh]
        for x, y, z in math3d.transform_points(item.world_from_object[0], mesh.positions):
            text += f"v {x} {y} {z}\n"
        text += "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.triangles + first).tolist())
        first += len(mesh.positions)
    path.write_text(text)
    return path


def test_a_closed_room_of_a_file_is_lit_within(tmp_path: Path) -> None:
    """Sky and key light stay outside: without a lamp of its own it would be black."""
    scene = load_scene(write_room(tmp_path / "room.obj"), ground="auto")
    (lamp,) = scene.lights
    assert isinstance(lamp, RectangleLight)
    assert 0.85 * SIZE[1] < lamp.place[1] < SIZE[1]
    assert lamp.axes()[2][1] < -0.99, "it shines down"
    assert any("below the ceiling" in note for note in scene.notes)
    assert not scene.has_ground
    image = ssdo_gl.render(scene, size=(64, 36))
    light = image[..., :3].mean(axis=2) * 2.0**scene.camera.exposure
    assert (image[..., 3] == 1.0).all()
    assert np.percentile(light, 2) > 0.01


@pytest.mark.parametrize("albedo", [0.2, 0.8])
def test_an_empty_box_around_a_camera_is_lit_and_exposed(albedo: float) -> None:
    """It was black, and white walls would be burnt out at the exposure that scenes begin with."""
    walls = (
        '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [5, 2.6, 4]\nmaterial = "wall"\n'
        f"[materials.wall]\nalbedo = [{albedo}, {albedo}, {albedo}]\n"
    )
    camera = "[camera]\nposition = [2.5, 1.3, 3.5]\ntarget = [2.5, 1.3, 0]\n"
    picture = ssdo_gl.render(read_description(camera + walls, "room"), aov="display", size=(64, 36))
    assert 0.3 < picture.mean() < 0.8
    assert (picture[..., :3] > 0.99).mean() < 0.1
    said = read_description(f"{camera}exposure = 1\n{walls}", "room")
    assert said.metering_slack is None
