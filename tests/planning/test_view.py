"""What a view rules out is ruled out by brute force, too; what it almost rules out is not."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssdo_gl import math3d
from ssdo_gl.planning import view as view_module
from ssdo_gl.planning.bodies import bodies_of
from ssdo_gl.planning.view import can_reach, neighbours_of, seen_bodies, view_facts
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Distances of a few units, computed in float64 along other ways than the code takes.
FLOAT64_ERROR = 1e-9
WHITE = (1.0, 1.0, 1.0)
IDENTITY = np.eye(4)
BOX, QUAD, SPHERE = shapes.box(), shapes.quad(), shapes.sphere(12)


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


def bodies(*items, lights=None):
    meshes = tuple(mesh for mesh, _ in items)
    owners = lights or [None] * len(items)
    objects = tuple(
        SceneObject(i, 0, np.asarray(matrix)[None], light=owner)
        for i, ((_, matrix), owner) in enumerate(zip(items, owners, strict=True))
    )
    return bodies_of(Scene(meshes, (Material(),), objects, Camera((0, 0, 9), (0, 0, 0))))


def open_distance(found, seen, eye_ws):
    return view_module.open_distance(found, neighbours_of(found, seen, ()), View(eye_ws))


def look(found, seen, lights, eye):
    neighbours = neighbours_of(found, seen, lights)
    return view_facts(found, neighbours, eye)


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


def test_one_box_or_sheet_has_nothing_above_it_at_any_distance():
    for mesh in (BOX, QUAD):
        found = bodies((mesh, IDENTITY))
        assert open_distance(found, every(found), EYE.position_ws) == math.inf
    torus = bodies((shapes.torus(0.3), IDENTITY))
    assert open_distance(torus, every(torus), EYE.position_ws) == 0.0


def test_a_convex_body_seen_from_its_inside_is_a_room():
    found = bodies((BOX, np.diag([30.0, 30.0, 30.0, 1.0])))
    assert open_distance(found, every(found), EYE.position_ws) == 0.0
    outside = np.array([0.0, 0.0, 15.01])
    assert open_distance(found, every(found), outside) == math.inf


def test_the_gap_between_bodies_is_what_stays_open():
    found = bodies((BOX, at(0, 0, 0)), (BOX, at(3, 0, 0)), (BOX, at(0, 4, 0)))
    assert open_distance(found, every(found), EYE.position_ws) == pytest.approx(2.0)
    pair = np.array([0, 2])
    assert open_distance(found, pair, EYE.position_ws) == pytest.approx(3.0)


def test_touching_bodies_leave_nothing_open():
    found = bodies((BOX, at(0, 0, 0)), (BOX, at(1, 0, 0)))
    assert open_distance(found, every(found), EYE.position_ws) == 0.0


def test_boxes_that_overlap_only_along_the_axes_of_the_world_are_told_apart():
    turned = math3d.rotation_euler(np.array([0.0, 0.0, 45.0]))
    # Two unit squares on their tips, side by side along the diagonal.
    found = bodies((BOX, turned), (BOX, at(0.8, 0.8, 0) @ turned))
    expected = 0.8 * math.sqrt(2.0) - 1.0
    assert open_distance(found, every(found), EYE.position_ws) == pytest.approx(expected)


def test_sheets_in_one_plane_do_not_stand_above_each_other():
    tiles = bodies((QUAD, at(0, 0, 0)), (QUAD, at(1, 0, 0)), (QUAD, at(0, 1, 0)))
    assert open_distance(tiles, every(tiles), EYE.position_ws) == math.inf
    raised = bodies((QUAD, at(0, 0, 0)), (QUAD, at(1, 0, 1e-6)))
    assert open_distance(raised, every(raised), EYE.position_ws) <= 1e-6
    bent = math3d.rotation_euler(np.array([0.0, -1.0, 0.0]))
    folded = bodies((QUAD, at(0, 0, 0)), (QUAD, at(1, 0, 0) @ bent))
    assert open_distance(folded, every(folded), EYE.position_ws) == 0.0


def test_many_bodies_are_not_compared(monkeypatch):
    found = bodies((BOX, at(0, 0, 0)), (BOX, at(3, 0, 0)))
    monkeypatch.setattr(view_module, "MOST_COMPARED", 1)
    assert open_distance(found, every(found), EYE.position_ws) == 0.0


places = st.tuples(*[st.floats(-3.0, 3.0) for _ in range(3)])
turns = st.tuples(*[st.floats(0.0, 360.0) for _ in range(3)])
sizes = st.tuples(*[st.floats(0.1, 2.0) for _ in range(3)])


SHAPES = st.sampled_from([BOX, QUAD, SPHERE])


@st.composite
def matrices(draw):
    turn = math3d.rotation_euler(np.array(draw(turns)))
    return at(*draw(places)) @ turn @ np.diag([*draw(sizes), 1.0])


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.sampled_from([BOX, QUAD, SPHERE]), matrices()), min_size=2, max_size=4)
)
def test_nothing_above_a_visible_plane_is_nearer_than_said(items):
    """For points of each face that looks at the eye, all vertices above its plane are far."""
    found = bodies(*items)
    said = open_distance(found, every(found), EYE.position_ws)
    for mesh, matrix in items:
        positions = math3d.transform_points(matrix, mesh.positions)
        for triangle in positions[mesh.triangles]:
            normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            normal /= np.linalg.norm(normal)
            toward_eye = EYE.position_ws - triangle[0]
            if mesh.closed and normal @ toward_eye <= 0.0:
                continue
            if normal @ toward_eye < 0.0:
                normal = -normal
            points = np.array([triangle.mean(axis=0), *triangle])
            for other, other_matrix in items:
                vertices = math3d.transform_points(other_matrix, other.positions)
                above = (vertices - triangle[0]) @ normal > FLOAT64_ERROR
                if np.any(above):
                    apart = np.linalg.norm(vertices[above][:, None] - points, axis=2)
                    assert apart.min() >= said - FLOAT64_ERROR


POINT = PointLight((0.0, 5.0, 0.0), WHITE)


def test_light_that_is_off_or_has_nothing_to_light_reaches_nothing():
    found = bodies((BOX, IDENTITY))
    assert can_reach(POINT, found, every(found))
    assert not can_reach(POINT, found, np.empty(0, dtype=np.int64))
    assert not can_reach(dataclasses.replace(POINT, intensity=(0, 0, 0)), found, every(found))
    assert can_reach(DirectionalLight((0, -1, 0), WHITE), found, every(found))


def spot(outer, position=(0.0, 5.0, 0.0), direction=(1.0, 0.0, 0.0)):
    return SpotLight(position, direction, WHITE, outer_angle=outer)


def test_a_spot_reaches_what_is_in_its_cone():
    found = bodies((SPHERE, IDENTITY))
    # The ball, 5 below, fills 11.5 degrees around the direction straight down; its box
    # fills arcsin(sqrt(3) / 5) = 20.3, so the cone ends at most 31.8 degrees off.
    assert not can_reach(spot(50.0), found, every(found))
    assert can_reach(spot(89.0), found, every(found))
    small = bodies((BOX, np.diag([0.1, 0.1, 0.1, 1.0])))
    assert can_reach(spot(1.0, position=(0.0, 0.0, 0.0)), small, every(small))


def test_a_rectangle_reaches_what_lies_before_it():
    panel = RectangleLight((0, 0, 0.6), (1, 0, 0), (0, 1, 0), WHITE)
    found = bodies((BOX, IDENTITY))
    assert not can_reach(panel, found, every(found))
    assert can_reach(dataclasses.replace(panel, two_sided=True), found, every(found))
    cut = dataclasses.replace(panel, corner=(0, 0, 0.499))
    assert can_reach(cut, found, every(found))
    assert not can_reach(dataclasses.replace(cut, edge_u=(0, 0, 0)), found, every(found))


def test_view_facts_are_put_together():
    found = bodies((QUAD, IDENTITY), (QUAD, at(50, 0, 0)))
    lights = (POINT, spot(5.0))
    seen = seen_bodies(found, EYE)
    facts = look(found, seen, lights, EYE)
    assert facts.open_distance == math.inf and not facts.is_empty
    assert facts.reaches == (True, False)
    # Half the frame's height of 16 pixels is .5 at distance 1.
    assert facts.nearest_pixel == pytest.approx(0.1 * 0.5 / 16.0)
    assert facts.farthest_pixel == pytest.approx(100.0 * 0.5 / 16.0)
    assert facts.slant == pytest.approx(1.5)
    nothing = look(found, np.empty(0, dtype=np.int64), lights, EYE)
    assert nothing.is_empty and nothing.reaches == (False, False)


def test_a_sheet_in_view_is_no_solid():
    found = bodies((BOX, IDENTITY), (QUAD, at(5, 0, 0)))
    assert not look(found, every(found), (), EYE).only_solids
    assert look(found, np.array([0]), (), EYE).only_solids


def test_parallel_rays_see_as_much_at_any_distance():
    """The frame is 8 wide and 4 high, and two pixels of .125 more on each side."""
    eye = View(np.array([0.0, 0.0, 10.0]), tan_half_fov=(0.0, 0.0), half_frame=(4.0, 2.0))
    found = bodies(*((BOX, at(x, 0, z)) for z in (0, -1000) for x in (4.7, 4.8)))
    assert list(seen_bodies(found, eye)) == [0, 2]
    facts = look(found, every(found), (), eye)
    assert (facts.nearest_pixel, facts.farthest_pixel, facts.slant) == (0.125, 0.125, 1.0)


@pytest.mark.parametrize(("z", "expected"), [(0.0, math.inf), (9.6, 0.0)])
def test_parallel_rays_may_begin_inside_a_body_that_is_beside_the_eye(z, expected):
    """The near plane cuts the second box open, in which then one wall faces the other."""
    eye = View(np.array([0.0, 0.0, 10.0]), tan_half_fov=(0.0, 0.0), half_frame=(4.0, 2.0), near=0.1)
    found = bodies((BOX, at(2.0, 0.0, z)))
    assert look(found, every(found), (), eye).open_distance == expected
