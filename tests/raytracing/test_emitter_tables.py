"""Emitters: all light is there once, drawn in proportion, wherever it comes from."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.emitter_tables import (
    BODY_CODE,
    KIND_LIGHT,
    KIND_MAP,
    KIND_PARALLELOGRAM,
    KIND_TRIANGLE,
    STAND_IN_CODE,
    TWO_SIDED_CODE,
    UNLIT_CODE,
    EmitterTables,
    emitter_tables,
    map_cells,
    map_mean_radiance,
)
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import quad, sphere
from ssdo_gl.scene.light_bodies import body_lights
from ssdo_gl.scene.lights import (
    DirectionalLight,
    PointLight,
    RectangleLight,
    SpotLight,
    kind_number,
)
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

GLOW = Material(emission=(3.0, 2.0, 1.0))
DULL = Material()
# float32 tables.
ROUNDING = 1e-6


def scene_of(meshes, objects, *, materials=(DULL, GLOW), lights=(), environment=None) -> Scene:
    camera = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    return Scene(
        tuple(meshes), tuple(materials), tuple(objects), camera, tuple(lights), environment
    )


def tables_of(scene: Scene, map_power: float = 0.0) -> EmitterTables:
    return emitter_tables(build_bvh(scene), scene, map_power)


def codes(tables: EmitterTables) -> list[int]:
    return [int(code) for code in tables.entries[:, 0, 3]]


def test_a_glowing_panel_is_one_parallelogram_and_a_sphere_its_triangles() -> None:
    ball = sphere(8)
    scene = scene_of([quad(), ball], [SceneObject(0, 1), SceneObject(1, 1)])
    tables = tables_of(scene)
    kinds = np.array(codes(tables)) & 63
    # Neither stands for a light of the scene: one group of light that is no direct light.
    assert tables.group_count == 1
    assert tables.groups[0, 0, 2] == 1.0 + UNLIT_CODE
    areas = tables.entries[:, 2, 3]
    corners = build_bvh(scene).triangles.positions.astype(np.float64)
    total = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    ).sum()
    assert areas.sum() == pytest.approx(0.5 * total, rel=1e-5)
    assert (kinds == KIND_PARALLELOGRAM).any()
    assert np.isin(kinds, [KIND_PARALLELOGRAM, KIND_TRIANGLE]).all()
    # All alike in radiance: drawn in proportion to area.
    np.testing.assert_allclose(tables.entries[:, 1, 3], areas / areas.sum(), rtol=1e-5)
    assert np.all(np.array(codes(tables)) & BODY_CODE)


def test_probabilities_add_up_and_the_density_is_theirs() -> None:
    lights = [
        PointLight((0.0, 2.0, 0.0), (1.0, 1.0, 1.0)),
        RectangleLight((0, 3, 0), (1, 0, 0), (0, 0, 1), (2.0, 2.0, 2.0), visible=False),
    ]
    scene = scene_of([quad(), sphere(6)], [SceneObject(0, 1), SceneObject(1, 0)], lights=lights)
    tables = tables_of(scene)
    assert tables.group_count == 3
    assert tables.groups[:, 0, 3].sum() == pytest.approx(1.0, rel=ROUNDING)
    np.testing.assert_allclose(np.cumsum(tables.groups[:, 0, 3]), tables.groups[:, 1, 0], rtol=1e-5)
    for first, count in tables.groups[:, 0, :2].astype(int):
        share = tables.entries[first : first + count, 1, 3]
        assert share.sum() == pytest.approx(1.0, rel=1e-5)
        np.testing.assert_allclose(
            np.cumsum(share), tables.entries[first : first + count, 3, 3], rtol=1e-5
        )
    # A point of the body is drawn with the group's share, over its area.
    body = next(g for g in tables.groups if int(codes(tables)[int(g[0, 0])]) & BODY_CODE)
    area = tables.entries[int(body[0, 0]), 2, 3]
    mean_emission = np.mean(GLOW.emission)
    assert body[0, 3] / area == pytest.approx(tables.density * mean_emission, rel=1e-5)


def test_power_decides_whatever_the_kind() -> None:
    # A point of intensity I sends 4 pi I; a rectangle of radiance L and area A pi L A.
    point = PointLight((0.0, 2.0, 0.0), (1.0, 1.0, 1.0))
    panel = RectangleLight((0, 3, 0), (2, 0, 0), (0, 0, 2), (1.0, 1.0, 1.0), visible=False)
    both = dataclasses.replace(panel, two_sided=True)
    for lamp, factor in ((panel, 1.0), (both, 2.0)):
        tables = tables_of(scene_of([sphere(6)], [SceneObject(0, 0)], lights=[point, lamp]))
        shares = tables.groups[:, 0, 3]
        assert shares[0] / shares[1] == pytest.approx(1.0 / factor, rel=1e-5)


def test_a_body_replaces_all_lights_that_stand_for_it() -> None:
    stand_ins = [
        RectangleLight((0, i, 0), (1, 0, 0), (0, 0, 1), (1.0,) * 3, visible=False, name="ball")
        for i in range(3)
    ]
    other = RectangleLight((0, 9, 0), (1, 0, 0), (0, 0, 1), (1.0,) * 3, visible=False, name="own")
    sun = DirectionalLight((0.0, -1.0, 0.0), (1.0, 1.0, 1.0))
    panel = RectangleLight((0, 0, 0), (1, 0, 0), (0, 1, 0), GLOW.emission)
    lights = [sun, panel, *stand_ins, other]
    scene = scene_of(
        [quad(), sphere(6)], [SceneObject(0, 1, light=1), SceneObject(1, 1, light=2)], lights=lights
    )
    assert body_lights(scene) == {1: range(1, 2), 2: range(2, 5)}
    tables = tables_of(scene)
    # Two bodies, the sun and the rectangle that stands for itself.
    assert tables.group_count == 4
    kinds = np.array(codes(tables))
    assert (kinds & 63 == KIND_LIGHT + kind_number(sun)).sum() == 1
    assert ((kinds & 63 == KIND_PARALLELOGRAM) & (kinds & BODY_CODE == 0)).sum() == 1
    # All of it is direct light with a shadow: mode 1 + 4. The ball's lights lie within it.
    modes = tables.groups[:, 0, 2]
    assert sorted(modes) == [5.0, 5.0, 5.0, 5.0 + STAND_IN_CODE]
    (within,) = tables.groups[modes > 5.0, 0, 1]
    assert within == (kinds & BODY_CODE > 0).sum() - 1


def test_shadow_modes_and_sides_are_kept() -> None:
    lights = [
        PointLight((0, 2, 0), (1.0,) * 3, shadow="none"),
        SpotLight((0, 2, 0), (0, -1, 0), (1.0,) * 3, 10.0, 40.0, shadow="ssdo"),
        RectangleLight((0, 3, 0), (1, 0, 0), (0, 0, 1), (1.0,) * 3, visible=False, two_sided=True),
    ]
    scene = scene_of([sphere(6)], [SceneObject(0, 0)], lights=lights)
    tables = tables_of(scene)
    np.testing.assert_array_equal(tables.groups[:, 0, 2], [4.0, 6.0, 5.0])
    point, spot = (KIND_LIGHT + kind_number(light) for light in lights[:2])
    assert codes(tables) == [point, spot, KIND_PARALLELOGRAM + TWO_SIDED_CODE]
    inner, outer = np.cos(np.radians([10.0, 40.0]))
    numbers = [1.0 - outer, 1.0 / (inner - outer)]
    np.testing.assert_allclose(tables.entries[1, 2, :2], numbers, rtol=1e-5)


def test_lengths_are_those_of_the_frame() -> None:
    light = PointLight((0.0, 5.0, 0.0), (9.0, 9.0, 9.0))
    ball = sphere(6)
    ball = dataclasses.replace(ball, positions=ball.positions * 10.0 + [0.0, 1.0, 0.0])
    scene = scene_of([ball], [SceneObject(0, 0)], lights=[light])
    unit = build_bvh(scene).triangles.half_diagonal
    entry = tables_of(scene).entries[0]
    np.testing.assert_allclose(entry[0, :3], [0.0, 4.0 / unit, 0.0], atol=1e-6)
    np.testing.assert_allclose(entry[3, :3], 9.0 / unit**2, rtol=1e-6)


def test_nothing_that_shines_gives_no_groups() -> None:
    tables = tables_of(scene_of([sphere(6)], [SceneObject(0, 0)]))
    assert (tables.group_count, tables.density) == (0, 0.0)
    black = PointLight((0.0, 5.0, 0.0), (0.0, 0.0, 0.0))
    assert tables_of(scene_of([sphere(6)], [SceneObject(0, 0)], lights=[black])).group_count == 0


def test_the_map_is_the_last_group() -> None:
    image = np.ones((8, 16, 3), np.float32)
    sun = DirectionalLight((0.0, -1.0, 0.0), (4.0, 4.0, 4.0))
    scene = scene_of(
        [sphere(6)], [SceneObject(0, 0)], lights=[sun], environment=MapEnvironment(image)
    )
    tables = tables_of(scene, map_mean_radiance(image))
    assert tables.group_count == 2
    assert codes(tables)[-1] == KIND_MAP
    # The sun sends pi E through the disk of the scene, the sky 4 pi^2 L.
    shares = tables.groups[:, 0, 3]
    assert shares[1] / shares[0] == pytest.approx(4.0 * np.pi / 4.0, rel=1e-5)


@pytest.mark.parametrize("shape", [(16, 32), (200, 400), (129, 300)])
def test_map_cells_are_drawn_in_proportion_and_none_is_forgotten(shape) -> None:
    rng = np.random.default_rng(0)
    image = (rng.uniform(size=(*shape, 3)) ** 8).astype(np.float32)
    image[: shape[0] // 4] = 0.0
    cells = map_cells(image).astype(np.float64)
    rows, columns = cells.shape[:2]
    assert rows <= 128
    flat = cells.reshape(-1, 4)
    # What the alias method draws: a cell's own share and what others pass on to it.
    drawn = flat[:, 0] / len(flat)
    np.add.at(drawn, flat[:, 1].astype(int), (1.0 - flat[:, 0]) / len(flat))
    edges = np.cos(np.pi * np.arange(rows + 1) / rows)
    angle = np.repeat((edges[:-1] - edges[1:]) * 2.0 * np.pi / columns, columns)
    np.testing.assert_allclose(drawn, flat[:, 2] * angle, atol=1e-7)
    assert drawn.sum() == pytest.approx(1.0)
    # Every texel with light lies in cells with a density.
    y, x = np.nonzero(image.sum(axis=2) > 0.0)
    row = ((y + 0.5) / shape[0] * rows).astype(int)
    column = ((x + 0.5) / shape[1] * columns).astype(int)
    assert np.all(cells[row, column, 2] > 0.0)


def test_mean_radiance_weighs_by_solid_angle() -> None:
    image = np.zeros((64, 128, 3), np.float32)
    image[:16] = 1.0  # down to 45 degrees from the pole
    expected = (1.0 - np.cos(np.pi / 4.0)) / 2.0
    assert map_mean_radiance(image) == pytest.approx(expected, rel=1e-6)


def test_triangles_of_different_emission_are_not_joined() -> None:
    panel = quad()
    halves = [Mesh(panel.positions, panel.triangles[i : i + 1]) for i in range(2)]
    bright = Material(emission=(9.0, 9.0, 9.0))
    scene = scene_of(halves, [SceneObject(0, 1), SceneObject(1, 2)], materials=(DULL, GLOW, bright))
    tables = tables_of(scene)
    assert sorted(np.array(codes(tables)) & 63) == [KIND_TRIANGLE, KIND_TRIANGLE]
    shares = sorted(tables.entries[:, 1, 3])
    np.testing.assert_allclose(shares, [2.0 / 11.0, 9.0 / 11.0], rtol=1e-5)
