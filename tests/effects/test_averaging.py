"""Frames of a window: what moves is averaged, what rests is as a snapshot is."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SETTINGS = Settings("bounce", size=(96, 54), samples=16, steps=8)
PIXELS_PER_FRAME = 0.125
# Of cornell_meso: its back wall between the blocks, in the shadow of both.
WALL = slice(16, 34), slice(52, 62)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("courtyard")


def camera_at(scene: Scene, pixels: float):
    """Return the scene's camera, moved to its right by `pixels` at its target."""
    camera = scene.camera
    ahead = np.subtract(camera.target, camera.position)
    right = np.cross(ahead, camera.up)
    footprint = 2.0 * np.tan(np.radians(camera.fov_y) / 2.0) * np.linalg.norm(ahead) / 54.0
    step = pixels * footprint * right / np.linalg.norm(right)
    moved = (tuple(np.add(place, step)) for place in (camera.position, camera.target))
    return dataclasses.replace(camera, **dict(zip(("position", "target"), moved, strict=True)))


def drawn(renderer: Renderer, pixels: float = 0.0, name: str = "bounce", seconds: float = 0.0):
    """Return an image of the next frame, and whether it stands for itself."""
    # Frames are averaged where something looks around in the depth buffer.
    wanted = [name, "bounce"]
    camera = camera_at(renderer.scene, pixels)
    drawing = renderer.draw(wanted, camera=camera, seconds=seconds)
    return drawing.planes[name].read()[..., :3], drawing.is_settled


def mean_change(device, shaders, scene, **changes) -> float:
    settings = dataclasses.replace(SETTINGS, **changes)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        frames = [drawn(renderer, PIXELS_PER_FRAME * i)[0] for i in range(14)]
    steps = [np.abs(b - a).mean() for a, b in itertools.pairwise(frames[6:])]
    return float(np.mean(steps) / np.mean(frames))


@pytest.mark.parametrize("changes", [{}, {"resolution_scale": 0.5}, {"effects": "full"}], ids=str)
def test_a_slow_pan_changes_the_bounce_less(device, shaders, scene, changes) -> None:
    """By less than two thirds: .51 were measured, .55 at half size."""
    before = mean_change(device, shaders, scene, temporal="off", **changes)
    assert mean_change(device, shaders, scene, **changes) < 0.67 * before


ALL_LIGHT = dataclasses.replace(SETTINGS, method="gi")


def test_soft_shadows_do_not_flicker_in_motion(device, shaders) -> None:
    """All frames look at the same points of lamps: a view that comes back has the same shadows."""
    room = load_scene("cornell_meso")
    with Renderer(room, ALL_LIGHT, device=device, shaders=shaders) as renderer:
        drawn(renderer, 1.0, "direct")  # at rest
        frames = [drawn(renderer, pixels, "direct")[0] for pixels in (0.0, 0.5, 0.0, 0.5)]
    assert not np.array_equal(frames[0], frames[1])
    assert np.array_equal(frames[0], frames[2])
    assert np.array_equal(frames[1], frames[3])


def test_shadows_of_bodies_that_move_do_not_lag(device, shaders) -> None:
    """Of what stood there before nothing is left."""
    room = load_scene("cornell_meso")
    sway = Motion(sway=(-0.4, 0.0, 0.0), period=4.0)
    objects = tuple(
        dataclasses.replace(item, motion=sway) if item.name == "tall block" else item
        for item in room.objects
    )
    room = dataclasses.replace(room, objects=objects)
    # So many that a frame at rest, which has fewer than one in motion, says the same.
    settings = dataclasses.replace(ALL_LIGHT, overrides={"direct.penumbra_rays": 256})
    with Renderer(room, settings, device=device, shaders=shaders) as renderer:
        for number in range(6):
            before, _ = drawn(renderer, PIXELS_PER_FRAME * number, "direct")
        found, _ = drawn(renderer, PIXELS_PER_FRAME * number, "direct", 1.0)
        expected, _ = drawn(renderer, PIXELS_PER_FRAME * number, "direct", 1.0)
    # Where the wall is seen before and after; of 180 pixels, whose noise is less than the change.
    levels = [float(image[WALL].mean()) for image in (before, found, expected)]
    assert abs(levels[1] - levels[2]) < 0.35 * abs(levels[0] - levels[2])


def of_a_pan(device, shaders, scene, names, **changes):
    """Return images of the last frame of a slow pan."""
    settings = dataclasses.replace(SETTINGS, **changes)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        for number in range(9):
            camera = camera_at(scene, PIXELS_PER_FRAME * number)
            planes = renderer.draw(names, camera=camera).planes
        return {name: planes[name].read()[..., :3] for name in names}


