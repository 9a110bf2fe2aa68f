"""Rooms of any plan whose outside shows the backs of their walls: one stands in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults import frame, is_room
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces, shapes
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material

# The plan of an L, anticlockwise as seen from above with z to the left.
PLAN = [(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (3.0, 3.0), (3.0, 6.0), (0.0, 6.0)]
HEIGHT = 2.6
TABLE = (4.2, 0.3, 1.0), (5.2, 0.8, 2.0)


def quad(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> list[FloatArray]:
    """Return two triangles of a parallelogram; its front is where a, b, c turn anticlockwise."""
    a_, b_, c_ = (np.array(point) for point in (a, b, c))
    return [np.array([a_, b_, c_]), np.array([a_, c_, a_ + c_ - b_])]


def shell() -> FloatArray:
    """Return triangles (T, 3, 3) of floor, ceiling and walls of the L, which face inward."""
    found = []
    for low, high in (((0.0, 0.0), (6.0, 3.0)), ((0.0, 3.0), (3.0, 6.0))):
        (x0, z0), (x1, z1) = low, high
        found += quad((x0, 0.0, z0), (x0, 0.0, z1), (x1, 0.0, z1))
        found += quad((x0, HEIGHT, z0), (x1, HEIGHT, z0), (x1, HEIGHT, z1))
    for (x0, z0), (x1, z1) in zip(PLAN, [*PLAN[1:], PLAN[0]], strict=True):
        found += quad((x0, 0.0, z0), (x1, 0.0, z1), (x1, HEIGHT, z1))
    return np.array(found)


def mesh_of(triangles: FloatArray) -> Mesh:
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def table() -> FloatArray:
    box = shapes.box()
    low, high = box.positions.min(axis=0), box.positions.max(axis=0)
    unit = (box.positions - low) / (high - low)
    return (TABLE[0] + unit * np.subtract(TABLE[1], TABLE[0]))[box.triangles]


OBJECTS = [SceneObject(0, 0, np.eye(4)[None]), SceneObject(1, 0, np.eye(4)[None])]
INWARD = [mesh_of(shell()), mesh_of(table())]
OUTWARD = [mesh_of(shell()[:, ::-1]), INWARD[1]]
TWO_SIDED, SINGLE_SIDED = Material(), Material(single_sided=True)


def is_within(camera: Camera) -> bool:
    x, y, z = camera.position
    return 0.0 < x < 6.0 and 0.0 < y < HEIGHT and 0.0 < z < 6.0 and not (x > 3.0 and z > 3.0)


def test_the_camera_stands_in_an_angled_room_and_sees_what_is_in_it() -> None:
    camera = frame(Surfaces(INWARD, OBJECTS, [TWO_SIDED]), 40.0, 1.5)
    assert is_within(camera)
    assert camera.position[1] == pytest.approx(camera.target[1])
    assert camera.exposure == 1.5
    local = (np.mean(TABLE, axis=0) - camera.position) @ camera.view_from_world_rotation().T
    x, y = camera.tan_half_fov(16.0 / 9.0)
    assert abs(local[0]) < -x * local[2]
    assert abs(local[1]) < -y * local[2]
    assert is_room(Surfaces(INWARD, OBJECTS), camera)


def test_it_is_seen_from_outside_where_its_backs_are_not_drawn() -> None:
    """A doll's house: one looks in through the walls that face away."""
    camera = frame(Surfaces(INWARD, OBJECTS, [SINGLE_SIDED]), 40.0, 0.0)
    assert not is_within(camera)
    assert not is_room(Surfaces(INWARD, OBJECTS), camera)


SIDES = ("-x", "+x", "-y", "+y", "-z", "+z")


def box_room(outward: set[str]) -> list[Mesh]:
    """Return a closed box with a table, whose walls face inward but for those named."""
    box = shapes.box()
    low, high = box.positions.min(axis=0), box.positions.max(axis=0)
    corners = ((box.positions - low) / (high - low))[box.triangles]
    walls = []
    for triangle in corners:
        (axis,) = np.flatnonzero(np.ptp(triangle, axis=0) == 0.0)
        name = SIDES[2 * axis + int(triangle[0, axis] > 0.5)]
        walls.append((triangle if name in outward else triangle[::-1]) * [6.0, HEIGHT, 5.0])
    return [mesh_of(np.array(walls)), INWARD[1]]


