"""Bodies that glow: none of their panels is in the way of another's light."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


def baked(mesh: Mesh, matrix: FloatArray) -> Mesh:
    """Return the mesh as a file would hold it that has no matrices."""
    return dataclasses.replace(mesh, positions=math3d.transform_points(matrix, mesh.positions))


def lit_floor(world: FloatArray, *boxes: FloatArray) -> Scene:
    """Return a floor and one lamp made of `boxes`, unit cubes in the frame of `world`."""
    builder = SceneBuilder("lamp")
    white = builder.material(Material(albedo=(1.0, 1.0, 1.0)))
    glow = builder.material(Material(albedo=(0.0,) * 3, emission=(2.0,) * 3))
    on_floor = shapes.parallelogram_matrix((-4, 0, 4), (8, 0, 0), (0, 0, -8))
    lamp = [baked(shapes.box(), world @ matrix) for matrix in boxes]
    starts = np.cumsum([0, *(len(part.positions) for part in lamp)])
    mesh = Mesh(
        np.concatenate([part.positions for part in lamp]),
        np.concatenate([p.triangles + n for p, n in zip(lamp, starts[:-1], strict=True)]),
    )
    for key, part, material in (
        ("floor", baked(shapes.quad(), world @ on_floor), white),
        ("lamp", mesh, glow),
    ):
        index = builder.mesh(key, lambda part=part: part)
        builder.add(SceneObject(index, material, np.eye(4)[None], name=key))
    position, target = (
        tuple(math3d.transform_points(world, p)) for p in ((3.2, 2.5, 3.0), (0.0, 0.3, 0.0))
    )
    up = tuple(world[:3, 1] / np.linalg.norm(world[:3, 1]))
    return builder.build(Scene, Camera(position, target, up, 50.0), None)


def direct(scene: Scene, shadows: str, rays: int = 1) -> FloatArray:
    settings = Settings(size=(48, 36), method="direct", shadows=shadows, shadow_rays=rays)
    with Renderer(scene, settings) as renderer:
        return renderer.render(["direct"]).images["direct"].astype(np.float64)


def box(low: tuple[float, ...], high: tuple[float, ...]) -> FloatArray:
    """Return the matrix that makes the unit cube the box from `low` to `high`."""
    size = np.subtract(high, low)
    return math3d.translation(np.add(low, 0.5 * size)) @ math3d.scaling(size)


@pytest.mark.parametrize("stands", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_a_box_stands_in_nobody_s_light(seed: int, stands: bool) -> None:
    """It is convex and the floor is flat: with and without shadows are the same."""
    rng = np.random.default_rng(seed)
    turn = [0.0, rng.uniform(-180.0, 180.0), 0.0] if stands else rng.uniform(-180.0, 180.0, 3)
    world = math3d.scaling(10.0 ** rng.uniform(-2.0, 2.0)) @ math3d.rotation_euler(turn)
    x, y, z = rng.uniform(0.3, 1.2, 3)
    place = math3d.translation([rng.uniform(-1.0, 1.0), 0.0, rng.uniform(-1.0, 1.0)])
    scene = lit_floor(world, place @ box((0.0, 0.0, 0.0), (x, y, z)))
    with_maps, without = direct(scene, "map"), direct(scene, "none")
    assert len(scene.lights) == 6
    assert without.max() > 0.1
    # Where the floor touches the box, texels of the map are as large as the gap.
    assert with_maps.mean() == pytest.approx(without.mean(), rel=0.01)
    error = np.sqrt(((with_maps - without) ** 2).mean())
    assert error < 0.05 * without.mean()


def test_an_arm_of_a_lamp_still_shades_the_light_of_the_other() -> None:
    """An L: the floor on the far side of the tall arm gets less of the low one."""
    world = math3d.rotation_euler([0.0, 25.0, 0.0])
    scene = lit_floor(
        world, box((-1.0, 0.3, -0.3), (1.0, 0.5, 0.3)), box((-1.0, 0.5, -0.3), (-0.8, 1.7, 0.3))
    )
    assert len(scene.lights) == 12
    traced = direct(scene, "traced", 256)
    mapped, bare = direct(scene, "map"), direct(scene, "none")
    assert mapped.mean() == pytest.approx(traced.mean(), rel=0.03)
    assert bare.mean() > 1.05 * traced.mean()


def test_gi_tells_by_rays_what_stands_close_before_a_glowing_box() -> None:
    """A plate a two-hundredth of the lamp's length below it: its map cannot tell them apart."""
    lamp = box((-0.8, 1.0, -0.3), (0.8, 1.2, 0.3))
    scene = lit_floor(np.eye(4), lamp)
    plate = math3d.translation([0.0, 0.992, 0.0]) @ math3d.scaling([0.25, 1.0, 0.125])
    floor = next(item for item in scene.objects if item.light is None)
    shaded = dataclasses.replace(
        scene,
        objects=(*scene.objects, dataclasses.replace(floor, world_from_object=plate[None])),
    )
    traced = direct(shaded, "traced", 256)
    with Renderer(shaded, Settings(size=(48, 36), method="gi")) as renderer:
        by_gi = renderer.render(["direct"]).images["direct"].astype(np.float64)
    assert traced.mean() < 0.9 * direct(scene, "traced", 256).mean()
    assert by_gi.mean() == pytest.approx(traced.mean(), rel=0.02)
    dark = traced.max(axis=2) == 0.0
    assert dark.mean() > 0.2
    assert by_gi[dark].mean() < 0.01 * traced.mean()
