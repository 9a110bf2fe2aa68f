"""The planner asks anew what may have changed, and returns again what has not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.pass_harness import box, make_scene

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.planning import planner as planner_module
from ssdo_gl.planning.planner import MOST_PLANS, Planner
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SCENE = load_scene("cornell_meso")
SETTINGS = Settings("bounce", radius=0.3)
WANTED = ("beauty",)


def view_of(camera: Camera, size=(64, 36), near=0.1, far=20.0) -> FrameView:
    return FrameView(
        size=size,
        position_ws=np.asarray(camera.position, dtype=np.float64),
        view_from_world=camera.view_from_world_rotation(),
        tan_half_fov=camera.tan_half_fov(size[0] / size[1]),
        near=near,
        far=far,
    )


def away(camera: Camera) -> Camera:
    """The same camera, turned around."""
    behind = 2.0 * np.asarray(camera.position) - np.asarray(camera.target)
    return dataclasses.replace(camera, target=tuple(map(float, behind)))


def test_the_same_frame_is_the_same_plan():
    planner, view = Planner(), view_of(SCENE.camera)
    first = planner.plan(SCENE, SCENE, SETTINGS, WANTED, view)
    assert planner.plan(SCENE, SCENE, SETTINGS, WANTED, view_of(SCENE.camera)) is first


def test_another_view_with_the_same_decisions_keeps_its_passes():
    planner = Planner()
    first = planner.plan(SCENE, SCENE, SETTINGS, WANTED, view_of(SCENE.camera))
    nearer = dataclasses.replace(SCENE.camera, fov_y=SCENE.camera.fov_y * 0.99)
    second = planner.plan(SCENE, SCENE, SETTINGS, WANTED, view_of(nearer))
    assert second is not first and second.graph is first.graph
    assert second.decided == first.decided and second.scene is first.scene


def test_a_view_of_nothing_needs_nothing_and_the_way_back_is_remembered():
    planner = Planner()
    front, back = view_of(SCENE.camera), view_of(away(SCENE.camera))
    first = planner.plan(SCENE, SCENE, SETTINGS, WANTED, front)
    empty = planner.plan(SCENE, SCENE, SETTINGS, WANTED, back)
    assert first.decided.runs("bounce") and not empty.decided.runs("bounce", "direct")
    assert planner.plan(SCENE, SCENE, SETTINGS, WANTED, front).graph is first.graph


def test_other_settings_or_images_are_another_plan():
    planner, view = Planner(), view_of(SCENE.camera)
    first = planner.plan(SCENE, SCENE, SETTINGS, WANTED, view)
    direct = dataclasses.replace(SETTINGS, method="direct")
    assert not planner.plan(SCENE, SCENE, direct, WANTED, view).decided.runs("bounce")
    again = planner.plan(SCENE, SCENE, SETTINGS, WANTED, view)
    assert again.decided == first.decided
    more = planner.plan(SCENE, SCENE, SETTINGS, (*WANTED, "depth"), view)
    assert set(more.pipeline.outputs) == {"beauty", "depth"}


def test_few_plans_are_kept():
    planner, view = Planner(), view_of(SCENE.camera)
    names = ("direct", "directional", "bounce", "visibility", "albedo", "depth", "normal_ws")
    for a in names:
        for b in names:
            wanted = tuple(dict.fromkeys((a, b)))
            planner.plan(SCENE, SCENE, SETTINGS, wanted, view)
    assert len(planner._plans) == MOST_PLANS


@pytest.mark.parametrize("effects", ["auto", "full"])
def test_passes_see_the_scene_without_lights_that_cannot_matter(effects):
    lamp = SCENE.lights[0]
    off = dataclasses.replace(lamp, radiance=(0.0, 0.0, 0.0))
    scene = dataclasses.replace(SCENE, lights=(lamp, off))
    settings = dataclasses.replace(SETTINGS, effects=effects)
    planned = Planner().plan(scene, scene, settings, WANTED, view_of(SCENE.camera))
    assert planned.scene.lights[0] == lamp
    assert planned.scene.lights[1].shadow == ("none" if effects == "auto" else off.shadow)


def test_content_is_looked_up_once_for_each_scene(monkeypatch):
    planner, calls = Planner(), []
    from ssdo_gl.planning import planner as module

    original = module.analyse
    monkeypatch.setattr(module, "analyse", lambda scene: calls.append(scene) or original(scene))
    for fov in (40.0, 41.0, 42.0):
        camera = dataclasses.replace(SCENE.camera, fov_y=fov)
        planner.plan(SCENE, SCENE, SETTINGS, WANTED, view_of(camera))
    assert calls == [SCENE]


def two_boxes() -> Scene:
    """Two boxes on nothing, side by side, before a lamp."""
    meshes = (box((-2.0, -1, -1), (-1.0, 0, 0)), box((1.0, -1, -1), (2.0, 0, 0)))
    lamp = PointLight((0.0, 3.0, 4.0), (5.0, 5.0, 5.0))
    camera = Camera((0.0, 0.5, 3.0), (0.0, -0.5, 0.0), fov_y=60.0)
    return make_scene(meshes, lights=(lamp,), camera=camera)


@pytest.mark.parametrize("method", ["bounce", "ssao", "gi"])
def test_a_planner_that_remembers_decides_as_one_that_does_not(method):
    dice = np.random.default_rng(5)
    settings, scene = Settings(radius=0.3, method=method), two_boxes()
    planner, seen = Planner(), set()
    for _ in range(40):
        # From inside of a box to far off.
        position = dice.normal(size=3) * 10.0 ** dice.uniform(-0.5, 1.0)
        camera = dataclasses.replace(scene.camera, position=tuple(map(float, position)))
        camera = camera if dice.random() < 0.8 else away(camera)
        distance = float(np.linalg.norm(position))
        view = view_of(camera, near=max(0.1, distance - 5.0), far=distance + 5.0)
        found = planner.plan(scene, scene, settings, WANTED, view)
        expected = Planner().plan(scene, scene, settings, WANTED, view)
        assert found.decided == expected.decided
        assert found.gloss_region == expected.gloss_region
        assert found.emission_region == expected.emission_region
        assert found.scene.lights == expected.scene.lights
        seen.add(found.decided)
    assert len(seen) > 2, "the flight meets views that are decided in several ways"


def test_a_flight_past_the_same_bodies_is_decided_once(monkeypatch):
    asked = []
    decide = planner_module.decide
    monkeypatch.setattr(
        planner_module, "decide", lambda request: asked.append(request) or decide(request)
    )
    planner = Planner()
    for number in range(5):
        camera = dataclasses.replace(SCENE.camera, fov_y=SCENE.camera.fov_y - 0.1 * number)
        planner.plan(SCENE, SCENE, SETTINGS, WANTED, view_of(camera))
    assert len(asked) == 1
