"""The panel drawn without a window: every section, fed with clicks and keys."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path

import glfw
import moderngl
import numpy as np
import pytest
from window.driven_viewer import FakeHost

from ssdo_gl.effects.methods import METHODS
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.opening.recent import Recent
from ssdo_gl.window.panel.histogram import BINS_PER_STOP, STOPS, radiance_histogram
from ssdo_gl.window.viewer import Viewer

imgui_bundle = pytest.importorskip("imgui_bundle")
from ssdo_gl.window.overlay.overlay import Overlay  # noqa: E402
from ssdo_gl.window.panel import control_rows  # noqa: E402
from ssdo_gl.window.panel import panel as panel_module  # noqa: E402
from ssdo_gl.window.panel.menu import builtin_scenes  # noqa: E402
from ssdo_gl.window.saving.picture_job import PictureRequest  # noqa: E402

SIZE = (900, 700)
PICTURE = (36, 28)
# The height of the menu bar.
MENU_PX = 19.0


class OverlayHost(FakeHost):
    """One that does at once what widgets put off, and remembers files."""

    def __init__(self) -> None:
        super().__init__()
        self.recent = Recent(Path("/nonexistent"))
        self.opened: list[str] = []
        self.requested: PictureRequest | None = None

    def defer(self, act: Callable[[], object]) -> None:
        act()

    def open(self, path: str) -> None:
        self.opened.append(path)

    def save_picture(self, request: PictureRequest) -> None:
        self.requested = request


class DrawnOverlay:
    """A viewer with its overlay, and a framebuffer for a screen."""

    def __init__(self, device: Device, shaders: ShaderLibrary, scene: str, folder: Path) -> None:
        self.viewer = Viewer(
            device,
            load_scene(scene),
            Settings("bounce", samples=8, steps=4),
            source=scene,
            folder=folder,
            shaders=shaders,
        )
        self.overlay = Overlay(device, self.viewer, OverlayHost())
        self.texture = make_texture(device.gl, SIZE, 4, "nu1")
        self.screen: moderngl.Framebuffer = make_framebuffer(device.gl, [self.texture])

    def frames(self, count: int = 3) -> np.ndarray:
        """Let frames pass; return the screen, (height, width, 3), row 0 at the top."""
        for _ in range(count):
            self.viewer.frame(Controls(), 0.05, PICTURE)
            self.screen.clear()
            self.viewer.presenter.copy_to(self.screen, SIZE)
            self.overlay.compose(self.screen, SIZE, SIZE, 0.05)
        data = np.frombuffer(self.screen.read(components=3, alignment=1), np.uint8)
        return data.reshape(SIZE[1], SIZE[0], 3)[::-1].astype(int)

    def settled(self) -> np.ndarray:
        """Return the screen once the picture behind the panel stands still."""
        for _ in range(100):
            if not self.viewer.is_busy:
                break
            self.viewer.frame(Controls(), 0.05, PICTURE)
        self.viewer.messages.lines.clear()
        return self.frames(4)

    def click(self, x: float, y: float) -> None:
        self.overlay.cursor(x, y)
        self.frames(2)
        self.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS)
        self.frames(2)
        self.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE)
        self.frames(2)

    def release(self) -> None:
        self.overlay.release()
        self.viewer.release()
        self.screen.release()
        self.texture.release()


@pytest.fixture
def drawn(
    device: Device, shaders: ShaderLibrary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[DrawnOverlay]:
    # The only number of a picture at rest that changes by itself.
    monkeypatch.setattr(panel_module, "memory_mb", lambda: 100.0)
    drawn = DrawnOverlay(device, shaders, "cornell_meso", tmp_path)
    yield drawn
    drawn.release()


@pytest.fixture
def all_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every section and every tree of the panel is open."""
    tree_node = panel_module.imgui.tree_node

    def open_tree(label: str) -> bool:
        panel_module.imgui.set_next_item_open(True)
        return bool(tree_node(label))

    monkeypatch.setattr(panel_module, "_header", lambda label, *, is_open=False: True)
    monkeypatch.setattr(panel_module.imgui, "tree_node", open_tree)


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


@pytest.mark.parametrize("method", list(METHODS)[:4])
def test_every_section_draws_for_every_method(
    gl, drawn: DrawnOverlay, all_open, method: str
) -> None:
    drawn.viewer.choose_method(method)
    drawn.viewer.view = dataclasses.replace(drawn.viewer.view, is_error=True, other_method="direct")
    drawn.viewer.is_inspecting = True
    drawn.overlay.show_faults(("effects/bounce.frag:12: syntax error",))
    drawn.overlay.shows_help = True
    settings = drawn.viewer.settings
    drawn.frames(8)
    # Drawing a control must not change what it shows.
    assert drawn.viewer.settings == settings
    assert drawn.viewer.scene is drawn.viewer.original


@pytest.mark.parametrize("scene", ["carousel", "courtyard", "furnace", "coloured_lights"])
def test_every_section_draws_for_every_kind_of_light(
    gl, device, shaders, tmp_path, all_open, scene: str
) -> None:
    drawn = DrawnOverlay(device, shaders, scene, tmp_path)
    try:
        drawn.frames(4)
        assert drawn.viewer.scene is drawn.viewer.original
    finally:
        drawn.release()


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


