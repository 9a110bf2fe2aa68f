"""What cameras and lengths that nobody gave go by."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.defaults import frame, has_floor, is_room
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces, main_part, shapes
from ssdo_gl.scene.load import builtin_names, load_scene

BOX, QUAD, BALL = shapes.box(), shapes.quad(), shapes.sphere(16)
DOME = dataclasses.replace(BALL, triangles=BALL.triangles[:, ::-1])
MESHES = [BOX, QUAD, DOME, BALL]
LYING = math3d.rotation_euler((-90.0, 0.0, 0.0))


def at(place: tuple[float, ...], size: float, mesh: int = 0) -> SceneObject:
    matrix = math3d.translation(place) @ math3d.scaling((size,) * 3)
    return SceneObject(mesh, 0, matrix[None])


def ground(half: float) -> SceneObject:
    matrix = LYING @ math3d.scaling((2.0 * half,) * 3) @ math3d.translation((-0.5, -0.5, 0.0))
    return SceneObject(1, 0, matrix[None])


def moved(item: SceneObject, matrix: FloatArray) -> SceneObject:
    return dataclasses.replace(item, world_from_object=matrix @ item.world_from_object)


ROOM = [at((0.0, 0.0, 0.0), 2.0), at((3.0, 0.0, 1.0), 1.0), at((0.0, 0.0, 4.0), 1.5)]
STRAYS = [at((500.0, 3.0, 0.0), 0.1), at((-40.0, 300.0, 90.0), 0.2)]


@given(
    scale=st.sampled_from([1e-6, 1.0, 1e6]),
    place=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    order=st.permutations(range(5)),
)
def test_strays_are_left_out_wherever_the_scene_is_and_however_it_is_ordered(
    scale: float, place: tuple[float, float, float], order: list[int]
) -> None:
    matrix = math3d.scaling((scale,) * 3) @ math3d.translation(place)
    items = [moved(item, matrix) for item in ROOM + STRAYS]
    rest = main_part(Surfaces(MESHES, items[: len(ROOM)]))
    found = main_part(Surfaces(MESHES, [items[index] for index in order]))
    assert rest.is_all
    assert not rest.note
    assert found.stray_count == 24
    np.testing.assert_array_equal(found.low, rest.low)
    np.testing.assert_array_equal(found.high, rest.high)


def test_strays_within_one_mesh_are_left_out_too() -> None:
    """A file may hold all of it as one mesh, and those of one material are joined."""
    parts = [math3d.transform_points(i.world_from_object[0], BOX.positions) for i in ROOM + STRAYS]
    triangles = [BOX.triangles + n * len(BOX.positions) for n in range(len(parts))]
    mesh = Mesh(np.concatenate(parts), np.concatenate(triangles))
    found = main_part(Surfaces([mesh], [SceneObject(0, 0)]))
    np.testing.assert_allclose(
        found.high - found.low, main_part(Surfaces(MESHES, ROOM)).high - found.low
    )
    assert found.stray_count == 24


def test_what_is_not_small_is_no_stray() -> None:
    assert main_part(Surfaces(MESHES, [*ROOM, at((50.0, 0.0, 0.0), 1.0)])).is_all
    # Two villages, and a long row of lamps.
    twin = [moved(item, math3d.translation((90.0, 0.0, 0.0))) for item in ROOM]
    assert main_part(Surfaces(MESHES, [*ROOM, *twin])).is_all
    row = [at((3.0 * n, 0.0, 0.0), 0.2) for n in range(40)]
    assert main_part(Surfaces(MESHES, [*ROOM, *row])).is_all
    assert main_part(Surfaces(MESHES, [at((8.0, 0.0, 0.0), 0.1), *ROOM])).is_all


@pytest.mark.parametrize("is_one_object", [False, True])
def test_of_parts_so_far_apart_that_none_would_be_seen_one_is_framed(is_one_object: bool) -> None:
    items = [at((1e6 * n, 0.0, 0.0), 2.0) for n in range(3)]
    surfaces = Surfaces(MESHES, items)
    if is_one_object:
        places = np.stack([item.world_from_object[0] for item in items])
        surfaces = Surfaces(MESHES, [SceneObject(0, 0, places)])
    found = main_part(surfaces)
    assert found.stray_count == 24
    np.testing.assert_allclose(found.high - found.low, 2.0)
    # One may look for dots.
    assert main_part(Surfaces(MESHES, [items[0], at((500.0, 0.0, 0.0), 2.0)])).is_all


@pytest.mark.parametrize("half", [50.0, 1e4])
def test_a_far_larger_ground_is_left_out_but_counts_as_a_floor(half: float) -> None:
    items = [*[moved(item, math3d.translation((0.0, 2.0, 0.0))) for item in ROOM], ground(half)]
    found = main_part(Surfaces(MESHES, items))
    assert found.stands_on
    assert "ground" in found.note
    assert found.high[0] < 5.0
    assert has_floor(Surfaces(MESHES, items))
    assert not is_room(Surfaces(MESHES, items), frame(Surfaces(MESHES, items), 40.0, 0.0))


def test_a_floor_that_the_rest_fills_belongs_to_it() -> None:
    assert main_part(Surfaces(MESHES, [*ROOM, ground(8.0)])).is_all


def test_a_wall_or_a_sheet_with_a_mark_on_it_is_what_it_is_of() -> None:
    wall = at((-50.0, 0.0, 0.0), 100.0, mesh=1)
    assert main_part(Surfaces(MESHES, [*ROOM, wall])).is_all
    # Something that hangs high above a floor is not what stands on it.
    high = math3d.translation((0.0, 30.0, 0.0))
    assert main_part(Surfaces(MESHES, [*[moved(item, high) for item in ROOM], ground(50.0)])).is_all
    mark = SceneObject(1, 0, (math3d.translation((0.0, 0.1, 0.0)) @ LYING)[None])
    assert main_part(Surfaces(MESHES, [mark, ground(50.0)])).is_all


def test_a_dome_is_left_out_and_the_camera_stands_in_it() -> None:
    items = [*ROOM, at((0.0, 0.0, 0.0), 60.0, mesh=2)]
    found = main_part(Surfaces(MESHES, items))
    assert found.stands_in
    np.testing.assert_array_equal(found.high, main_part(Surfaces(MESHES, ROOM)).high)
    camera = frame(Surfaces(MESHES, items), 40.0, 0.0)
    assert np.linalg.norm(camera.position) < 60.0
    # With a ground and a stray in it, too.
    assert main_part(Surfaces(MESHES, [*items, ground(60.0), STRAYS[0]])).note.count(" and ") == 2
    # A large body beside it is none, nor is one with something small within.
    assert main_part(Surfaces(MESHES, [*ROOM, at((90.0, 0.0, 0.0), 60.0, mesh=2)])).is_all
    assert main_part(Surfaces(MESHES, [*ROOM, at((0.0, 0.0, 0.0), 60.0, mesh=3)])).is_all


def test_a_room_with_lamps_set_flush_into_its_ceiling_is_no_dome() -> None:
    """A grid of eight flat lamps in one plane is all that is not of the room."""
    up = math3d.rotation_euler((90.0, 0.0, 0.0))
    lamps = [
        SceneObject(1, 0, (math3d.translation((x, 4.0, z)) @ up @ math3d.scaling((0.2,) * 3))[None])
        for x in (-1.0, -0.3, 0.3, 1.0)
        for z in (-0.5, 0.5)
    ]
    assert main_part(Surfaces(MESHES, [*lamps, at((0.0, 0.0, 0.0), 30.0, mesh=2)])).is_all


@pytest.mark.parametrize("name", sorted({*builtin_names()} - {"sphere_on_plane"}))
def test_built_in_scenes_are_wholly_their_main_part(name: str) -> None:
    scene = load_scene(name)
    part = scene.main_part()
    assert part.is_all
    np.testing.assert_array_equal((part.low, part.high), scene.bounds())
    assert not [note for note in scene.notes if "main part" in note]


def test_the_radius_of_a_scene_does_not_grow_with_a_stray() -> None:
    plain = load_scene("cornell_meso")
    stray = plain.add(BOX, transform=STRAYS[0].world_from_object)
    assert np.linalg.norm(np.subtract(*stray.bounds())) > 100.0
    assert stray.default_radius() == plain.default_radius()
