"""What a view rules out; what it almost rules out is not."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.facts import view as view_module
from ssdo_gl.facts.bodies import bodies_of
from ssdo_gl.facts.view import seen_bodies, view_facts
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

IDENTITY = np.eye(4)
BOX, QUAD, TORUS = shapes.box(), shapes.quad(), shapes.torus(0.3)


@dataclass(frozen=True)
class View:
    """A camera at `position_ws` that looks along -z."""

    position_ws: np.ndarray
    view_from_world: np.ndarray = dataclasses.field(default_factory=lambda: np.eye(3))
    tan_half_fov: tuple[float, float] = (1.0, 0.5)
    half_frame: tuple[float, float] = (0.0, 0.0)
    size: tuple[int, int] = (64, 32)
    near: float = 0.1
    far: float = 100.0


EYE = View(np.array([0.0, 0.0, 10.0]))


def at(x, y, z):
    return math3d.translation((x, y, z))


def bodies(*items):
    meshes = tuple(mesh for mesh, _ in items)
    objects = tuple(
        SceneObject(i, 0, np.asarray(matrix)[None]) for i, (_, matrix) in enumerate(items)
    )
    return bodies_of(Scene(meshes, (Material(),), objects, Camera((0, 0, 9), (0, 0, 0))))


def every(found):
    return np.arange(len(found))


def test_what_lies_outside_the_frame_is_not_seen():
    # At distance 10 the frame reaches 10 to the sides and 5 up, and 2 pixels of .31 more.
    found = bodies(
        (BOX, at(0, 0, 0)),
        (BOX, at(12.2, 0, 0)),
        (BOX, at(-12.2, 0, 0)),
        (BOX, at(0, 7.2, 0)),
        (BOX, at(0, -7.2, 0)),
        (BOX, at(0, 0, 11)),
    )
    assert list(seen_bodies(found, EYE)) == [0]


def test_what_just_reaches_into_the_frame_is_seen():
    found = bodies((BOX, at(10.45, 0, 0)), (BOX, at(0, 5.2, 0)), (BOX, at(0, 0, 10.45)))
    assert list(seen_bodies(found, EYE)) == [0, 1, 2]


def test_a_sample_beside_the_frame_still_counts():
    # The sheet begins half a pixel outside: 20 units over 64 pixels are .31 each.
    found = bodies((QUAD, at(10.0 + 0.5 * 20.0 / 64.0, 0, 0)))
    assert list(seen_bodies(found, EYE)) == [0]


@pytest.mark.parametrize(
    "eye",
    [EYE, dataclasses.replace(EYE, tan_half_fov=(0.0, 0.0), half_frame=(2.0, 1.0))],
    ids=["perspective", "parallel"],
)
def test_the_region_of_bodies_holds_all_their_points_and_little_more(eye):
    rng = np.random.default_rng(5)
    wide = np.array(eye.tan_half_fov)
    for _ in range(50):
        turned = math3d.rotation_euler(rng.uniform(0.0, 360.0, 3))
        found = bodies((BOX, at(*rng.uniform(-1.5, 1.5, 3)) @ turned))
        x, y, width, height = view_module.region_of(found, every(found), eye)
        points = BOX.positions @ found.world_from_object[0, :3, :3].T + found.center[0]
        across = points[:, :2] / (np.array(eye.half_frame) + wide * (10.0 - points[:, 2:]))
        px = np.clip((0.5 + 0.5 * across) * eye.size, 0, eye.size)
        low, high = px.min(axis=0), px.max(axis=0)
        assert np.all((x, y) <= low)
        assert np.all((x + width, y + height) >= high)
        assert np.all(np.array([x, y]) >= low - view_module.FRAME_MARGIN_PX - 1.0)
        assert np.all(np.array([x + width, y + height]) <= high + view_module.FRAME_MARGIN_PX + 1.0)


def test_the_region_of_what_reaches_behind_the_eye_is_the_frame():
    found = bodies((BOX, at(0, 0, 0)), (BOX, at(0, 0, 10.3)))
    assert view_module.region_of(found, every(found), EYE) == (0, 0, *EYE.size)
    assert view_module.region_of(found, np.array([], int), EYE) is None


def test_light_of_their_own_is_looked_for_where_bodies_show_it():
    found = bodies((BOX, at(2, 0, 0)), (BOX, at(-2, 0, 0)))
    for lamps in ([], [0], [1], [0, 1]):
        emits = np.isin(every(found), lamps)
        facts = view_facts(dataclasses.replace(found, emits=emits), EYE)
        assert facts.emission_region == view_module.region_of(found, np.array(lamps, int), EYE)
        assert facts.kinds[-1] == (not lamps)


@pytest.mark.parametrize(
    ("material", "wanted"),
    [({}, False), ({"emission": (0.0, 0.1, 0.0)}, True), ({"is_unlit": True}, True)],
)
def test_bodies_emit_as_their_material_does(material, wanted):
    item = SceneObject(0, 0, IDENTITY[None])
    camera = Camera((0, 0, 9), (0, 0, 0))
    found = bodies_of(Scene((BOX,), (Material(**material),), (item,), camera))
    assert found.emits.tolist() == [wanted]


def test_one_box_is_alone_and_nothing_else_is():
    aside = (BOX, at(50, 0, 0))
    assert view_facts(bodies((BOX, IDENTITY), aside), EYE).is_alone
    for others in ([(QUAD, IDENTITY)], [(TORUS, IDENTITY)], [(BOX, IDENTITY), (BOX, at(3, 0, 0))]):
        facts = view_facts(bodies(*others, aside), EYE)
        assert not facts.is_alone and not facts.is_empty
    nothing = view_facts(bodies(aside), EYE)
    assert nothing.is_empty and not nothing.is_alone and nothing.gloss_region is None


def test_a_box_seen_from_its_inside_is_a_room():
    found = bodies((BOX, np.diag([30.0, 30.0, 30.0, 1.0])))
    assert not view_facts(found, EYE).is_alone
    assert view_facts(found, View(np.array([0.0, 0.0, 15.01]))).is_alone


def test_parallel_rays_see_as_much_at_any_distance():
    """The frame is 8 wide and 4 high, and two pixels of .125 more on each side."""
    eye = View(np.array([0.0, 0.0, 10.0]), tan_half_fov=(0.0, 0.0), half_frame=(4.0, 2.0))
    found = bodies(*((BOX, at(x, 0, z)) for z in (0, -1000) for x in (4.7, 4.8)))
    assert list(seen_bodies(found, eye)) == [0, 2]


@pytest.mark.parametrize(("z", "expected"), [(0.0, True), (9.6, False)])
def test_parallel_rays_may_begin_inside_a_body_that_is_beside_the_eye(z, expected):
    """The near plane cuts the second box open, in which then one wall faces the other."""
    eye = View(np.array([0.0, 0.0, 10.0]), tan_half_fov=(0.0, 0.0), half_frame=(4.0, 2.0), near=0.1)
    found = bodies((BOX, at(2.0, 0.0, z)))
    assert view_facts(found, eye).is_alone == expected