def test_sky_can_be_added_and_removed(gl, drawn: DrawnOverlay, all_open, monkeypatch) -> None:
    pressed = ["add a sky"]
    monkeypatch.setattr(
        panel_module.imgui, "small_button", lambda label: bool(pressed) and label == pressed[0]
    )
    drawn.frames(1)
    assert drawn.viewer.scene.environment is not None
    pressed[0] = "remove"
    drawn.frames(1)
    assert drawn.viewer.scene.environment is None
    pressed.clear()
    drawn.frames(3)


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


def test_click_on_a_check_box_does_what_its_key_does(gl, drawn: DrawnOverlay) -> None:
    drawn.viewer.view = dataclasses.replace(drawn.viewer.view, other_method="direct")
    drawn.frames(3)
    # The row of check boxes is the third one of the panel; "split" is its first.
    drawn.click(SIZE[0] - panel_module.WIDTH + 10.0, MENU_PX + 8.0 + 2.7 * 26.0)
    assert drawn.viewer.view.is_split


def test_typing_into_a_control_changes_the_setting(gl, drawn: DrawnOverlay, monkeypatch) -> None:
    """Ctrl+click turns a slider into a text field; what is typed is checked as a flag is."""
    shown = [row for row in panel_module.main_rows(Settings()) if row.key == "samples"]
    monkeypatch.setattr(panel_module, "main_rows", lambda settings: shown)
    monkeypatch.setattr(panel_module, "_header", lambda label, *, is_open=False: label == "Quality")
    drawn.frames(3)
    # Under the three rows of the view and the presets.
    x, y = SIZE[0] - panel_module.WIDTH + 60.0, MENU_PX + 8.0 + 4.7 * 26.0
    drawn.overlay.key(glfw.KEY_LEFT_CONTROL, glfw.PRESS, glfw.MOD_CONTROL)
    drawn.click(x, y)
    drawn.overlay.key(glfw.KEY_LEFT_CONTROL, glfw.RELEASE, 0)
    drawn.frames(2)
    assert drawn.overlay.wants_keyboard
    for character in "24":
        drawn.overlay.character(ord(character))
        drawn.frames(1)
    drawn.overlay.key(glfw.KEY_ENTER, glfw.PRESS, 0)
    drawn.frames(2)
    drawn.overlay.key(glfw.KEY_ENTER, glfw.RELEASE, 0)
    drawn.frames(2)
    assert drawn.viewer.settings.samples == 24
    assert not drawn.overlay.wants_keyboard


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


def test_histogram_counts_stops() -> None:
    image = np.zeros((4, 4, 4), np.float32)
    image[:2, :, :3] = 1.0
    image[2, :, :3] = 2.0**-20
    image[:3, :, 3] = 1.0
    histogram = radiance_histogram(image)
    assert len(histogram) == (STOPS[1] - STOPS[0]) * BINS_PER_STOP
    assert histogram.sum() == pytest.approx(1.0)
    assert histogram[int(-STOPS[0]) * BINS_PER_STOP] == pytest.approx(2 / 3)
    assert histogram[0] == pytest.approx(1 / 3)


def test_histogram_of_nothing_and_of_non_finite_pixels_is_empty() -> None:
    image = np.full((2, 2, 4), np.nan, np.float32)
    assert radiance_histogram(image).sum() == 0.0
    image[:, :, 3] = 1.0
    assert radiance_histogram(image).sum() == 0.0


def test_the_menu_opens_a_built_in_scene(gl, drawn: DrawnOverlay) -> None:
    drawn.settled()
    drawn.click(22.0, 10.0)
    # Over the entry, into its menu, to the first scene.
    for x in (60.0, 340.0, 420.0):
        drawn.overlay.cursor(x, 78.0)
        drawn.frames(12)
    drawn.click(420.0, 78.0)
    assert drawn.overlay._host.opened == ["carousel"]


def test_every_built_in_scene_says_what_it_is_for() -> None:
    scenes = builtin_scenes()
    assert list(scenes) == builtin_names()
    assert all(title and len(purpose) > 20 for title, purpose in scenes.values())


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


@pytest.mark.parametrize(
    ("method", "ignored", "used"),
    [
        ("bounce", ("spp", "bounces", "shadow_rays", "combine"), ("samples", "radius", "filter")),
        ("direct", ("samples", "radius", "far_field.tile"), ("exposure", "seed", "direct.x")),
        ("gi", ("spp", "ssao.x", "reference_gi.x"), ("far_field.x", "surface_cache.x", "bounce.x")),
        ("bounce", ("surface_cache.x", "traced_shadows.x"), ("shadow_map.x", "tone_map.x")),
        ("reference-near", ("samples", "filter"), ("spp", "radius", "shadow_rays")),
        ("reference-gi", ("radius", "steps", "temporal.x", "shadow_map.x"), ("bounces", "spp")),
    ],
)
def test_settings_without_effect_say_why(
    method: str, ignored: tuple[str, ...], used: tuple[str, ...]
) -> None:
    settings = Settings(method=method)
    assert all(control_rows.ignored_because(settings, name) for name in ignored)
    # Another image may ask for what the picture does without; that of references is by rays.
    by_ssao = control_rows.ignored_because(settings, "ssao.x", image="visibility")
    assert bool(by_ssao) == settings.is_reference
    assert not any(control_rows.ignored_because(settings, name) for name in used)


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
        return Overlay(device, drawn.viewer, OverlayHost(), 1.0, 900.0, file)

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
