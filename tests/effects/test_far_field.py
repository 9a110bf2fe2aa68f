"""Light from beyond R against closed forms."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from passes.pass_harness import box, make_scene, quad

from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.passes.far_probes import FarFieldSettings, tile_count
from ssdo_gl.passes.temporal import TemporalPass, TemporalSettings
from ssdo_gl.render_result import Drawing, RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights.point_light import PointLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

SIZE = (48, 32)
RADIUS = 0.1
SKY = ConstantEnvironment((1.0, 0.5, 0.25))
GREY = Material(albedo=(0.5,) * 3)
FLOOR = quad([-1, 0, 1], [2, 0, 0], [0, 0, -2])
CAMERA = Camera((0.0, 0.5, 0.9), (0.0, 0.0, 0.0), fov_y=40.0)


def picture(scene: Scene, method: str = "gi", **fields: object) -> np.ndarray:
    settings = Settings(method=method, size=SIZE, radius=RADIUS, **fields)
    with Renderer(scene, settings) as renderer:
        return renderer.render(("beauty",)).images["beauty"][..., :3]


def test_no_sky_comes_into_a_closed_box() -> None:
    room = box([-1, 0, -1], [1, 1, 1])
    scene = make_scene([room], materials=[GREY], environment=SKY, camera=CAMERA)
    assert picture(scene, "bounce").mean() > 0.1
    assert picture(scene).max() == 0.0


def test_an_open_plane_has_the_whole_sky() -> None:
    scene = make_scene([FLOOR], materials=[GREY], environment=SKY, camera=CAMERA)
    found = picture(scene)[SIZE[1] // 2 :]
    whole = 0.5 * np.array(SKY.radiance)
    # The G-buffer holds albedo in 16 bits.
    assert found == pytest.approx(np.broadcast_to(whole, found.shape), rel=2e-5)


def test_half_a_sky_is_left_beside_an_endless_wall() -> None:
    # A black wall far beyond R, so wide that it fills half of the hemisphere above x = 0.
    wall = quad([3, -1000, 1000], [0, 0, -2000], [0, 2000, 0])
    materials = [GREY, Material(albedo=(0.0,) * 3)]
    objects = [SceneObject(0, 0), SceneObject(1, 1)]
    scene = make_scene(
        [FLOOR, wall], materials=materials, objects=objects, environment=SKY, camera=CAMERA
    )
    found = picture(scene)[SIZE[1] // 2 :, : SIZE[0] // 2].mean(axis=(0, 1))
    assert found == pytest.approx(0.25 * np.array(SKY.radiance), rel=0.03)


@pytest.mark.parametrize("albedo", [0.9, 0.99])
def test_a_closed_furnace_has_its_closed_form(albedo: float) -> None:
    # e (1 + a + a^2 + ...), with R far smaller than the box and as large.
    emission = 1.0
    glowing = Material(albedo=(albedo,) * 3, emission=(emission,) * 3, two_sided_emission=True)
    camera = Camera((0.2, 0.1, 0.3), (1.0, 0.3, 0.5))
    scene = make_scene([box([-1, -1, -1], [1, 1, 1])], materials=[glowing], camera=camera)
    for radius in (0.02, 0.5):
        settings = Settings(method="gi", size=SIZE, radius=radius)
        with Renderer(scene, settings) as renderer:
            found = renderer.render(("beauty",)).images["beauty"][..., :3]
        assert found.mean() == pytest.approx(emission / (1.0 - albedo), rel=0.01)


def test_a_box_that_stands_alone_needs_no_rays() -> None:
    block = box([-0.3, 0, -0.3], [0.3, 0.4, 0.3])
    scene = make_scene([block], materials=[GREY], environment=SKY, camera=CAMERA)
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=RADIUS)) as renderer:
        result = renderer.render(("beauty",))
    assert "far_probes" not in [item.name for item in result.passes if item.ran]
    full = picture(scene, effects="full")
    assert result.images["beauty"][..., :3] == pytest.approx(full, abs=1e-6)


LAMP = PointLight((0.2, 0.8, 0.1), (3.0, 2.0, 1.0))
ROOM = make_scene([box([-1, 0, -1], [1, 1, 1])], materials=[GREY], lights=[LAMP], camera=CAMERA)


def gi_renderer(**fields: object) -> Renderer:
    return Renderer(ROOM, Settings(method="gi", size=SIZE, radius=RADIUS, **fields))


def ran(result: RenderResult | Drawing, name: str) -> bool:
    return any(item.ran for item in result.passes if item.name == name)


def live(renderer: Renderer, index: int, camera: Camera = CAMERA, **more: Any) -> Drawing:
    return renderer.draw(("beauty",), camera=camera, index=index, count=16, **more)


def test_jittered_frames_of_a_view_share_its_rays() -> None:
    with gi_renderer() as renderer:
        assert ran(live(renderer, 0), "far_probes")
        frames = [live(renderer, index) for index in range(1, 12)]
        frames += [live(renderer, index) for index in range(12)]
    # Sixteen parts of the pixels' own rays.
    assert [ran(frame, "far_probes") for frame in frames] == 23 * [False]
    assert [ran(frame, "own_rays") for frame in frames] == 15 * [True] + 8 * [False]
    assert [frame.is_settled for frame in frames] == 14 * [False] + 9 * [True]
    assert not any(ran(frame, "cached_irradiance") for frame in frames)


def test_nothing_is_drawn_for_a_march_but_to_find_the_visibility() -> None:
    of_senders = ("cached_irradiance", "sender_radiance")
    with gi_renderer() as renderer:
        alone = renderer.render(("beauty",))
        beside = renderer.render(("beauty", "visibility"))
        frames = [live(renderer, index) for index in (0, 1)]
        frames.append(live(renderer, 0, dataclasses.replace(CAMERA, position=(0.3, 0.4, 0.9))))
    for drawn in (alone, *frames):
        assert not any(ran(drawn, name) for name in ("depth_layers", *of_senders))
    assert ran(beside, "depth_layers")
    assert not any(ran(beside, name) for name in of_senders)
    assert 0.5 < beside.images["visibility"].mean() < 1.0
    np.testing.assert_allclose(alone.images["beauty"], beside.images["beauty"], rtol=1e-6)


def test_a_picture_does_not_depend_on_the_frames_before_it() -> None:
    away = dataclasses.replace(CAMERA, position=(0.3, 0.4, 0.9))
    with gi_renderer(antialias=4) as renderer:
        first = renderer.render(("beauty",)).images["beauty"]
        renderer.render(("beauty",), camera=away)
        again = renderer.render(("beauty",)).images["beauty"]
    assert np.array_equal(first, again)


def test_a_view_that_moved_begins_as_any_other() -> None:
    def read(drawing: Drawing) -> np.ndarray:
        return np.array(drawing.planes["beauty"].read())

    away = dataclasses.replace(CAMERA, position=(0.3, 0.4, 0.9))

    def draw_all(renderer: Renderer) -> list[np.ndarray]:
        return [read(live(renderer, index)) for index in (0, 1, 2, 3, 4, 0)]

    with gi_renderer(temporal="off") as renderer:
        first = draw_all(renderer)
        live(renderer, 0, away)
        again = draw_all(renderer)
    assert np.array_equal(first, again)


@pytest.mark.parametrize("moves", [".l..", ".lll.", "mmm.b...", "bbbbb..."])
def test_no_frame_goes_without_light_while_a_lamp_changes(moves: str) -> None:
    """m: the camera moves, l: a lamp gets darker, b: both."""
    scene = load_scene("corner")
    (lamp,) = scene.lights
    step, level, levels = 0.0, 1.0, []
    with Renderer(scene, Settings(method="gi", size=SIZE)) as renderer:
        for move in moves:
            if move in "lb":
                level *= 0.98
                color = (level * lamp.power,) * 3
                darker = dataclasses.replace(scene, lights=(lamp.with_emitted(color),))
                renderer.use_scene(darker)
            if move in "mb":
                step += 1e-3
            x, y, z = scene.camera.position
            camera = dataclasses.replace(scene.camera, position=(x + step, y, z))
            plane = renderer.draw(("directional",), camera=camera).planes["directional"]
            assert plane.texture is not None
            levels.append(float(read_texture(plane.texture)[..., :3].mean()))
    assert min(levels) > 0.8 * max(levels)


def test_frames_in_motion_go_on_from_the_view_at_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    original, averaged = TemporalPass._draw, []

    def record(
        item: TemporalPass,
        context: Any,
        current: Any,
        known: Any,
        most: int,
        *rest: Any,
        **how: Any,
    ) -> Any:
        averaged.append(most)
        return original(item, context, current, known, most, *rest, **how)

    monkeypatch.setattr(TemporalPass, "_draw", record)
    with gi_renderer() as renderer:
        at_rest(renderer)
        for step in range(1, 4):
            moved = dataclasses.replace(CAMERA, position=(0.3 + 0.01 * step, 0.4, 0.9))
            assert not live(renderer, 0, moved).is_settled
    # Of the view at rest, which the first frame in motion goes on from.
    assert averaged == [0, *3 * [TemporalSettings().frames_of_rays]]


def at_rest(renderer: Renderer, progress: ProgressCallback | None = None) -> np.ndarray:
    while not (drawing := live(renderer, 0, progress=progress)).is_settled:
        pass
    return drawing.planes["beauty"].read()


def test_what_is_bound_between_two_draws_changes_nothing() -> None:
    """As by a window, which shows its panel over a frame in the making."""
    with gi_renderer() as renderer:
        expected = at_rest(renderer)
    with gi_renderer() as renderer:
        other = renderer.device.gl.texture((1, 1), 4, b"\x80" * 16, dtype="f4")

        def show(*_: object) -> None:
            for unit in range(32):
                other.use(unit)

        np.testing.assert_array_equal(at_rest(renderer, show), expected)


@pytest.mark.parametrize(
    ("size", "given", "tile"),
    [
        ((1920, 1080), {}, 8),
        ((16384, 8192), {}, 8),
        ((1, 8193), {}, 16),
        ((1920, 1080), {"directions": 64}, 16),
        ((16384, 16384), {"directions": 64, "tile": 2}, 128),
    ],
)
def test_tiles_grow_where_the_map_of_their_probes_would_be_no_image(size, given, tile):
    fitting = FarFieldSettings(**given).fitting(size)
    assert fitting == FarFieldSettings(**{**given, "tile": tile})
    assert max(fitting.map_size(tile_count(size, tile))) <= 16384


def test_a_picture_taller_than_half_an_image_is_drawn(device, shaders):
    """It was a traceback: the map of its probes is twice as tall."""
    scene = load_scene("corner")
    means = []
    for height in (8192, 8200):
        settings = Settings(size=(1, height), method="gi", exposure=0.0)
        with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
            means.append(renderer.render(["beauty"]).images["beauty"][..., :3].mean())
    assert means[1] == pytest.approx(means[0], rel=0.01)
