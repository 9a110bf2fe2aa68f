"""Everything that is drawn over the picture: panel, messages, values, keys, legend."""

from __future__ import annotations

import math
from pathlib import Path

import moderngl
from imgui_bundle import ImVec2, imgui

from ssdo_gl.images.display import ColorMapping
from ssdo_gl.window.actions import Host
from ssdo_gl.window.canvas import error_color
from ssdo_gl.window.kept_files import keep, kept
from ssdo_gl.window.live import Reading, inspect, shown_values
from ssdo_gl.window.overlay.help_sheet import draw_help
from ssdo_gl.window.overlay.imgui_backend import ImguiBackend
from ssdo_gl.window.overlay.prompt import PathPrompt, PicturePrompt
from ssdo_gl.window.panel import TEXT_FACTORS, Panel, draw_menu, panel_width, state_text
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS

# In a window narrower than this, the panel would cover half of the picture.
NARROW = 720.0
_MARGIN = 10.0
# Beside a panel that leaves less than this, in heights of text, no line can be read: what is said
# is then shown before it.
_LEAST_LINE = 8.0
# What is said takes so much of a window, whose height does not suffice for more lines.
_LINE = 26.0
_FAULT, _FAULT_ON_LIGHT = imgui.ImVec4(1.0, 0.55, 0.45, 1.0), imgui.ImVec4(0.7, 0.1, 0.0, 1.0)
_STILL = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_nav
    | imgui.WindowFlags_.no_focus_on_appearing
)
_SEE_THROUGH = _STILL | imgui.WindowFlags_.no_inputs
_LEGEND_STEPS = 41
# How much of the window values may cover.
_FULL = 0.9


