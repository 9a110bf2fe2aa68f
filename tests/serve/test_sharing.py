"""Several viewers of one scene on one device: what they share, and what each one frees."""

from __future__ import annotations

import dataclasses
import gc
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import moderngl
import numpy as np
import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.shared_scene import SharedScene

SIZE = (48, 27)
# `gi` at its least: everything that is made of the scene alone is part of it.
SETTINGS = Settings("gi", size=SIZE, samples=8, steps=2)
OF_SCENE = (
    *("bvh_upload", "surface_tables", "material_table", "emitter_tables"),
    *("surfels", "surfel_rays", "surfel_direct", "surface_cache", "shadow_map"),
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("corner")


@pytest.fixture
def shared(device: Device, scene: Scene) -> Iterator[SharedScene]:
    device.activate()
    shared = SharedScene(device.gl, scene)
    yield shared
    shared.geometry.release()


@pytest.fixture
def make(
    device: Device, shaders: ShaderLibrary, scene: Scene, shared: SharedScene
) -> Iterator[Callable[..., Renderer]]:
    made: list[Renderer] = []

    def make(settings: Settings = SETTINGS, of: Scene = scene) -> Renderer:
        made.append(Renderer(of, settings, device=device, shaders=shaders, shared=shared))
        return made[-1]

    yield make
    for renderer in made:
        renderer.release()


def live_objects(device: Device) -> Counter[str]:
    """Count what there is on the device, by its kind."""
    gc.collect()
    device.activate()
    kinds = moderngl.Texture, moderngl.Buffer, moderngl.Framebuffer, moderngl.VertexArray
    things = [item for item in gc.get_objects() if type(item) in kinds]
    return Counter(
        type(item).__name__
        for item in things
        if item.ctx is device.gl and type(item.mglo).__name__ != "InvalidObject"
    )


def settled(renderer: Renderer, camera: Camera, **more: Any) -> np.ndarray:
    """Draw live frames until nothing is left to do; return the picture."""
    for _ in range(60):
        drawing = renderer.draw(["display"], camera=camera, **more)
        if drawing.is_settled:
            break
    assert drawing.is_settled
    return drawing.planes["display"].read()[..., :3].copy()


def made_by(renderer: Renderer, name: str) -> Any:
    return renderer._executor._results.present[name]


def test_second_viewer_makes_nothing_that_no_view_is_part_of(make, device, scene):
    first, second = make(), make()
    settled(first, scene.camera)
    before = live_objects(device)
    drawing = second.draw(["display"], camera=scene.camera.orbit(20))
    ran = {row.name for row in drawing.passes if row.ran}
    assert ran.isdisjoint(OF_SCENE) and "gbuffer" in ran
    for name in OF_SCENE:
        assert made_by(first, name) is made_by(second, name)
    more = live_objects(device) - before
    assert more["Buffer"] == 0 and more["Texture"] > 0


def test_who_leaves_frees_all_but_what_others_hold(make, device, scene):
    first = make()
    picture = settled(first, scene.camera)
    counts = []
    for _ in range(4):
        guest = make()
        settled(guest, scene.camera.orbit(10))
        guest.release()
        counts.append(live_objects(device))
    alone = counts[0]
    assert counts == [alone] * 4
    assert np.array_equal(settled(first, scene.camera), picture)
    # With the last one goes what all have shared, but for the scene's triangles.
    first.release()
    assert live_objects(device)["Texture"] <= alone["Texture"] - len(OF_SCENE)


def test_each_viewer_gets_the_picture_that_it_would_have_alone(make, device, shaders, scene):
    cameras = [scene.camera, scene.camera.orbit(25)]
    wanted = []
    for camera in cameras:
        with Renderer(scene, SETTINGS, device=device, shaders=shaders) as alone:
            wanted.append(settled(alone, camera))
    viewers = [make(), make()]
    # In turns, before either one has settled.
    for _ in range(3):
        for viewer, camera in zip(viewers, cameras, strict=True):
            viewer.draw(["display"], camera=camera)
    for viewer, camera, picture in zip(viewers, cameras, wanted, strict=True):
        assert np.abs(settled(viewer, camera) - picture).max() < 1.0 / 255.0


def test_other_light_of_one_viewer_leaves_the_others_theirs(make, device, shaders, scene):
    lamp = scene.lights[0]
    dark = scene.with_light(0, lamp.with_emitted(tuple(0.2 * c for c in lamp.emitted)))
    with Renderer(dark, SETTINGS, device=device, shaders=shaders) as alone:
        wanted = settled(alone, scene.camera)
    first, second = make(), make()
    picture = settled(first, scene.camera)
    settled(second, scene.camera)
    second.use_scene(dark)
    assert np.abs(settled(second, scene.camera) - wanted).max() < 1.0 / 255.0
    kept = first.draw(["display"], camera=scene.camera)
    assert not any(row.ran for row in kept.passes)
    assert np.array_equal(settled(first, scene.camera), picture)
    assert made_by(first, "surface_cache") is not made_by(second, "surface_cache")
    assert made_by(first, "bvh_upload") is made_by(second, "bvh_upload")
    # Back again, it takes what the other one still holds.
    second.use_scene(scene)
    assert np.array_equal(settled(second, scene.camera), picture)
    assert made_by(first, "surface_cache") is made_by(second, "surface_cache")


def test_viewers_at_two_times_of_an_animation_keep_theirs(device, shaders):
    scene = load_scene("carousel")
    settings = dataclasses.replace(SETTINGS, method="direct")
    shared = SharedScene(device.gl, scene)
    times = (0.0, 1.25)
    viewers = [
        Renderer(scene, settings, device=device, shaders=shaders, shared=shared) for _ in times
    ]
    pictures = [
        settled(viewer, scene.camera, seconds=seconds)
        for viewer, seconds in zip(viewers, times, strict=True)
    ]
    assert np.abs(pictures[0] - pictures[1]).max() > 0.1
    for viewer, seconds, picture in zip(viewers, times, pictures, strict=True):
        drawing = viewer.draw(["display"], camera=scene.camera, seconds=seconds)
        assert not any(row.ran for row in drawing.passes)
        viewer.forget()
        assert np.array_equal(settled(viewer, scene.camera, seconds=seconds), picture)
    # At the same time they are of one scene.
    last = settled(viewers[0], scene.camera, seconds=times[1])
    assert np.array_equal(last, pictures[1])
    assert made_by(viewers[0], "shadow_map") is made_by(viewers[1], "shadow_map")
    for viewer in viewers:
        viewer.release()
    shared.geometry.release()
