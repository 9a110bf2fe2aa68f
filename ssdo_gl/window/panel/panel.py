"""The panel: everything that can be chosen, with unit, range and flag."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

from imgui_bundle import ImVec2, imgui

from ssdo_gl.effects.registry import image_names
from ssdo_gl.film.writers import FILM_SUFFIXES
from ssdo_gl.options.flags import flag_infos
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import Kind, SettingError
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.window.actions import Host, perform
from ssdo_gl.window.input import Action, Command
from ssdo_gl.window.panel.control_rows import (
    ControlRow,
    default_of,
    first_value,
    ignored_because,
    main_rows,
    pass_rows,
    value_of,
    with_value,
)
from ssdo_gl.window.panel.light_handle import LightHandle
from ssdo_gl.window.panel.light_section import lights_section
from ssdo_gl.window.panel.material_section import MaterialSection
from ssdo_gl.window.panel.reports import Reports
from ssdo_gl.window.panel.status import given_up, memory_mb
from ssdo_gl.window.panel.tooltip import show_tooltip
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS

# Width in window coordinates: labels fit beside sliders wide enough to aim at.
WIDTH = 360.0
_LABEL_SHARE = 0.44
_GAP = 8.0
_PRESETS_PER_LINE = 4
_BUDGETS_MS = (4.0, 250.0)


def panel_width(window_size: tuple[int, int], scale: float) -> float:
    """Return how wide the panel is, window coordinates; a narrow window keeps an edge."""
    return min(WIDTH * scale, 0.9 * window_size[0])


class Panel:
    """Draws the panel's widgets and carries out what they ask for."""

    def __init__(self, viewer: Viewer, host: Host) -> None:
        self._viewer = viewer
        self._host = host
        self.light_handle = LightHandle(viewer)
        self._materials = MaterialSection(viewer)
        self.reports = Reports(viewer)
        self._pass_rows = pass_rows()

    def draw(self, window_size: tuple[int, int], scale: float, top: float = 0.0) -> None:
        """Issue the widgets, along the right edge of the window.

        Parameters
        ----------
        window_size : (int, int)
            Window coordinates.
        scale : float
            Of text, for displays of high density.
        top : float
            Where it begins, window coordinates.
        """
        width = panel_width(window_size, scale)
        imgui.set_next_window_pos(ImVec2(window_size[0] - width - _GAP, top + _GAP))
        imgui.set_next_window_size_constraints(
            ImVec2(width, 0.0), ImVec2(width, max(64.0, window_size[1] - top - 2.0 * _GAP))
        )
        flags = (
            imgui.WindowFlags_.no_move
            | imgui.WindowFlags_.no_resize
            | imgui.WindowFlags_.always_auto_resize
            | imgui.WindowFlags_.no_title_bar
            | imgui.WindowFlags_.no_nav
        )
        imgui.begin("panel", None, flags)
        imgui.push_item_width((1.0 - _LABEL_SHARE) * width)
        self._view_section()
        if _header("Quality"):
            self._presets()
            self._rows(main_rows(self._viewer.settings))
        if _header("Details"):
            self._passes()
        if _header("Lights"):
            lights_section(self._viewer, self.light_handle)
        self._materials.draw()
        if _header("Time", is_open=True):
            self._time_section()
        self._viewer.times_passes = _header("Effects and passes")
        if self._viewer.times_passes:
            self.reports.effects()
        if _header("Accuracy against time"):
            self.reports.pareto()
        self._viewer.shows_histogram = _header("Histogram")
        if self._viewer.shows_histogram:
            self.reports.histogram()
        if _header("Tour"):
            self._tour_section()
        self._output_row()
        imgui.pop_item_width()
        imgui.end()

    # --- sections ------------------------------------------------------------------

    def _view_section(self) -> None:
        viewer, view = self._viewer, self._viewer.view
        methods, aovs = list(METHODS), image_names()
        labels = [METHOD_LABELS[name] for name in methods]
        changed, index = imgui.combo("method", methods.index(view.method), labels)
        _flag_hint("method", "T")
        if changed:
            viewer.choose_method(methods[index])
        names = [f"{(i + 1) % 10}  {name}" for i, name in enumerate(aovs)]
        changed, index = imgui.combo("image", aovs.index(view.aov), names)
        _flag_hint("aov", "number keys")
        if changed:
            viewer.view = viewer.view.with_number(index + 1)
        sides = "two methods side by side; drag the line between them   (V)"
        self._switch("split", view.is_split, Command.SPLIT, sides)
        imgui.same_line()
        colors = "blue: too dark, red: too bright, relative to the other method   (X)"
        self._switch("difference", view.is_error, Command.ERROR, colors)
        imgui.same_line()
        numbers = "the numbers under the cursor   (I)"
        self._switch("values", viewer.is_inspecting, Command.INSPECT, numbers)
        if view.compares:
            index = methods.index(view.other_method)
            changed, index = imgui.combo("compared with", index, labels)
            if changed:
                viewer.view = dataclasses.replace(viewer.view, other_method=methods[index])
        if view.is_error:
            changed, value = imgui.slider_float(
                "full colour at", view.error_range, 0.01, 4.0, "%.2f", _LOG
            )
            if changed:
                viewer.view = dataclasses.replace(viewer.view, error_range=value)

    def _presets(self) -> None:
        viewer = self._viewer
        for index, (name, fields) in enumerate(viewer.presets.items(), 1):
            if imgui.button(name):
                viewer.choose_preset(name)
            _hint("\n".join(f"{key} = {value}" for key, value in fields.items()))
            if index % _PRESETS_PER_LINE:
                imgui.same_line()
        saved = "write these settings to a file; one that is dropped here is read   (Ctrl+Shift+S)"
        self._button("save", Command.SAVE_PRESET, saved)

    def _passes(self) -> None:
        for name, rows in self._pass_rows.items():
            if imgui.tree_node(name):
                self._rows(rows)
                imgui.tree_pop()

    def _rows(self, rows: list[ControlRow]) -> None:
        for row in rows:
            value = value_of(self._viewer.settings, row)
            ignored = ignored_because(self._viewer.settings, row.key, self._viewer.view.aov)
            imgui.begin_disabled(bool(ignored))
            changed, new = _control(row, value, self._effective(row))
            imgui.end_disabled()
            if ignored and imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_disabled):
                show_tooltip(f"no effect {ignored}")
            if changed:
                self._set(row, new)

    def _effective(self, row: ControlRow) -> Any:
        """Return what holds for a setting that is left to scene or method."""
        left = self._viewer.left
        if row.pass_name or left is None:
            return None
        settings: Settings = left.image.renderer.settings
        chosen = {"estimator": settings.chosen_estimator, "shadows": settings.chosen_shadows}
        return chosen.get(row.key, getattr(settings, row.key))

    def _set(self, row: ControlRow, value: Any) -> None:
        try:
            self._viewer.settings = with_value(self._viewer.settings, row, value)
        except SettingError as error:
            self._viewer.say(str(error), is_fault=True)

    def _time_section(self) -> None:
        viewer = self._viewer
        self.reports.frame_times()
        held = "lower the quality while something moves, so that a frame takes no longer   (G)"
        self._switch("hold", viewer.is_governed, Command.GOVERNOR, held)
        imgui.same_line()
        low, high = _BUDGETS_MS
        imgui.set_next_item_width(0.4 * imgui.get_content_region_avail().x)
        changed, value = imgui.slider_float("ms a frame", viewer.budget_ms, low, high, "%.0f", _LOG)
        _flag_hint("budget_ms")
        if changed:
            viewer.budget_ms = min(high, max(low, value))
        if viewer.left is not None and viewer.is_governed:
            imgui.push_text_wrap_pos(0.0)
            imgui.text_disabled(given_up(viewer.left.level, viewer.settings, viewer.budget_ms))
            imgui.pop_text_wrap_pos()
        imgui.text_disabled(f"memory of the program: {memory_mb():.0f} MB")
        if viewer.clock.has_motion:
            self._time_line()

    def _time_line(self) -> None:
        """Play, scrub and loop the animation."""
        clock = self._viewer.clock
        label = "pause" if clock.is_running else "play"
        self._button(label, Command.PAUSE, "stop or go on   (Space)")
        imgui.same_line()
        self._button("step", Command.STEP)
        imgui.same_line()
        _, clock.loops = imgui.checkbox("loop", clock.loops)
        imgui.same_line()
        imgui.text("of")
        imgui.same_line()
        imgui.set_next_item_width(imgui.get_content_region_avail().x * 0.6)
        changed, length = imgui.drag_float("##length", clock.length_s, 0.1, 0.1, 3600.0, "%.1f s")
        if changed:
            clock.length_s = max(0.1, length)
        _hint("the length of the time line")
        imgui.set_next_item_width(-1.0)
        end = max(clock.length_s, clock.seconds)
        changed, seconds = imgui.slider_float("##time", clock.seconds, 0.0, end, "%.2f s")
        if changed:
            clock.scrub(max(0.0, seconds))

    def _tour_section(self) -> None:
        tour = self._viewer.tour
        for number in range(1, 10):
            if number > 1:
                imgui.same_line()
            known = number in tour.numbers
            if not known:
                imgui.push_style_var(imgui.StyleVar_.alpha, 0.4)
            if imgui.small_button(str(number)):
                self._ask(Command.RECALL if known else Command.STORE, number)
            if not known:
                imgui.pop_style_var()
            _hint("go there   (Alt+digit)" if known else "keep this view   (Ctrl+digit)")
        label = "end recording" if tour.is_recording else "record"
        self._button(label, Command.RECORD, "record the camera's path   (L)")
        imgui.same_line()
        label = "stop" if tour.played_s is not None else "play"
        self._button(label, Command.PLAY, "fly the recorded path   (P)")
        imgui.same_line()
        self._button("film", Command.EXPORT, "write the path as a film at full quality   (Ctrl+P)")
        imgui.same_line()
        imgui.text_disabled(f"{tour.path.seconds:.1f} s")
        for suffix in FILM_SUFFIXES:
            if imgui.radio_button(suffix, self._viewer.film_suffix == suffix):
                self._viewer.film_suffix = suffix
            imgui.same_line()
        imgui.new_line()
        slides = "the camera slides along surfaces instead of flying through   (B)"
        self._switch("stop at walls", self._viewer.collides, Command.COLLIDE, slides)

    def _output_row(self) -> None:
        imgui.separator()
        copied = "the command line that renders this view without a window   (C)"
        self._button("copy command", Command.COPY_COMMAND, copied)
        imgui.same_line()
        written = "picture and settings to files in the present folder   (F12)"
        self._button("screenshot", Command.SCREENSHOT, written)
        imgui.same_line()
        self._button("home", Command.HOME)
        imgui.same_line()
        self._button("keys", Command.TOGGLE_HELP)

    def _button(self, label: str, command: Command, hint: str = "") -> None:
        if imgui.button(label):
            self._ask(command)
        _hint(hint)

    def _switch(self, label: str, is_on: bool, command: Command, hint: str) -> None:
        if imgui.checkbox(label, is_on)[0]:
            self._ask(command)
        _hint(hint)

    def _ask(self, command: Command, number: int = 0) -> None:
        action = Action(command, number)
        self._host.defer(partial(perform, action, self._viewer, self._host))


