"""Ctrl-C while rays are traced: a picture keeps what they found, everything else ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

import ssdo_gl
from ssdo_gl.bench.measure import BenchRenderer
from ssdo_gl.passes.rays import accumulate
from ssdo_gl.renderer import Renderer
from ssdo_gl.settings import Settings

TRACED = Settings("reference-gi", size=(16, 9), spp=64)


@pytest.fixture
def press(monkeypatch) -> Callable[[int], None]:
    """Return what lets Ctrl-C be pressed at the number-th draw from now."""
    draw = accumulate.draw_fullscreen

    def press_at(number: int) -> None:
        count = 0

        def counted(*arguments, **named):
            nonlocal count
            count += 1
            if count == number:
                raise KeyboardInterrupt
            return draw(*arguments, **named)

        monkeypatch.setattr(accumulate, "draw_fullscreen", counted)

    return press_at


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    with Renderer(ssdo_gl.load_scene("corner"), TRACED) as made:
        yield made


def draws(monkeypatch, renderer: Renderer) -> int:
    """Return how many draws a frame takes."""
    numbers = []
    draw = accumulate.draw_fullscreen
    with monkeypatch.context() as patch:
        patch.setattr(
            accumulate, "draw_fullscreen", lambda *a, **n: (numbers.append(1), draw(*a, **n))[1]
        )
        renderer.forget()
        renderer.render()
    return len(numbers)


def test_a_picture_keeps_what_rays_have_found(renderer, press):
    renderer.forget()
    press(2)
    assert renderer.render().partial
    assert not renderer.render().partial


@pytest.mark.parametrize(
    "work",
    [
        lambda renderer: BenchRenderer(renderer).images(TRACED, ("beauty",)),
        lambda renderer: BenchRenderer(renderer).timed(TRACED, ("beauty",), 3),
        lambda renderer: BenchRenderer(renderer).split(TRACED, ("beauty",), 3, "wall"),
        lambda renderer: renderer.draw(("beauty",), camera=renderer.scene.camera),
        lambda renderer: ssdo_gl.render("corner", method="reference-gi", size=(16, 9), spp=64),
        lambda renderer: list(
            ssdo_gl.render_views(
                "corner", [renderer.scene.camera], method="reference-gi", size=(16, 9), spp=64
            )
        ),
    ],
)
def test_what_has_no_use_for_a_part_ends(renderer, press, work):
    """A bench would keep the part as a whole reference, and a loop would go on."""
    renderer.forget()
    press(2)
    with pytest.raises(KeyboardInterrupt):
        work(renderer)


def test_frames_that_are_timed_end(renderer, press, monkeypatch):
    of_one = draws(monkeypatch, renderer)
    renderer.forget()
    press(of_one + 2)
    with pytest.raises(KeyboardInterrupt):
        renderer.render(frames=3)
