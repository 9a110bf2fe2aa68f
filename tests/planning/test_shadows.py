"""No shadow map is called useless where a ray of light is stopped."""

from __future__ import annotations

import dataclasses

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ssdo_gl import math3d
from ssdo_gl.planning import shadows as content_shadows
from ssdo_gl.planning.bodies import bodies_of
from ssdo_gl.planning.shadows import shadow_is_possible
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

WHITE = (1.0, 1.0, 1.0)
IDENTITY = np.eye(4)
BOX, QUAD, SPHERE = shapes.box(), shapes.quad(), shapes.sphere(12)
SUN = DirectionalLight((0.0, -1.0, 0.0), WHITE)
LAMP = PointLight((0.0, 10.0, 0.0), WHITE)
PANEL = RectangleLight((-0.5, 10.0, -0.5), (1, 0, 0), (0, 0, 1), WHITE)
LIGHTS = (SUN, LAMP, PANEL)


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


def possible(light, found, seen=None, number=0):
    seen = np.arange(len(found)) if seen is None else np.asarray(seen)
    return shadow_is_possible(light, number, found, seen)


LYING = math3d.rotation_euler(np.array([-90.0, 0.0, 0.0])) @ at(-0.5, -0.5, 0.0)


def test_a_sheet_alone_has_no_shadow_to_receive():
    for light in LIGHTS:
        assert not possible(light, bodies((QUAD, LYING)))


def test_a_solid_may_have_shadows_of_its_map_where_light_grazes_it():
    for mesh in (BOX, SPHERE, shapes.torus(0.3)):
        assert possible(LAMP, bodies((mesh, IDENTITY)))


def test_one_body_over_another_throws_a_shadow():
    for light in LIGHTS:
        assert possible(light, bodies((QUAD, LYING), (BOX, at(0, 2, 0))), seen=[0])


def test_bodies_side_by_side_do_not():
    for light in LIGHTS:
        assert not possible(light, bodies((QUAD, LYING), (BOX, at(4, 0, 0))), seen=[0])
        assert not possible(light, bodies((QUAD, LYING), (QUAD, at(4, 0, 0) @ LYING)))


def test_what_passes_closely_in_the_map_may_darken_a_rim():
    # The map of parallel light spans both; texels are told apart by four of 256.
    assert possible(SUN, bodies((QUAD, LYING), (BOX, at(1.001, 3, 0))), seen=[0])


def test_only_what_is_seen_must_be_free_of_shadow():
    found = bodies((QUAD, LYING), (QUAD, at(0, 2, 0) @ LYING))
    # The upper sheet is free; the lower one lies in its shadow.
    assert not possible(LAMP, found, seen=[1])
    assert possible(LAMP, found, seen=[0])


def test_casters_out_of_view_count():
    found = bodies((QUAD, LYING), (BOX, at(0, 5, 0)))
    assert possible(SUN, found, seen=[0])


def test_light_that_strays_comes_past_the_edge_of_what_stands_beside():
    found = bodies((QUAD, LYING), (BOX, at(1.6, 3, 0)))
    assert not possible(SUN, found, seen=[0])
    assert possible(dataclasses.replace(SUN, angle=40.0), found, seen=[0])


def test_what_lies_behind_the_light_is_no_caster():
    above = bodies((QUAD, LYING), (BOX, at(0, 12, 0)))
    assert not possible(LAMP, above, seen=[0])
    assert not possible(PANEL, above, seen=[0])
    assert possible(SUN, above, seen=[0])


def test_the_body_of_a_light_does_not_shadow_its_own_light():
    items = ((QUAD, LYING), (QUAD, at(-0.5, 9.0, 0.0)))
    found = bodies(*items, lights=[None, 1])
    assert not possible(PANEL, found, number=1, seen=[0])
    assert not possible(PANEL, found, number=1)
    assert possible(PANEL, found, number=0, seen=[0])