_LOG = imgui.SliderFlags_.logarithmic
# Over this many integers a slider cannot be set to one of them.
_LONGEST_SLIDER = 1 << 20


def _header(label: str, *, is_open: bool = False) -> bool:
    flags = imgui.TreeNodeFlags_.default_open if is_open else 0
    return bool(imgui.collapsing_header(label, flags))


def _hint(text: str) -> None:
    if text and imgui.is_item_hovered(imgui.HoveredFlags_.delay_short):
        show_tooltip(text)


def _flag_hint(name: str, keys: str = "") -> None:
    """Explain a control as ``--help`` explains the flag that does the same."""
    info = flag_infos()[name][1]
    _hint(f"{info.doc}\n{info.flag}" + (f"   ({keys})" if keys else ""))


def _control(row: ControlRow, value: Any, effective: Any) -> tuple[bool, Any]:
    """Draw the control of one setting; return (changed, value)."""
    imgui.push_id(row.key)
    try:
        if row.is_optional and value is None:
            return _unchosen(row, effective)
        changed, new = _widget(row, value)
        _hint(row.hint)
        if (row.is_optional or value != default_of(row)) and imgui.begin_popup_context_item():
            if imgui.menu_item_simple("back to the default"):
                changed, new = True, default_of(row)
            imgui.end_popup()
        return changed, new
    finally:
        imgui.pop_id()


