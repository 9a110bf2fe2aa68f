"""Cameras and light for scenes that bring none."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults.default_light import soft_light
from ssdo_gl.scene.defaults.exposure import exposure_for
from ssdo_gl.scene.defaults.framing import frame, side_coverage
from ssdo_gl.scene.geometry import Surfaces, shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, Light, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material

BOX = shapes.box()
QUAD = shapes.quad()


def ndc(camera: Camera, points: FloatArray, aspect: float = 1.0) -> FloatArray:
    """Return normalised picture coordinates (N, 2); inside is [-1, 1]."""
    local = (points - np.array(camera.position)) @ camera.view_from_world_rotation().T
    assert (local[:, 2] < 0.0).all(), "a point lies behind the camera"
    return local[:, :2] / -local[:, 2:] / np.array(camera.tan_half_fov(aspect))


def placed(*matrices: FloatArray) -> list[SceneObject]:
    return [SceneObject(0, 0, np.stack(matrices))]


@given(
    size=st.tuples(*[st.floats(0.01, 100.0)] * 3),
    scale=st.sampled_from([1e-6, 1.0, 1e6]),
    fov=st.floats(5.0, 120.0),
)
def test_all_of_a_box_is_in_the_picture_and_fills_it(
    size: tuple[float, float, float], scale: float, fov: float
) -> None:
    matrix = math3d.translation((3.0 * scale, -scale, 7.0 * scale)) @ math3d.scaling(
        np.multiply(size, scale)
    )
    camera = frame(Surfaces([BOX], placed(matrix)), fov, 0.0)
    place = ndc(camera, math3d.transform_points(matrix, BOX.positions))
    assert np.abs(place).max() <= 1.0
    # The margin is 6 %, so the tighter direction uses most of the frame.
    assert np.abs(place).max() > 0.9


def room(open_side: int) -> list[SceneObject]:
    """Return five walls of the unit cube: all but the given one of -x +x -y +y -z +z."""
    walls = []
    for side in range(6):
        if side == open_side:
            continue
        axis, sign = side // 2, (-1.0, 1.0)[side % 2]
        normal = np.zeros(3)
        normal[axis] = -sign
        frame_of_wall = math3d.frame_from_z(normal)
        matrix = np.eye(4)
        matrix[:3, :3] = frame_of_wall
        matrix[:3, 3] = -0.5 * normal - 0.5 * (frame_of_wall[:, 0] + frame_of_wall[:, 1])
        walls.append(matrix)
    return placed(*walls)


@pytest.mark.parametrize(
    ("open_side", "toward"),
    [(5, (0, 0, 1)), (4, (0, 0, -1)), (1, (1, 0, 0)), (0, (-1, 0, 0))],
)
def test_a_room_is_looked_into_through_its_open_side(
    open_side: int, toward: tuple[int, int, int]
) -> None:
    camera = frame(Surfaces([QUAD], room(open_side)), 40.0, 0.0)
    direction = math3d.normalized(np.subtract(camera.position, camera.target))
    assert direction == pytest.approx(toward, abs=1e-9)


def test_coverage_counts_the_walls() -> None:
    assert side_coverage(Surfaces([QUAD], room(5))) == pytest.approx([1, 1, 1, 1, 1, 0])


def test_a_corner_is_seen_from_its_open_sides() -> None:
    # Walls at -x and -z, and a floor: the open octant is +x +y +z.
    walls = [room(9)[0].world_from_object[i] for i in (0, 2, 4)]
    camera = frame(Surfaces([QUAD], placed(*walls)), 40.0, 0.0)
    assert np.all(np.subtract(camera.position, camera.target) > 0.0)


def test_a_solid_is_seen_at_three_quarters_from_above() -> None:
    camera = frame(Surfaces([BOX], placed(np.eye(4))), 40.0, 1.5)
    x, y, z = math3d.normalized(np.subtract(camera.position, camera.target))
    assert z > x > 0.0
    assert y > 0.2
    assert camera.exposure == 1.5


def storey(wall: float, *, table: float = 0.7, roof: bool = False) -> list[SceneObject]:
    """Return boxes: a floor of 8 x 6, walls so high around it and across, four tables, a roof."""
    plan = [(0, 0, 8, 0.2), (0, 5.8, 8, 6), (0, 0, 0.2, 6), (7.8, 0, 8, 6), (4, 0, 4.2, 4)]
    boxes = [((0, -0.2, 0), (8, 0, 6)), *(((a, 0, b), (c, wall, d)) for a, b, c, d in plan)]
    boxes += [((x, 0, z), (x + 1, table, z + 1)) for x in (1, 6) for z in (1, 4)]
    boxes += [((0, wall, 0), (8, wall + 0.2, 6))] * roof
    low, high = BOX.positions.min(axis=0), BOX.positions.max(axis=0)
    return placed(*(
        math3d.translation(a) @ math3d.scaling(np.subtract(b, a) / (high - low))
        @ math3d.translation(-low) for a, b in boxes
    ))  # fmt: skip


@pytest.mark.parametrize(
    ("objects", "is_high"),
    [
        (storey(2.6), True),
        (storey(2.6, roof=True), False),  # nothing shows from above
        (storey(0.3), False),  # walls hide nothing
        (storey(5.0), False),  # a vessel, not a storey
    ],
)
def test_a_storey_without_a_roof_is_seen_over_its_walls(
    objects: list[SceneObject], is_high: bool
) -> None:
    camera = frame(Surfaces([BOX], objects), 40.0, 0.0)
    _, y, _ = math3d.normalized(np.subtract(camera.position, camera.target))
    assert y == pytest.approx(math.sin(math.radians(55.0 if is_high else 20.0)))


def test_a_flat_scene_is_framed_too() -> None:
    camera = frame(Surfaces([QUAD], placed(np.eye(4))), 40.0, 0.0)
    assert np.isfinite(camera.position).all()
    assert np.abs(ndc(camera, QUAD.positions)).max() <= 1.0


@pytest.mark.parametrize(("single_sided", "degrees"), [(True, 90.0), (False, 90.0), (True, -90.0)])
def test_a_sheet_on_its_face_is_seen_from_the_side_that_is_drawn(
    single_sided: bool, degrees: float
) -> None:
    matrix = math3d.rotation_euler((degrees, 0.0, 0.0))
    sheet = Surfaces([QUAD], placed(matrix), [Material(single_sided=single_sided)])
    y = frame(sheet, 40.0, 0.0).position[1]
    assert (y < 0.0) == (single_sided and degrees > 0.0)


def test_many_instances_are_framed_by_their_boxes() -> None:
    sphere = shapes.sphere()
    offsets = np.linspace(0.0, 50.0, 120)
    matrices = [math3d.translation((x, 0.0, 0.0)) for x in offsets]
    camera = frame(Surfaces([sphere], placed(*matrices)), 40.0, 0.0)
    ends = np.concatenate([sphere.positions, sphere.positions + np.array([50.0, 0.0, 0.0])])
    assert np.abs(ndc(camera, ends)).max() <= 1.0


@pytest.mark.parametrize(
    "position", [(0.0, 0.0, 5.0), (3.0, 1.0, -4.0), (0.0, 6.0, 0.0), (0.0, -6.0, 0.0)]
)
def test_the_key_light_comes_from_above_and_from_the_camera_side(
    position: tuple[float, float, float],
) -> None:
    camera = Camera(position, (0.0, 0.0, 0.0))
    _, key = soft_light(camera)
    assert np.linalg.norm(key.direction) == pytest.approx(1.0)
    assert key.direction[1] < -0.5
    view = np.subtract(camera.target, camera.position)
    assert np.dot(view, key.direction) > 0.0 or position[1] < 0.0


def test_the_key_light_stands_to_the_left() -> None:
    _, key = soft_light(Camera((0.0, 1.0, 5.0), (0.0, 0.0, 0.0)))
    assert key.direction[0] > 0.1  # it travels to the right
    assert key.direction[2] < -0.1


def test_exposure_brings_a_white_floor_to_its_target() -> None:
    floor = placed(np.eye(4))
    light = DirectionalLight((0.0, 0.0, -1.0), (1.0, 1.0, 1.0))
    # Reflected 0.8 / pi; the exposure must bring it to 0.3, rounded to a tenth of an EV.
    expected = np.log2(0.3 * np.pi / 0.8)
    assert exposure_for(Surfaces([QUAD], floor), [light]) == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize("factor", [1e-3, 64.0])
def test_exposure_undoes_the_strength_of_the_light(factor: float) -> None:
    floor = placed(np.eye(4))
    lights = [
        PointLight((0.5, 0.5, 2.0), (1.0, 1.0, 1.0)),
        RectangleLight((0, 0, 1), (0, 1, 0), (1, 0, 0), (1.0, 1.0, 1.0)),
    ]
    strong = [
        PointLight((0.5, 0.5, 2.0), (factor,) * 3),
        RectangleLight((0, 0, 1), (0, 1, 0), (1, 0, 0), (factor,) * 3),
    ]
    plain = exposure_for(Surfaces([QUAD], floor), lights)
    assert exposure_for(Surfaces([QUAD], floor), strong) == pytest.approx(
        plain - np.log2(factor), abs=0.11
    )


@pytest.mark.parametrize(
    "light",
    [
        PointLight((0.5, 0.5, 2.0), (1.0, 1.0, 1.0)),
        SpotLight((0.5, 0.5, 2.0), (0.0, 0.0, -1.0), (1.0, 1.0, 1.0)),
        DirectionalLight((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)),
        RectangleLight((0, 0, 1), (0, 1, 0), (1, 0, 0), (1.0, 1.0, 1.0)),
    ],
    ids=lambda light: light.kind,
)
def test_exposure_of_lamps_alone_is_zero(light: Light) -> None:
    """Every surface glows: none is left whose brightness would say how to expose."""
    lamps = [dataclasses.replace(item, light=0) for item in placed(np.eye(4))]
    assert exposure_for(Surfaces([QUAD], lamps), [light]) == 0.0


def test_exposure_of_an_unlit_scene_is_zero() -> None:
    floor = placed(np.eye(4))
    assert exposure_for(Surfaces([QUAD], floor), []) == 0.0
    # A rectangle that shines the other way lights nothing.
    away = RectangleLight((0, 0, 1), (1, 0, 0), (0, 1, 0), (1.0, 1.0, 1.0))
    assert exposure_for(Surfaces([QUAD], floor), [away]) == 0.0
