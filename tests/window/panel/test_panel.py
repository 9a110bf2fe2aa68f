"""The panel drawn without a window: every section, fed with clicks and keys."""

from __future__ import annotations

import dataclasses

import glfw
import pytest
from window.overlay.drawn_overlay import SIZE, DrawnOverlay

from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.window.panel import panel as panel_module

# The height of the menu bar.
MENU_PX = 19.0


@pytest.fixture
def all_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every section and every tree of the panel is open."""
    tree_node = panel_module.imgui.tree_node

    def open_tree(label: str) -> bool:
        panel_module.imgui.set_next_item_open(True)
        return bool(tree_node(label))

    monkeypatch.setattr(panel_module, "_header", lambda label, *, is_open=False: True)
    monkeypatch.setattr(panel_module.imgui, "tree_node", open_tree)


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
