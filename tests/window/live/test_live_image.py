"""Images that stay on the device: what the window shows is what a snapshot writes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.headless.snapshot import extent_of
from ssdo_gl.images.display import ColorMapping, color_mapping, picture_of
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import AOVS, Settings
from ssdo_gl.window.canvas.presenter import DIVIDER_PX, Presenter, error_color
from ssdo_gl.window.live import live_image
from ssdo_gl.window.live.live_image import FrameRequest, LiveImage
from ssdo_gl.window.views import View, image_of, is_averaged, kind_of_image

SIZE = (64, 36)
SETTINGS = Settings("bounce", size=SIZE, samples=8, steps=4)
# Both round to 8 bits; the sum on the device is a float32, the snapshot's a float64.
ROUNDING = 1


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("cornell_meso")


@pytest.fixture
def live(device: Device, shaders: ShaderLibrary, scene: Scene) -> Iterator[LiveImage]:
    renderer = Renderer(scene, SETTINGS, device=device, shaders=shaders)
    image = LiveImage(renderer, device, shaders)
    yield image
    image.release()


@pytest.fixture
def presenter(device: Device, shaders: ShaderLibrary) -> Iterator[Presenter]:
    presenter = Presenter(device, shaders)
    yield presenter
    presenter.release()


def request(scene: Scene, aov: str = "beauty", settings: Settings = SETTINGS) -> FrameRequest:
    view = View(aov=aov, method=settings.method)
    image = image_of(view, settings)
    return FrameRequest(image, kind_of_image(view, image), scene.camera, settings)


def refine(image: LiveImage, goal: FrameRequest) -> int:
    frames = 0
    while image.update(goal):
        frames += 1
        assert frames < 1000
    return frames


def shown(presenter: Presenter, scene: Scene, view: View, *images: LiveImage) -> np.ndarray:
    kinds = (view.kind, view.kind)
    other = images[1] if len(images) > 1 else None
    presenter.draw(SIZE, view, images[0], other, kinds=kinds, bounds=scene.bounds(), exposure=0.0)
    return presenter.pixels().astype(int)


def test_refined_window_is_the_anti_aliased_snapshot(gl, device, live, presenter, scene) -> None:
    frames = refine(live, request(scene))
    assert frames == live_image.REFINE_FRAMES
    settings = dataclasses.replace(SETTINGS, antialias=live_image.REFINE_FRAMES)
    with Renderer(scene, settings, device=device) as renderer:
        expected = picture_of("display", renderer.render(["display"]).images["display"])
    picture = shown(presenter, scene, View(), live)
    assert expected.std() > 10.0
    assert np.abs(picture - expected).max() <= ROUNDING


def test_a_picture_in_motion_has_smooth_edges(gl, device, live, presenter, scene) -> None:
    """As smooth as they are of many offsets, but for a part; a reference stays as it was drawn."""
    settings = dataclasses.replace(SETTINGS, antialias=64)
    with Renderer(scene, settings, device=device) as renderer:
        many = picture_of("display", renderer.render(["display"]).images["display"]).astype(int)
    live.update(request(scene))
    smooth = shown(presenter, scene, View(), live)
    plain = picture_of("display", live.last_plane.read()).astype(int)
    assert np.square(smooth - many).mean() < 0.85 * np.square(plain - many).mean()
    live.update(request(scene, settings=dataclasses.replace(SETTINGS, method="reference-near")))
    assert live.edge_smoothing == 0.0


def test_a_picture_that_is_stretched_stays_as_it_was_drawn(
    gl, live, presenter, scene, monkeypatch
) -> None:
    """Its pixels are several of the window's, between which there is no edge to look for."""

    def stretched() -> np.ndarray:
        size = (4 * SIZE[0], 4 * SIZE[1])
        kinds, bounds = (ColorMapping.DISPLAY,) * 2, scene.bounds()
        presenter.draw(size, View(), live, None, kinds=kinds, bounds=bounds, exposure=0.0)
        return presenter.pixels()

    live.update(request(scene))
    assert live.edge_smoothing > 0.0
    picture = stretched()
    monkeypatch.setattr(LiveImage, "edge_smoothing", 0.0)
    assert np.array_equal(picture, stretched())


