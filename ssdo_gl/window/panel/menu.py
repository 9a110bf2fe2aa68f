"""The menu bar: files, edits, what is shown of the window."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from imgui_bundle import imgui

from ssdo_gl.scene.load import builtin_scenes
from ssdo_gl.window.actions import Host, perform
from ssdo_gl.window.input import BINDINGS, Action, Command
from ssdo_gl.window.panel.tooltip import show_tooltip
from ssdo_gl.window.viewer import Viewer

TEXT_FACTORS = (0.8, 1.0, 1.25, 1.5, 2.0)
_FILE = (
    *(Command.SAVE_SCENE, Command.SAVE_PRESET),
    *(Command.SCREENSHOT, Command.SAVE_PICTURE, Command.COPY_COMMAND),
)
_VIEW = (
    *(Command.FIT, Command.HOME, Command.NEXT_CAMERA, Command.INSPECT),
    *(Command.SPLIT, Command.ERROR),
)
# Between a command and its keys, and as much as marks take.
_GAP = " " * 14
# Of the menu of files, besides its commands.
_OTHER_LINES = 7
# Of text that fits into a small window.
_SMALLEST = 0.35
_WINDOW = (Command.TOGGLE_PANEL, Command.FULLSCREEN, Command.TOGGLE_HELP)


def draw_menu(
    viewer: Viewer,
    host: Host,
    show_text_at: Callable[[float], None],
    show_light: Callable[[bool], None],
    *,
    is_light: bool,
) -> None:
    """Issue the menu bar along the upper edge of the window."""
    scale = _scale()
    if not imgui.begin_main_menu_bar():
        return
    if imgui.begin_menu("File"):
        imgui.push_font(None, scale * imgui.get_style().font_size_base)
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
        imgui.pop_font()
        imgui.end_menu()
    if imgui.begin_menu("Edit"):
        imgui.push_font(None, scale * imgui.get_style().font_size_base)
        _item(viewer, host, Command.UNDO, is_on=viewer.history.can_undo)
        _item(viewer, host, Command.REDO, is_on=viewer.history.can_redo)
        imgui.separator()
        _item(viewer, host, Command.RESET)
        imgui.pop_font()
        imgui.end_menu()
    if imgui.begin_menu("View"):
        imgui.push_font(None, scale * imgui.get_style().font_size_base)
        _items(viewer, host, _VIEW)
        imgui.separator()
        _items(viewer, host, _WINDOW)
        imgui.separator()
        if imgui.begin_menu("text size"):
            for factor in TEXT_FACTORS:
                if imgui.menu_item_simple(f"{factor:.0%}"):
                    host.defer(partial(show_text_at, factor))
            imgui.end_menu()
        if imgui.menu_item_simple("dark panels" if is_light else "light panels"):
            host.defer(partial(show_light, not is_light))
        imgui.pop_font()
        imgui.end_menu()
    imgui.end_main_menu_bar()


def _scale() -> float:
    """Return how large the text of menus is, of the usual: what lets them fit into the window."""
    window, style = imgui.get_io().display_size, imgui.get_style()
    labels = [command.value + _GAP + _keys(command) for command in (*_FILE, *_VIEW, *_WINDOW)]
    labels += [f"{name}: {title}" for name, (title, _) in builtin_scenes().items()]
    width = max(imgui.calc_text_size(label).x for label in labels)
    room = window.x - 4.0 * style.window_padding.x
    lines = len(_FILE) + _OTHER_LINES
    spacing = lines * style.item_spacing.y + 2.0 * style.window_padding.y
    height = lines * imgui.get_font_size()
    high = window.y - imgui.get_frame_height() - spacing
    return max(_SMALLEST, min(1.0, room / width, high / height))


def _recent(host: Host, paths: list[str]) -> None:
    room = 0.9 * imgui.get_io().display_size.x
    for path in paths:
        if imgui.menu_item_simple(_shortened(path, room)):
            host.open(path)
        if imgui.is_item_hovered():
            show_tooltip(path)
    if not paths:
        imgui.text_disabled("nothing was opened yet")


def _shortened(path: str, room: float) -> str:
    """Return the end of a path, as much as there is room for."""
    shown = path
    while imgui.calc_text_size(shown).x > room and len(shown) > 4:
        shown = "..." + shown[len(shown) // 8 + 4 :]
    return f"{shown}##{path}"


def _builtin(host: Host) -> None:
    for name, (title, purpose) in builtin_scenes().items():
        if imgui.menu_item_simple(f"{name}: {title}"):
            host.open(name)
        if imgui.is_item_hovered():
            show_tooltip(purpose)


def _items(viewer: Viewer, host: Host, commands: Iterable[Command]) -> None:
    for command in commands:
        _item(viewer, host, command)


def _item(viewer: Viewer, host: Host, command: Command, *, is_on: bool = True) -> None:
    if imgui.menu_item_simple(command.value, _keys(command), enabled=is_on):
        host.defer(partial(perform, Action(command), viewer, host))


def _keys(command: Command) -> str:
    return next(item.label for item in BINDINGS if item.command == command)
