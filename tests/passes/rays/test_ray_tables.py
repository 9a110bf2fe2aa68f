"""Tables for rays: made once for what they are made from, looked up by nobody."""

from __future__ import annotations

import dataclasses
from collections import Counter

import numpy as np
import pytest
from passes.pass_harness import box, make_scene, quad

from ssdo_gl.passes.rays import bvh_upload, ray_tables
from ssdo_gl.passes.rays.ray_libraries import RECORDS_PER_ROW, record_texture
from ssdo_gl.raytracing import bvh as bvh_module
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (16, 12)
CAMERA = Camera((0.0, 1.5, 4.0), (0.0, 0.0, 0.0))
# What takes time that grows with the triangles, by where it is called from.
EXPENSIVE = (
    (bvh_upload, "cached_bvh"),
    (bvh_upload, "material_words"),
    (bvh_module, "content_key"),
    (bvh_module, "build_bvh"),
    (ray_tables, "surface_table"),
    (ray_tables, "material_table"),
    (ray_tables, "emitter_tables"),
    (Scene, "bounds"),
    (Mesh, "bounds"),
)


@pytest.fixture
def calls(monkeypatch):
    """How often each of `EXPENSIVE` was called, by name."""
    counter: Counter[str] = Counter()
    for owner, name in EXPENSIVE:
        original = getattr(owner, name)

        def counted(*args, _name=f"{owner.__name__}.{name}", _original=original, **more):
            counter[_name] += 1
            return _original(*args, **more)

        monkeypatch.setattr(owner, name, counted)
    return counter


def room() -> Scene:
    """A floor and a box under a panel that glows and a point of light."""
    panel = RectangleLight((-0.5, 2.0, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (5.0,) * 3)
    return make_scene(
        [
            quad((-3, 0, 3), (6, 0, 0), (0, 0, -6)),
            box((-0.5, 0, -0.5), (0.5, 1, 0.5)),
            quad((-0.5, 2, -0.5), (1, 0, 0), (0, 0, 1)),
        ],
        materials=[Material(), Material(emission=(5.0,) * 3)],
        objects=[SceneObject(0, 0), SceneObject(1, 0), SceneObject(2, 1, light=0)],
        lights=[panel, PointLight((2.0, 3.0, 2.0), (9.0,) * 3)],
        camera=CAMERA,
    )


def moved(scene: Scene, number: int) -> Camera:
    x, y, z = scene.camera.position
    return dataclasses.replace(scene.camera, position=(x + 0.01 * number, y, z))


@pytest.mark.parametrize(
    "settings",
    [
        Settings("bounce", size=SIZE, shadows="traced", shadow_rays=1),
        Settings(size=SIZE, method="reference-ao", spp=1),
        Settings(size=SIZE, method="reference-near", spp=1),
        Settings(size=SIZE, method="reference-gi", spp=1),
    ],
    ids=lambda settings: f"{settings.method}-{settings.shadows}",
)
def test_a_second_frame_looks_nothing_up(device, calls, settings) -> None:
    scene = room()
    with Renderer(scene, settings, device=device) as renderer:
        renderer.time_frame(["beauty"])
        assert calls["ssdo_gl.passes.rays.bvh_upload.cached_bvh"] == 1
        calls.clear()
        for number in (1, 2):
            times = renderer.time_frame(["beauty"], camera=moved(scene, number), number=number)
            assert any(row.ran for row in times.passes)
        assert calls == {}


def test_light_that_changes_does_not_touch_the_triangles(device, calls) -> None:
    scene = room()
    settings = Settings("bounce", size=SIZE, shadows="traced", shadow_rays=1)
    with Renderer(scene, settings, device=device) as renderer:
        renderer.time_frame(["beauty"])
        calls.clear()
        brighter = dataclasses.replace(scene.lights[1], intensity=(20.0,) * 3)
        renderer.use_scene(dataclasses.replace(scene, lights=(scene.lights[0], brighter)))
        renderer.time_frame(["beauty"])
        assert calls["ssdo_gl.passes.rays.ray_tables.emitter_tables"] == 1
        assert calls["ssdo_gl.passes.rays.ray_tables.surface_table"] == 0
        assert calls["ssdo_gl.raytracing.bvh.build_bvh"] == 0


def test_a_table_has_no_more_rows_than_its_records_fill(device) -> None:
    count = 4 * RECORDS_PER_ROW + 1
    table = record_texture(
        device.gl, count, "u4", lambda span: np.zeros((len(range(count)[span]), 16), np.uint32)
    )
    assert table.height == 5


def test_a_second_renderer_of_the_same_content_does_not_build_again(device, calls) -> None:
    settings = Settings(size=SIZE, method="reference-ao", spp=1)
    for _ in range(2):
        with Renderer(room(), settings, device=device) as renderer:
            renderer.time_frame(["beauty"])
    assert calls["ssdo_gl.passes.rays.bvh_upload.cached_bvh"] == 2
    assert calls["ssdo_gl.raytracing.bvh.build_bvh"] <= 1


def test_a_lamp_that_stops_casting_shadows_is_as_if_it_never_had(device) -> None:
    """Its body passes through everything, which rays read from the triangles' words."""
    settings = Settings(size=SIZE, method="reference-gi", spp=8)
    scene = room()
    unshadowed = dataclasses.replace(scene.lights[0], shadow="none")
    changed = dataclasses.replace(scene, lights=(unshadowed, scene.lights[1]))
    with Renderer(changed, settings, device=device) as renderer:
        wanted = renderer.render(["beauty"]).images["beauty"]
    with Renderer(scene, settings, device=device) as renderer:
        before = renderer.render(["beauty"]).images["beauty"]
        renderer.use_scene(changed)
        found = renderer.render(["beauty"]).images["beauty"]
    assert not np.array_equal(before, wanted)
    np.testing.assert_array_equal(found, wanted)