def test_what_is_not_settled_stays_out_of_the_average(live, scene, monkeypatch) -> None:
    settled = iter([False, False, True])
    draw = live.renderer.draw
    monkeypatch.setattr(
        live.renderer,
        "draw",
        lambda *names, **options: dataclasses.replace(
            draw(*names, **options), is_settled=next(settled, True)
        ),
    )
    counts = [live.sample_count for _ in range(4) if live.update(request(scene))]
    assert counts == [1, 1, 1, 2]
    assert refine(live, request(scene)) == live_image.REFINE_FRAMES - 2


@pytest.mark.parametrize("rays", [48, 64, 400])
def test_a_reference_sees_every_sub_pixel_offset_alike(live, scene, monkeypatch, rays) -> None:
    """Whatever time its frames take: edges are those of the other methods' average."""
    drawn: dict[int, int] = {}
    draw = live.renderer.draw

    def counted(*names, index, **options):
        offset = index % live_image.REFINE_FRAMES
        drawn[offset] = drawn.get(offset, 0) + live.renderer.settings.spp
        ms = 500.0 if len(drawn) % 5 == 0 else 1.0
        return dataclasses.replace(draw(*names, index=index, **options), frame_ms=ms)

    monkeypatch.setattr(live.renderer, "draw", counted)
    settings = dataclasses.replace(SETTINGS, method="reference-near", spp=rays)
    refine(live, request(scene, settings=settings))
    assert len(drawn) == live_image.REFINE_FRAMES
    assert set(drawn.values()) == {rays // live_image.REFINE_FRAMES}


@pytest.mark.parametrize("aov", [name for name in AOVS if name != "beauty"])
def test_every_image_looks_as_its_snapshot_does(gl, device, live, presenter, scene, aov) -> None:
    frames = refine(live, request(scene, aov))
    assert frames == (live_image.REFINE_FRAMES if is_averaged(color_mapping(aov)) else 1)
    settings = dataclasses.replace(SETTINGS, antialias=frames)
    with Renderer(scene, settings, device=device) as renderer:
        result = renderer.render([aov])
    expected = picture_of(aov, result.images[aov], extent_of(aov, scene, result)).astype(int)
    picture = shown(presenter, scene, View(aov=aov), live)
    assert picture.max() > 0 or expected.max() == 0
    assert np.abs(picture - expected).max() <= ROUNDING


def test_another_request_starts_again(gl, live, scene) -> None:
    refine(live, request(scene))
    moved = dataclasses.replace(scene.camera, position=(0.1, 0.0, 3.6))
    assert live.update(dataclasses.replace(request(scene), camera=moved))
    assert live.sample_count == 1
    assert not live.is_refined


def test_first_frame_after_a_move_is_the_same_whatever_came_before(
    gl, live, presenter, scene
) -> None:
    live.update(request(scene))
    fresh = shown(presenter, scene, View(), live)
    refine(live, request(scene))
    live.restart()
    live.update(request(scene))
    assert np.array_equal(shown(presenter, scene, View(), live), fresh)


def test_frame_given_up_between_two_passes_leaves_no_half_drawn_one(
    gl, live, presenter, scene
) -> None:
    class GivenUp(Exception):
        pass

    calls = []

    def give_up(what: str, done: int, total: int) -> None:
        calls.append(what)
        if len(calls) == 4:
            raise GivenUp

    live.update(request(scene))
    before = shown(presenter, scene, View(), live)
    moved = dataclasses.replace(scene.camera, position=(0.2, 0.1, 3.0))
    with pytest.raises(GivenUp):
        live.update(dataclasses.replace(request(scene), camera=moved), progress=give_up)
    # The textures of the frame before may be freed or drawn over by now.
    assert live.drawing is None
    # What was half drawn must not pass for either view's.
    live.update(request(scene))
    assert np.array_equal(shown(presenter, scene, View(), live), before)


def test_window_may_shrink_and_grow(gl, live, presenter, scene) -> None:
    for size in ((64, 36), (1, 1), (33, 70), (64, 36)):
        settings = dataclasses.replace(SETTINGS, size=size)
        live.update(request(scene, settings=settings))
        presenter.draw(
            size,
            View(),
            live,
            None,
            kinds=(ColorMapping.DISPLAY, ColorMapping.DISPLAY),
            bounds=scene.bounds(),
            exposure=0.0,
        )
        assert presenter.pixels().shape == (size[1], size[0], 3)


def test_smaller_picture_is_stretched_over_the_window(gl, live, presenter, scene) -> None:
    half = dataclasses.replace(SETTINGS, size=(SIZE[0] // 2, SIZE[1] // 2))
    live.update(request(scene, settings=half))
    coarse = shown(presenter, scene, View(), live)
    live.update(request(scene))
    fine = shown(presenter, scene, View(), live)
    assert coarse.shape == fine.shape
    # Same picture, softer: edges of a 2 px grid differ, the rest must not.
    assert np.median(np.abs(coarse - fine)) <= 3


def test_split_shows_each_method_on_its_side(gl, device, shaders, live, presenter, scene) -> None:
    direct = dataclasses.replace(SETTINGS, method="direct")
    renderer = Renderer(scene, direct, device=device, shaders=shaders)
    other = LiveImage(renderer, device, shaders)
    live.update(request(scene))
    other.update(request(scene, settings=direct))
    left, right = (shown(presenter, scene, View(), image) for image in (live, other))
    assert np.abs(left - right).max() > 10
    split = shown(presenter, scene, View(is_split=True, divider=0.25), live, other)
    edge = SIZE[0] // 4
    margin = DIVIDER_PX
    assert np.array_equal(split[:, : edge - margin], left[:, : edge - margin])
    assert np.array_equal(split[:, edge + margin :], right[:, edge + margin :])
    other.release()


def test_error_colours_say_too_bright_and_too_dark(
    gl, device, shaders, live, presenter, scene
) -> None:
    direct = dataclasses.replace(SETTINGS, method="direct")
    renderer = Renderer(scene, direct, device=device, shaders=shaders)
    other = LiveImage(renderer, device, shaders)
    error = View(is_error=True, error_range=0.5)

    def linear(settings: Settings) -> FrameRequest:
        return FrameRequest("beauty", ColorMapping.RADIANCE, scene.camera, settings)

    live.update(linear(SETTINGS))
    other.update(linear(direct))
    picture = shown(presenter, scene, error, live, other)
    swapped = shown(presenter, scene, error, other, live)
    same = shown(presenter, scene, error, live, live)
    covered = picture.sum(axis=2) > 0
    red, blue = picture[covered][:, 0], picture[covered][:, 2]
    # Indirect light only ever adds: nothing of the full picture is darker than direct light.
    assert np.all(red >= blue)
    assert np.all(swapped[covered][:, 2] >= swapped[covered][:, 0])
    assert np.count_nonzero(red > blue) > 0.5 * len(red)
    neutral = np.round(255.0 * np.array(error_color(0.0)))
    assert np.abs(same[covered] - neutral).max() <= ROUNDING
    other.release()


@pytest.mark.parametrize("scale", [0.5, 1.0, 4.0])
def test_error_colour_on_screen_is_that_of_the_legend(
    gl, live, presenter, scene, scale: float
) -> None:
    """Against a doubled copy of itself every surface is 50 % too dark."""

    class Doubled:
        drawing = property(lambda self: live.drawing)
        plane = property(lambda self: live.plane)
        weight = property(lambda self: 2.0 * live.weight)

    live.update(FrameRequest("beauty", ColorMapping.RADIANCE, scene.camera, SETTINGS))
    view = View(is_error=True, error_range=scale)
    picture = shown(presenter, scene, view, live, Doubled())  # type: ignore[arg-type]
    expected = np.round(255.0 * np.array(error_color(-0.5 / scale)))
    bright = shown(presenter, scene, View(), live).min(axis=2) > 200
    assert bright.any()
    # The floor of 0.01 in the denominator takes 1 % off in what is as bright as this.
    assert np.abs(picture[bright] - expected).max() <= 4