class Overlay(ImguiBackend):
    """The user interface over the viewer's picture.

    Parameters
    ----------
    scale : float
        Of text and widgets.
    width : float
        Of the window; a narrow one begins without the panel.
    looks_file : Path or None
        Where the size of text and the theme are kept; None: nowhere.
    """

    def __init__(
        self,
        viewer: Viewer,
        host: Host,
        scale: float = 1.0,
        width: float = math.inf,
        looks_file: Path | None = None,
    ) -> None:
        super().__init__(scale)
        self.shows_panel = width >= NARROW * scale
        self.shows_help = False
        self._viewer = viewer
        self._host = host
        self._panel = Panel(viewer, host)
        self.light_handle = self._panel.light_handle
        self.path_prompt = PathPrompt()
        self.picture_prompt = PicturePrompt()
        # Where the texts at the top end, and those at the bottom begin.
        self._top = self._bottom = 0.0
        self._text_factor = 1.0
        self._reading: Reading | None = None
        self._faults: tuple[str, ...] = ()
        self._looks_file = looks_file
        looks = None if looks_file is None else kept(looks_file)
        if isinstance(looks, dict):
            if looks.get("text") in TEXT_FACTORS:
                self.show_text_at(looks["text"])
            self.show_light(looks.get("is_light") is True)

    def _keep_looks(self) -> None:
        if self._looks_file is not None:
            keep(self._looks_file, {"text": self._text_factor, "is_light": self.is_light})

    @property
    def is_busy(self) -> bool:
        """Whether a widget is being dragged, so that frames must follow one another."""
        is_active = imgui.is_any_item_active() or self.light_handle.is_dragged
        return bool(is_active) and not self.wants_keyboard

    @property
    def wants_mouse(self) -> bool:
        """Whether the cursor is over a widget or a handle, or drags one."""
        return super().wants_mouse or self.light_handle.is_hot

    @property
    def shape(self) -> object:
        """Which of its parts are shown: another one takes frames to be there for events."""
        asks = self.path_prompt.is_shown, self.picture_prompt.request is not None
        return self.shows_panel, self.shows_help, *asks

    def show_text_at(self, factor: float) -> None:
        """Show all text `factor` times as large as the display asks for."""
        self._text_factor, before = factor, self._text_factor
        self.rescale(self._scale / before)
        self._keep_looks()

    def show_light(self, is_light: bool) -> None:
        super().show_light(is_light)
        self._keep_looks()

    def rescale(self, scale: float) -> None:
        super().rescale(scale * self._text_factor)

    def show_faults(self, faults: tuple[str, ...]) -> None:
        """Show what does not compile until it does."""
        self._faults = faults

    def compose(
        self,
        target: moderngl.Framebuffer,
        window_size: tuple[int, int],
        framebuffer_size: tuple[int, int],
        seconds: float,
    ) -> None:
        """Issue all widgets and draw them over `target`."""
        if min(*window_size, *framebuffer_size) < 1:
            return
        self.begin(window_size, framebuffer_size, seconds)
        if self._viewer.frame_ms > 0.0:
            self._panel.reports.note_frame(self._viewer.frame_ms)
        self._top = 0.0
        if self.shows_panel:
            self.light_handle.draw(window_size, self._scale)
            looks = self.show_text_at, self.show_light
            draw_menu(self._viewer, self._host, *looks, is_light=self.is_light)
            self._top = imgui.get_frame_height()
            self._panel.draw(window_size, self._scale, self._top)
        else:
            self._viewer.times_passes = self._viewer.shows_histogram = False
            self.light_handle.hide()
        # What explains the picture stays clear of the panel.
        taken = panel_width(window_size, self._scale) if self.shows_panel else 0.0
        free = window_size[0] - taken
        self._bottom = window_size[1] - _MARGIN
        has_room = free > _LEAST_LINE * imgui.get_font_size()
        self._messages(window_size, free, has_room=has_room)
        if has_room:
            self._status(free)
            self._names_of_sides(window_size, free)
            if self._viewer.view.is_error:
                self._legend(free)
        if self._viewer.is_inspecting:
            self._values()
        else:
            self._reading = None
        path = self.path_prompt.draw(window_size)
        if path is not None:
            self._host.open(path)
        request = self.picture_prompt.draw(window_size)
        if request is not None:
            self._host.save_picture(request)
        if self.shows_help:
            draw_help(window_size)
        self.draw(target)

    def _status(self, free: float) -> None:
        """At the top left: what is shown, at which size, how refined it is or how fast."""
        viewer = self._viewer
        left = viewer.left
        if left is None or left.image.drawing is None:
            return
        text = f"{METHOD_LABELS[viewer.view.method]}, {viewer.view.aov}   "
        text += state_text(viewer, self._panel.reports.frame_rate)
        if imgui.calc_text_size(text).x + 4.0 * _MARGIN > free:
            text = "\n".join(text.split("   "))
        # Known beforehand: a window that measures itself is a frame late, and a frame
        # may take a second.
        size = imgui.calc_text_size(text)
        if not self._fits(size.y):
            return
        if viewer.monitor.alarm is None:
            imgui.set_next_window_content_size(size)
        _place(_MARGIN, self._top + _MARGIN)
        imgui.begin("status", None, _SEE_THROUGH)
        imgui.text(text)
        if viewer.monitor.alarm is not None:
            x, y = viewer.monitor.alarm.pixel
            imgui.text_colored(
                self._fault_color,
                f"{viewer.monitor.alarm.count} pixels are not finite, from ({x}, {y}) on",
            )
        self._top = imgui.get_window_pos().y + imgui.get_window_height()
        imgui.end()

    @property
    def _fault_color(self) -> imgui.ImVec4:
        return _FAULT_ON_LIGHT if self.is_light else _FAULT

    def _messages(self, window_size: tuple[int, int], free: float, *, has_room: bool) -> None:
        lines = [(line.text, line.is_fault) for line in self._viewer.messages.lines]
        lines += [(fault, True) for fault in self._faults]
        if not lines:
            return
        imgui.set_next_window_pos(
            ImVec2(_MARGIN, self._bottom), imgui.Cond_.always, ImVec2(0.0, 1.0)
        )
        if not has_room:
            imgui.set_next_window_bg_alpha(1.0)
        share = max(0.6 * window_size[0], _LINE * imgui.get_font_size())
        wrap = min(share, free - 4.0 * _MARGIN)
        if not has_room:
            wrap = window_size[0] - 4.0 * _MARGIN
        # Known beforehand, as of the status.
        sizes = [imgui.calc_text_size(text, False, wrap) for text, _ in lines]
        gaps = (len(lines) - 1) * imgui.get_style().item_spacing.y
        content = ImVec2(max(size.x for size in sizes), sum(size.y for size in sizes) + gaps)
        imgui.set_next_window_content_size(content)
        imgui.begin("messages", None, _SEE_THROUGH)
        if not has_room:
            imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
        imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + wrap)
        for text, is_fault in lines:
            if is_fault:
                imgui.text_colored(self._fault_color, text)
            else:
                imgui.text_unformatted(text)
        imgui.pop_text_wrap_pos()
        self._bottom -= imgui.get_window_height()
        imgui.end()

    def _names_of_sides(self, window_size: tuple[int, int], free: float) -> None:
        view = self._viewer.view
        if not view.is_split or not self._fits(2.5 * imgui.get_text_line_height_with_spacing()):
            return
        x = min(view.divider * window_size[0], free)
        names = (view.method, view.other_method)
        sides = (self._viewer.left, self._viewer.right)
        for name, shown, side, pivot in zip(names, sides, (-1.0, 1.0), (1.0, 0.0), strict=True):
            if side > 0.0 and x + imgui.calc_text_size(METHOD_LABELS[name]).x + 3 * _MARGIN > free:
                # The panel, which would be under it, says so, too.
                continue
            imgui.set_next_window_pos(
                ImVec2(x + side * _MARGIN, self._bottom - _MARGIN),
                imgui.Cond_.always,
                ImVec2(pivot, 1.0),
            )
            imgui.begin(f"side {side}", None, _SEE_THROUGH)
            imgui.text(METHOD_LABELS[name])
            if shown is not None and shown.image.sample_count:
                imgui.text_disabled(f"{shown.image.sample_count} of {shown.image.samples_wanted}")
            imgui.end()

    def _fits(self, height: float) -> bool:
        """Whether text has room between what is at the top and what is at the bottom."""
        height += 2.0 * imgui.get_style().window_padding.y
        return self._top + _MARGIN + height <= self._bottom

    def _legend(self, free: float) -> None:
        view = self._viewer.view
        other = METHOD_LABELS[view.other_method]
        unit = "" if view.kind is ColorMapping.VISIBILITY else " %"
        ends = view.error_range * (100.0 if unit else 1.0)
        texts = [f"{METHOD_LABELS[view.method]} against {other}"]
        monitor = self._viewer.monitor
        if monitor.error is not None:
            so_far = "" if monitor.is_error_final else " so far"
            known = monitor.uncertainty
            noise = "" if known is None else f", {known:.1%} of that uncertain"
            texts.append(f"rms error {monitor.error:.1%} of the mean{noise}{so_far}")
            if imgui.calc_text_size("  ".join(texts)).x < free - 6.0 * _MARGIN:
                texts = ["  ".join(texts)]
        room = free - 4.0 * _MARGIN
        sizes = [imgui.calc_text_size(text, False, room) for text in texts]
        gaps = len(texts) * imgui.get_style().item_spacing.y
        # Known beforehand, as of the status; of the width, the colours may take more.
        height = sum(size.y for size in sizes) + gaps + imgui.get_text_line_height()
        if not self._fits(height):
            return
        place = ImVec2(0.5 * free, self._top + _MARGIN)
        imgui.set_next_window_pos(place, imgui.Cond_.always, ImVec2(0.5, 0.0))
        imgui.set_next_window_content_size(ImVec2(0.0, height))
        imgui.begin("legend", None, _SEE_THROUGH)
        imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + room)
        for text in texts:
            imgui.text(text)
        imgui.pop_text_wrap_pos()
        imgui.text(f"-{ends:.3g}{unit}")
        imgui.same_line()
        corner = imgui.get_cursor_screen_pos()
        ends_width = 2.0 * imgui.calc_text_size(f"-{ends:.3g}{unit}").x + 8.0 * _MARGIN
        width = max(1.0, min(5.0 * self._scale, (free - ends_width) / _LEGEND_STEPS))
        height = imgui.get_text_line_height()
        draw = imgui.get_window_draw_list()
        for step in range(_LEGEND_STEPS):
            r, g, b = error_color(2.0 * step / (_LEGEND_STEPS - 1) - 1.0)
            color = imgui.color_convert_float4_to_u32(imgui.ImVec4(r, g, b, 1.0))
            left = ImVec2(corner.x + step * width, corner.y)
            draw.add_rect_filled(left, ImVec2(left.x + width, left.y + height), color)
        imgui.dummy(ImVec2(_LEGEND_STEPS * width, height))
        imgui.same_line()
        imgui.text(f"+{ends:.3g}{unit}")
        imgui.end()

    def _values(self) -> None:
        """What is under the cursor, beside it."""
        viewer = self._viewer
        drawing = viewer.inspected
        if self.wants_mouse:
            return
        # While a frame is in the making, what was read last is shown.
        if drawing is not None:
            self._reading = inspect(viewer.device.gl, drawing, self._host.cursor_uv())
        reading = self._reading
        if reading is None:
            return
        lines = [f"pixel  {reading.pixel[0]}, {reading.pixel[1]}"]
        if reading.position_ws is None:
            lines.append("background")
        else:
            lines.append(f"P  {shown_values(reading.position_ws)}")
            lines.append(f"z  {reading.depth:.5g}")
        if reading.normal_ws is not None:
            # Kept with 16 bits: further digits would be of the rounding.
            lines.append("n  " + "  ".join(f"{part:.4f}" for part in reading.normal_ws))
        lines += [f"{name}  {shown_values(values)}" for name, values in reading.values.items()]
        window = imgui.get_io().display_size
        widest = max(imgui.calc_text_size(line).x for line in lines)
        high = (len(lines) + 1) * imgui.get_text_line_height_with_spacing()
        # Smaller where that makes it fit.
        scale = min(1.0, _FULL * window.x / widest, _FULL * window.y / high)
        imgui.push_font(None, scale * imgui.get_style().font_size_base)
        imgui.set_next_window_content_size(ImVec2(scale * widest, 0.0))
        # ImGui leaves one that fits on no side of the cursor partly outside.
        padding, cursor = imgui.get_style().window_padding, imgui.get_mouse_pos()
        left = min(cursor.x + _MARGIN, window.x - scale * widest - 2.0 * padding.x)
        _place(left, max(0.0, min(cursor.y + _MARGIN, window.y - scale * high - 2.0 * padding.y)))
        imgui.begin_tooltip()
        for line in lines:
            imgui.text_unformatted(line)
        if not reading.is_finite:
            imgui.text_colored(self._fault_color, "not finite")
        imgui.end_tooltip()
        imgui.pop_font()


def _place(x: float, y: float) -> None:
    imgui.set_next_window_pos(ImVec2(x, y))