def test_every_corner_of_a_rectangle_counts():
    # The caster stands to the right; of the light only corner `far` leans over it.
    found = bodies((QUAD, LYING), (BOX, at(4, 2, 0)))
    assert not possible(PANEL, found, seen=[0])
    far, left, a, b = np.array([[60, 10, 0], [-60, 10, 0], [0, 10, 1], [0, 10, -1]])
    for corner, along_u, along_v in ((far, a, b), (a, far, left), (left, a, b), (a, left, far)):
        light = RectangleLight(corner, along_u - corner, along_v - corner, WHITE)
        assert possible(light, found, seen=[0])


def test_the_body_of_a_light_is_not_lit_by_it():
    found = bodies((BOX, IDENTITY), (QUAD, at(-0.5, 0.0, 0.0)), lights=[None, 1])
    assert not possible(PANEL, found, number=1, seen=[1])
    assert possible(PANEL, found, number=0, seen=[1])


def test_many_pairs_are_not_compared(monkeypatch):
    monkeypatch.setattr(content_shadows, "MOST_PAIRS", 8)
    sheets = [(QUAD, at(4 * i, 0, 0) @ LYING) for i in range(3)]
    assert possible(LAMP, bodies(*sheets))
    assert not possible(LAMP, bodies(*sheets[:2]))


places = st.tuples(*[st.floats(-3.0, 3.0) for _ in range(3)])
turns = st.tuples(*[st.floats(0.0, 360.0) for _ in range(3)])


@st.composite
def matrices(draw):
    turn = math3d.rotation_euler(np.array(draw(turns)))
    scale = [draw(st.floats(0.2, 1.5)) for _ in range(3)]
    return at(*draw(places)) @ turn @ np.diag([*scale, 1.0])


@st.composite
def any_light(draw):
    place = np.array(draw(places)) * 2.0
    kind = draw(st.integers(0, 2))
    if kind == 0:
        direction = place + np.array([0.1, -1.0, 0.0])
        angle = draw(st.sampled_from([0.0, 40.0]))
        return DirectionalLight(tuple(direction / np.linalg.norm(direction)), WHITE, angle)
    if kind == 1:
        return PointLight(tuple(place), WHITE)
    return dataclasses.replace(PANEL, corner=tuple(place), edge_u=(4.0, 0.0, 0.0))


def ray_meets_box(origin, direction, longest, matrix):
    """Whether a segment meets the unit cube under `matrix` (slabs, in the cube's space)."""
    inverse = np.linalg.inv(matrix)
    o = math3d.transform_points(inverse, origin)
    d = inverse[:3, :3] @ direction
    d = np.where(np.abs(d) < 1e-300, 1e-300, d)
    near, far = np.sort([(-0.5 - o) / d, (0.5 - o) / d], axis=0)
    return max(near.max(), 1e-6) < min(far.min(), longest - 1e-6)


def on_panel(light, rng):
    a, b = rng.uniform(size=2)
    return np.asarray(light.corner) + a * np.asarray(light.edge_u) + b * np.asarray(light.edge_v)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.lists(matrices(), min_size=2, max_size=3), any_light(), st.integers(0, 2**32 - 1))
def test_rays_of_light_that_need_no_map_meet_nothing(items, light, seed):
    """One sheet among boxes."""
    sheet, *boxes = items
    found = bodies((QUAD, sheet), *((BOX, matrix) for matrix in boxes))
    if possible(light, found, seen=[0]):
        return
    rng = np.random.default_rng(seed)
    positions = math3d.transform_points(sheet, QUAD.positions)
    for _ in range(40):
        triangle = positions[QUAD.triangles[rng.integers(len(QUAD.triangles))]]
        point = rng.dirichlet(np.ones(3)) @ triangle
        if isinstance(light, DirectionalLight):
            stray = rng.normal(size=3)
            stray *= light.spread / np.linalg.norm(stray)
            stray -= (stray @ light.direction) * np.asarray(light.direction)
            toward, longest = stray - np.asarray(light.direction), np.inf
        else:
            source = light.position if isinstance(light, PointLight) else on_panel(light, rng)
            toward, longest = np.asarray(source) - point, 1.0
        for box in boxes:
            assert not ray_meets_box(point, toward, longest, box)
