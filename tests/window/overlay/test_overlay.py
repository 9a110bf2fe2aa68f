"""The overlay drawn without a window: where its texts stand, and whose the mouse is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from window.overlay.drawn_overlay import SIZE, DrawnOverlay, OverlayHost

from ssdo_gl.window.overlay.overlay import Overlay
from ssdo_gl.window.saving.picture_job import PictureRequest

imgui_bundle = pytest.importorskip("imgui_bundle")


def test_panel_is_drawn_over_the_picture(gl, drawn: DrawnOverlay) -> None:
    with_panel = drawn.settled()
    drawn.overlay.shows_panel = False
    without = drawn.settled()
    covered = np.abs(with_panel - without).max(axis=2) > 8
    assert covered[:, SIZE[0] // 2 :].mean() > 0.2
    assert covered[60:, : SIZE[0] // 2].mean() < 0.01


def test_whose_the_mouse_is_follows_the_cursor_not_the_last_frame(gl, drawn: DrawnOverlay) -> None:
    drawn.frames(4)
    for x, is_panels in ((SIZE[0] - 100.0, True), (100.0, False), (SIZE[0] - 100.0, True)):
        drawn.overlay.cursor(x, 200.0)
        assert drawn.overlay.wants_mouse == is_panels


def test_help_covers_the_middle(gl, drawn: DrawnOverlay) -> None:
    before = drawn.settled()
    drawn.overlay.shows_help = True
    after = drawn.settled()
    assert np.abs(after - before)[300:400, 400:500].max() > 30


def test_split_names_its_sides(gl, drawn: DrawnOverlay) -> None:
    drawn.overlay.shows_panel = False
    drawn.viewer.view = dataclasses.replace(drawn.viewer.view, is_split=True, other_method="direct")
    named = drawn.frames(5)
    middle = named[SIZE[1] - 100 : SIZE[1] - 50, SIZE[0] // 2 - 120 : SIZE[0] // 2 + 120]
    # White text on dark plates.
    assert np.count_nonzero(middle.min(axis=2) > 220) > 50


@pytest.mark.parametrize("scale", [1.0, 1.4])
def test_texts_stay_clear_of_the_panel_and_each_other(gl, drawn: DrawnOverlay, scale) -> None:
    drawn.overlay.rescale(scale)
    drawn.viewer.say("a line of many words, " * 10)
    drawn.viewer.view = dataclasses.replace(
        drawn.viewer.view, is_error=True, divider=0.95, other_method="direct"
    )
    places = {}
    begin = imgui_bundle.imgui.begin

    def noted(name: str, *more: object) -> object:
        result = begin(name, *more)
        corner, size = imgui_bundle.imgui.get_window_pos(), imgui_bundle.imgui.get_window_size()
        places[name] = corner.x, corner.y, corner.x + size.x, corner.y + size.y
        return result

    imgui_bundle.imgui.begin = noted
    try:
        drawn.frames(4)
        drawn.viewer.view = dataclasses.replace(drawn.viewer.view, is_split=True, is_error=False)
        drawn.frames(4)
    finally:
        imgui_bundle.imgui.begin = begin
    left = places["panel"][0]
    assert left > 0.4 * SIZE[0]
    for name in ("legend", "side -1.0", "messages", "status"):
        start, _, end, _ = places[name]
        assert start >= 0.0, name
        assert end <= left, name
    assert places["legend"][1] >= places["status"][3]
    assert places["side -1.0"][3] <= places["messages"][1]


def test_what_is_said_is_read_where_the_panel_leaves_no_room(gl, drawn: DrawnOverlay) -> None:
    drawn.overlay.rescale(2.5)
    drawn.viewer.messages.lines.clear()
    drawn.viewer.say("bad.ply: not a readable PLY file", is_fault=True)
    drawn.click(SIZE[0] / 2, SIZE[1] - 20.0)
    screen = drawn.frames(4)
    rows, columns = np.nonzero((screen == (255, 140, 115)).all(axis=2))
    assert np.ptp(columns) > 0.4 * SIZE[0]
    assert np.ptp(rows) < 100


def test_cursor_over_the_panel_is_the_panels(gl, drawn: DrawnOverlay) -> None:
    drawn.frames(3)
    drawn.overlay.cursor(200.0, 400.0)
    drawn.frames(2)
    assert not drawn.overlay.wants_mouse
    drawn.overlay.cursor(SIZE[0] - 100.0, 60.0)
    drawn.frames(2)
    assert drawn.overlay.wants_mouse
    drawn.overlay.cursor_left()
    drawn.frames(2)
    assert not drawn.overlay.wants_mouse


def test_high_density_display_gets_larger_text(gl, drawn: DrawnOverlay) -> None:
    small = drawn.settled()
    drawn.overlay.rescale(2.0)
    large = drawn.settled()
    # Sizes and density of a window that is dragged need not fit each other for a moment.
    for scale in (1e-3, 0.37, 1.9, 0.6, 300.0) * 3:
        drawn.overlay.rescale(scale)
        drawn.frames(1)
    drawn.overlay.rescale(1.0)
    assert np.array_equal(drawn.settled(), small)
    # The line at the top left is twice as high and wide.
    line = [np.abs(s[10:90, 10:600] - small[200:280, 10:600]).max(axis=2) for s in (small, large)]
    assert np.count_nonzero(line[1]) > np.count_nonzero(line[0])


def test_window_of_no_size_draws_nothing(gl, drawn: DrawnOverlay) -> None:
    drawn.frames(2)
    drawn.overlay.compose(drawn.screen, (0, 0), (0, 0), 0.05)
    drawn.frames(2)


def test_text_grows_and_panels_turn_light(gl, drawn: DrawnOverlay) -> None:
    dark = drawn.settled()
    drawn.overlay.show_light(True)
    light = drawn.settled()
    panel = np.s_[30:40, SIZE[0] - 60 : SIZE[0] - 30]
    assert light[panel].mean() > dark[panel].mean() + 60.0
    drawn.overlay.show_light(False)
    drawn.overlay.show_text_at(1.5)
    # The display's own density, again: the factor holds.
    drawn.overlay.rescale(1.0)
    assert drawn.overlay._scale == 1.5
    drawn.overlay.show_text_at(1.0)
    assert np.array_equal(drawn.settled()[panel], dark[panel])


def test_a_picture_is_asked_for(gl, drawn: DrawnOverlay, monkeypatch) -> None:
    prompt = drawn.overlay.picture_prompt
    request = PictureRequest((640, 360), "gi", True, "mine.png")
    for pressed, expected in (("cancel", None), ("save", request)):
        prompt.request = request
        drawn.frames(2)
        assert prompt.request == request
        with monkeypatch.context() as patch:
            patch.setattr(imgui_bundle.imgui, "button", lambda label, *_, p=pressed: label == p)
            drawn.frames(1)
        assert prompt.request is None
        assert drawn.overlay._host.requested == expected


def test_size_of_text_and_theme_last_until_the_next_visit(
    gl, device, shaders, tmp_path, drawn: DrawnOverlay
) -> None:
    file = tmp_path / "state" / "looks.json"

    def overlay() -> Overlay:
        return Overlay(drawn.viewer, OverlayHost(), 1.0, 900.0, file)

    first = overlay()
    assert not first.is_light
    first.show_text_at(1.5)
    first.show_light(True)
    first.release()
    second = overlay()
    assert second.is_light
    assert second._scale == pytest.approx(1.5)
    # Not those of the display, which come on top.
    second.rescale(2.0)
    assert second._scale == pytest.approx(3.0)
    second.release()
    for text in ("", "[]", '{"text": 1e9, "is_light": 3}', "[" * 100_000):
        file.write_text(text)
        third = overlay()
        assert not third.is_light
        assert third._scale == pytest.approx(1.0)
        third.release()