def _unchosen(row: ControlRow, effective: Any) -> tuple[bool, Any]:
    """Draw a setting that is left to scene or method: a button that takes it over."""
    text = (
        "by default"
        if effective is None
        else f"{effective:.4g}"
        if isinstance(effective, float)
        else str(effective)
    )
    if imgui.button(f"{text} ...", ImVec2(imgui.calc_item_width(), 0.0)):
        return True, first_value(row) if effective is None else effective
    _hint(f"{row.hint}\nleft to the scene or the method; click to choose")
    imgui.same_line(0.0, imgui.get_style().item_inner_spacing.x)
    imgui.text(row.label)
    return False, None


def _widget(row: ControlRow, value: Any) -> tuple[bool, Any]:
    flags = _LOG if row.is_log else 0
    if row.kind is Kind.BOOLEAN:
        return imgui.checkbox(row.label, value)
    if row.kind is Kind.INTEGER and row.high - row.low > _LONGEST_SLIDER:
        return imgui.input_int(row.label, value)
    if row.kind is Kind.INTEGER:
        return imgui.slider_int(row.label, value, int(row.low), int(row.high), "%d", flags)
    if row.kind is Kind.NUMBER:
        return imgui.slider_float(row.label, value, row.low, row.high, "%.4g", flags)
    index = row.choices.index(value) if value in row.choices else 0
    changed, index = imgui.combo(row.label, index, [str(choice) for choice in row.choices])
    return changed, row.choices[index]