@pytest.mark.parametrize(
    ("outward", "facing"),
    [
        ({"+z", "+y"}, {"+x", "-z"}),
        ({"+x", "-z", "+y"}, {"-x", "+z"}),
        ({"+z", "+x"}, {"-x", "-z"}),
    ],
)
def test_one_looks_through_walls_that_are_not_drawn(outward: set[str], facing: set[str]) -> None:
    """Walls wound at random: from the sides whose backs show, level below a roof that shows."""
    camera = frame(Surfaces(box_room(outward), OBJECTS, [SINGLE_SIDED]), 40.0, 0.0)
    toward = np.subtract(camera.position, camera.target)
    towards = {f"{'-+'[int(toward[axis] > 0.0)]}{name}" for axis, name in ((0, "x"), (2, "z"))}
    assert towards == facing
    assert (abs(toward[1]) < 1e-9) == ("+y" in outward)


def test_a_house_of_that_plan_is_seen_from_outside() -> None:
    assert not is_within(frame(Surfaces(OUTWARD, OBJECTS, [TWO_SIDED]), 40.0, 0.0))
    both = [*OBJECTS, SceneObject(2, 0, np.eye(4)[None])]
    walls = [*INWARD, mesh_of(1.01 * shell()[:, ::-1] - [0.03, 0.01, 0.03])]
    assert not is_within(frame(Surfaces(walls, both, [TWO_SIDED]), 40.0, 0.0))


@pytest.mark.parametrize("depth", [2.0, 5.0])
def test_a_box_with_one_open_side_is_looked_into_through_that(depth: float) -> None:
    """Deep in it walls are nearly all around, too."""
    box = shapes.box()
    low, high = box.positions.min(axis=0), box.positions.max(axis=0)
    places = (box.positions - low) / (high - low) * [6.0, HEIGHT, depth]
    inside_out = places[box.triangles[:, ::-1]]
    walls = inside_out[~(inside_out[..., 2] == depth).all(axis=1)]
    things = np.concatenate([place + table() * [1.0, 1.0, 0.5] for place in (0.0, [-3.5, 0, 0])])
    camera = frame(Surfaces([mesh_of(walls), mesh_of(things)], OBJECTS, [TWO_SIDED]), 40.0, 0.0)
    assert camera.position[2] > depth


def test_an_empty_one_and_an_open_bowl_are_seen_from_outside() -> None:
    assert not is_within(frame(Surfaces(INWARD[:1], OBJECTS[:1], [TWO_SIDED]), 40.0, 0.0))
    ball = shapes.sphere(16)
    lower = ball.triangles[(ball.positions[ball.triangles][..., 1] <= 1e-9).all(axis=1), ::-1]
    pea = Mesh(0.2 * ball.positions - [0.0, 0.5, 0.0], ball.triangles)
    camera = frame(Surfaces([Mesh(ball.positions, lower), pea], OBJECTS, [TWO_SIDED]), 40.0, 0.0)
    assert np.linalg.norm(camera.position) > 1.5


def test_a_body_that_is_wound_inward_is_seen_from_outside() -> None:
    """Mirrored, say: a ball on a stick shows backs like a room, but has no floor."""
    ball, stick = shapes.sphere(16), shapes.cylinder(16)
    pole = Mesh(stick.positions * [0.2, 1.0, 0.2] - [0.0, 1.5, 0.0], stick.triangles[:, ::-1])
    meshes = [Mesh(ball.positions, ball.triangles[:, ::-1]), pole]
    camera = frame(Surfaces(meshes, OBJECTS, [TWO_SIDED]), 40.0, 0.0)
    assert np.linalg.norm(camera.position) > 1.5


def test_a_body_with_a_floor_and_little_space_is_seen_from_outside() -> None:
    """Parts of machines, wound inward, were looked at from within their metal."""
    box = shapes.box()
    sizes = [([2.0, 0.1, 2.0], [0.0, 0.0, 0.0])]
    sizes += [([0.1, 0.6, 0.1], [x, 0.3, z]) for x in (-0.8, 0.8) for z in (-0.8, 0.8)]
    meshes = [Mesh(box.positions * size + place, box.triangles[:, ::-1]) for size, place in sizes]
    objects = [SceneObject(index, 0, np.eye(4)[None]) for index in range(len(meshes))]
    camera = frame(Surfaces(meshes, objects, [TWO_SIDED]), 40.0, 0.0)
    assert np.linalg.norm(camera.position) > 1.5


def test_a_file_of_it_is_lit_within(tmp_path: Path) -> None:
    triangles = np.concatenate([shell(), table()])
    lines = [f"v {x} {y} {z}" for x, y, z in triangles.reshape(-1, 3)]
    lines += [f"f {i} {i + 1} {i + 2}" for i in range(1, 3 * len(triangles), 3)]
    path = tmp_path / "room.obj"
    path.write_text("\n".join(lines))
    scene = load_scene(path, ground="auto")
    assert is_within(scene.camera)
    assert is_within(Camera.fit(scene))
    assert any("below the ceiling" in note for note in scene.notes)
    assert not scene.has_ground