WHOLE = {"overrides": {"temporal.unfiltered": 0.0}}


def test_a_pan_shows_contact_shadows_that_a_filter_blurs(device, shaders, scene) -> None:
    """Of open directions, against many samples without filter; .80 of the error was measured."""
    names = ("directional", "bounce")
    exact = of_a_pan(device, shaders, scene, names, samples=1024, filter="none", temporal="off")
    found = of_a_pan(device, shaders, scene, names, samples=64)
    blurred = of_a_pan(device, shaders, scene, names, samples=64, **WHOLE)
    errors = [
        np.sqrt(np.mean((x - exact["directional"]) ** 2))
        for x in (found["directional"], blurred["directional"])
    ]
    assert errors[0] < 0.9 * errors[1]
    np.testing.assert_array_equal(found["bounce"], blurred["bounce"])


@pytest.mark.parametrize(
    ("changes", "is_sharper"),
    [
        ({}, True),
        ({"method": "ssdo"}, True),
        ({"method": "gi"}, False),
        ({"resolution_scale": 0.5}, False),
        ({"filter": "none"}, False),
    ],
    ids=str,
)
def test_which_pictures_are_averaged_before_the_filter(
    device, shaders, scene, changes, is_sharper
) -> None:
    one, other = (
        of_a_pan(device, shaders, scene, ("beauty",), **changes, **more)["beauty"]
        for more in ({}, WHOLE)
    )
    assert np.array_equal(one, other) != is_sharper


def test_what_comes_to_rest_is_the_single_frame(device, shaders, scene) -> None:
    with Renderer(scene, SETTINGS, device=device, shaders=shaders) as renderer:
        expected = renderer.render(["bounce"], camera=camera_at(scene, 2.0)).images["bounce"]
        assert drawn(renderer)[1]
        for pixels in (1.0, 2.0):
            moving, is_settled = drawn(renderer, pixels)
            assert not is_settled
        rest, is_settled = drawn(renderer, 2.0)
    assert is_settled
    assert not np.array_equal(moving, rest)
    np.testing.assert_array_equal(rest, expected[..., :3])


def test_a_single_picture_is_not_averaged(device, shaders, scene) -> None:
    images = []
    for temporal in ("on", "off"):
        settings = dataclasses.replace(SETTINGS, temporal=temporal)
        with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
            for pixels in (0.0, 1.0):
                result = renderer.render(["bounce"], camera=camera_at(scene, pixels))
            assert not any(row.name.startswith("temporal") for row in result.passes)
            images.append(result.images["bounce"])
    np.testing.assert_array_equal(*images)


@pytest.mark.parametrize(
    ("method", "moving", "is_averaged"),
    [("gi", "all", True), ("gi", "lights", False), ("bounce", "all", False)],
)
def test_lights_that_move_with_bodies_do_not_end_averages_of_gi(
    device, shaders, method, moving, is_averaged
) -> None:
    """Nor do lights that move alone end what their probes have found until then."""
    scene = load_scene("carousel")
    if moving == "lights":
        objects = tuple(dataclasses.replace(item, motion=None) for item in scene.objects)
        scene = dataclasses.replace(scene, objects=objects)
    images = []
    for temporal in ("on", "off"):
        settings = dataclasses.replace(SETTINGS, method=method, temporal=temporal)
        with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
            images.append([drawn(renderer, seconds=n / 30.0)[0] for n in range(3)][-1])
    assert np.array_equal(*images) != is_averaged


def test_a_light_that_goes_out_leaves_no_ghost(device, shaders) -> None:
    room = load_scene("cornell_meso")
    lights = tuple(light.with_emitted((0.0, 0.0, 0.0)) for light in room.lights)
    with Renderer(room, SETTINGS, device=device, shaders=shaders) as renderer:
        for number in range(4):
            drawn(renderer, number)
        renderer.use_scene(dataclasses.replace(room, lights=lights, environment=None))
        dark, _ = drawn(renderer, 4.0, "beauty")
    with Renderer(renderer.scene, SETTINGS, device=device, shaders=shaders) as renderer:
        expected, _ = drawn(renderer, 4.0, "beauty")
    np.testing.assert_array_equal(dark, expected)


@pytest.mark.parametrize(
    ("changes", "is_live", "runs"),
    [({}, True, True), ({"temporal": "off"}, True, False), ({}, False, False)],
)
def test_the_decision_is_told(device, shaders, scene, changes, is_live, runs) -> None:
    settings = dataclasses.replace(SETTINGS, **changes)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        if is_live:
            decisions = renderer.draw(["display"], camera=scene.camera).decisions
        else:
            decisions = renderer.render(["display"]).decisions
    (row,) = (row for row in decisions if row.effect == "averaging over frames")
    assert row.run == runs
