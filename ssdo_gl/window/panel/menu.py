"""The menu bar: files, edits, what is shown of the window."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache, partial
from typing import Protocol

from imgui_bundle import imgui

from ssdo_gl import resources
from ssdo_gl.scene.load import builtin_names
from ssdo_gl.toml_text import read_toml
from ssdo_gl.window.actions import Host, perform
from ssdo_gl.window.input import BINDINGS, Action, Command
from ssdo_gl.window.viewer import Viewer

# Of a tooltip, in heights of text.
_TOOLTIP_WIDTH = 28.0
_TEXT_FACTORS = (0.8, 1.0, 1.25, 1.5, 2.0)
_FILE = (
    *(Command.SAVE_SCENE, Command.SAVE_PRESET),
    *(Command.SCREENSHOT, Command.SAVE_PICTURE, Command.COPY_COMMAND),
)
_VIEW = (Command.FIT, Command.HOME, Command.INSPECT, Command.SPLIT, Command.ERROR)
_WINDOW = (Command.TOGGLE_PANEL, Command.FULLSCREEN, Command.TOGGLE_HELP)


class Looks(Protocol):
    """What the panels look like."""

    is_light: bool

    def show_text_at(self, factor: float) -> None:
        """Show all text `factor` times as large as the display asks for."""

    def show_light(self, is_light: bool) -> None:
        """Draw dark on light, or light on dark."""


@cache
def builtin_scenes() -> dict[str, tuple[str, str]]:
    """Return title and purpose of each built-in scene."""
    folder = resources.folder("scenes")
    tables = {
        name: read_toml((folder / f"{name}.toml").read_text(encoding="utf-8"))
        for name in builtin_names()
    }
    return {
        name: (str(table.get("title", name)), " ".join(str(table.get("purpose", "")).split()))
        for name, table in tables.items()
    }


def draw_menu(viewer: Viewer, host: Host, looks: Looks) -> None:
    """Issue the menu bar along the upper edge of the window."""
    if not imgui.begin_main_menu_bar():
        return
    if imgui.begin_menu("File"):
        _item(viewer, host, Command.OPEN)
        if imgui.begin_menu("open recent"):
            _recent(host, host.recent.paths())
            imgui.end_menu()
        if imgui.begin_menu("built-in scenes"):
            _builtin(host)
            imgui.end_menu()
        _item(viewer, host, Command.RELOAD_SCENE)
        imgui.separator()
        _items(viewer, host, _FILE)
        imgui.separator()
        _item(viewer, host, Command.QUIT)
        imgui.end_menu()
    if imgui.begin_menu("Edit"):
        _item(viewer, host, Command.UNDO, is_on=viewer.history.can_undo)
        _item(viewer, host, Command.REDO, is_on=viewer.history.can_redo)
        imgui.separator()
        _item(viewer, host, Command.RESET)
        imgui.end_menu()
    if imgui.begin_menu("View"):
        _items(viewer, host, _VIEW)
        imgui.separator()
        _items(viewer, host, _WINDOW)
        imgui.separator()
        if imgui.begin_menu("text size"):
            for factor in _TEXT_FACTORS:
                if imgui.menu_item_simple(f"{factor:.0%}"):
                    host.defer(partial(looks.show_text_at, factor))
            imgui.end_menu()
        if imgui.menu_item_simple("dark panels" if looks.is_light else "light panels"):
            host.defer(partial(looks.show_light, not looks.is_light))
        imgui.end_menu()
    imgui.end_main_menu_bar()


def _recent(host: Host, paths: list[str]) -> None:
    for path in paths:
        if imgui.menu_item_simple(path):
            host.open(path)
    if not paths:
        imgui.text_disabled("nothing was opened yet")


def _builtin(host: Host) -> None:
    for name, (title, purpose) in builtin_scenes().items():
        if imgui.menu_item_simple(f"{name}: {title}"):
            host.open(name)
        if imgui.is_item_hovered() and imgui.begin_tooltip():
            imgui.push_text_wrap_pos(_TOOLTIP_WIDTH * imgui.get_font_size())
            imgui.text_unformatted(purpose)
            imgui.pop_text_wrap_pos()
            imgui.end_tooltip()


def _items(viewer: Viewer, host: Host, commands: Iterable[Command]) -> None:
    for command in commands:
        _item(viewer, host, command)


def _item(viewer: Viewer, host: Host, command: Command, *, is_on: bool = True) -> None:
    keys = next(item.label for item in BINDINGS if item.command == command)
    if imgui.menu_item_simple(command.value, keys, enabled=is_on):
        host.defer(partial(perform, Action(command), viewer, host))
