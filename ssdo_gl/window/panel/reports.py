"""The sections of the panel that only show: times, reasons, the histogram."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from ssdo_gl.color import LUMINANCE
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.window.panel.pareto_chart import ChartPoint, chart_points, log_position
from ssdo_gl.window.panel.tooltip import show_tooltip
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS

# Five seconds at 60 Hz: long enough to see a level change and its reason go by.
PLOT_FRAMES = 300
_PLOT_HEIGHT = 52.0
# Of the histogram: stops relative to radiance 1, white at exposure 0, from what no display tells
# from black to a bright lamp.
STOPS = (-10.0, 6.0)
BINS_PER_STOP = 4
# Dark enough for the white text on it.
_BAR = imgui.ImVec4(0.20, 0.42, 0.62, 1.0)


class Reports:
    """Shows what the last frames cost and why each pass ran."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._times: deque[float] = deque(maxlen=PLOT_FRAMES)
        self._moving: deque[float] = deque(maxlen=10)
        self._histogram: NDArray[np.float64] | None = None
        self._histogram_of: object = None
        self._pass_ms: dict[str, float] = {}

    def note_frame(self, frame_ms: float) -> None:
        """Take the time of a frame."""
        self._times.append(frame_ms)
        if self._viewer.is_moving:
            self._moving.append(frame_ms)

    @property
    def frame_rate(self) -> float:
        """Frames per second of the last motion; 0 if there was none."""
        return 1e3 / max(float(np.median(self._moving)), 0.1) if self._moving else 0.0

    def frame_times(self) -> None:
        """Draw the plot of frame times with the budget's line as its middle."""
        times = np.array(self._times or [0.0], np.float32)
        budget = self._viewer.budget_ms
        imgui.plot_lines(
            "##frame times",
            times,
            scale_min=0.0,
            scale_max=2.0 * budget,
            graph_size=ImVec2(-1.0, _PLOT_HEIGHT),
        )
        # Beside the lines, not over them.
        left = self._viewer.left
        known = [f"moving: {self.frame_rate:.0f} frames/s"] if self._moving else []
        known += [f"at rest: {left.full_ms:.0f} ms a frame"] if left and left.full_ms else []
        imgui.text(", ".join(known) or "nothing was timed yet")

    def effects(self) -> None:
        """Draw a bar for each pass, with the reason why it ran or did not."""
        left = self._viewer.left
        if left is None or left.image.drawing is None:
            return
        drawing = left.image.drawing
        for row in drawing.passes:
            if row.ran and row.gpu_ms is not None:
                before = self._pass_ms.get(row.name, row.gpu_ms)
                # Bars that jump with every frame cannot be read.
                self._pass_ms[row.name] = before + 0.2 * (row.gpu_ms - before)
        ran = [row.name for row in drawing.passes if row.name in self._pass_ms and row.ran]
        longest = max((self._pass_ms[name] for name in ran), default=1.0)
        imgui.push_style_color(imgui.Col_.plot_histogram, _BAR)
        for row in drawing.passes:
            if row.name in ran:
                milliseconds = self._pass_ms[row.name]
                part = milliseconds / max(longest, 1e-6)
                text = f"{row.name}  {milliseconds:.2f} ms"
                imgui.progress_bar(part, ImVec2(-1.0, 0.0), text)
            else:
                kept = row.name in self._pass_ms
                imgui.text_disabled(f"{row.name}: {'kept' if kept else 'not run'}")
            if imgui.is_item_hovered():
                show_tooltip(row.reason)
        imgui.pop_style_color()
        imgui.separator()
        for decision in drawing.decisions:
            imgui.text_disabled("yes" if decision.run else "no ")
            imgui.same_line()
            imgui.text_wrapped(f"{decision.effect}: {decision.reason}")

    def pareto(self) -> None:
        """Draw the measured front, and where the present settings stand on it."""
        viewer = self._viewer
        left = viewer.left
        if left is None or not viewer.measured:
            imgui.text_disabled("nothing was measured")
            return
        settings = viewer.settings_of_side(0)
        points = chart_points(viewer.measured, settings, left.full_ms)
        if not points:
            imgui.text_disabled("known once the picture has come to rest")
            return
        live = (left.full_ms, viewer.monitor.error) if viewer.monitor.error is not None else None
        _draw_chart(points, left.full_ms, live)
        against = METHOD_LABELS[viewer.view.other_method]
        if live is not None:
            imgui.text_wrapped(f"now: {live[0]:.0f} ms, error {live[1]:.1%} against {against}")
        else:
            imgui.text_disabled(f"now: {left.full_ms:.0f} ms; X measures the error")

    def histogram(self) -> None:
        """Draw how often each radiance occurs in the picture, once it is at rest."""
        left = self._viewer.left
        if left is None or left.image.drawing is None:
            return
        drawing = left.image.drawing
        is_still = self._viewer.is_resting and not self._viewer.is_drawing
        is_due = is_still and left.image.is_refined
        if is_due and self._histogram_of is not drawing and "beauty" in drawing.planes:
            texture = drawing.planes["beauty"].texture
            self._histogram_of = drawing
            if texture is not None:
                self._histogram = radiance_histogram(read_texture(texture))
        if self._histogram is None:
            imgui.text_disabled("shown once the picture is at rest")
            return
        imgui.plot_histogram(
            "##histogram",
            self._histogram.astype(np.float32),
            overlay_text="luminance, 2^-10 to 2^6",
            scale_min=0.0,
            graph_size=ImVec2(-1.0, 1.5 * _PLOT_HEIGHT),
        )


def _draw_chart(
    points: Sequence[ChartPoint], live_ms: float, live: tuple[float, float] | None
) -> None:
    """Draw error (upwards) against time (to the right), both logarithmic."""
    size = ImVec2(imgui.get_content_region_avail().x, 2.6 * _PLOT_HEIGHT)
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(size)
    draw = imgui.get_window_draw_list()
    times = [p.frame_ms for p in points] + [live_ms]
    errors = [p.error for p in points] + ([live[1]] if live else [])
    # Half an octave of room, so that no point sits on the frame.
    time_range = min(times) / 1.4, max(times) * 1.4
    error_range = min(errors) / 1.4, max(errors) * 1.4

    def at(milliseconds: float, error: float) -> ImVec2:
        x = log_position(milliseconds, *time_range)
        y = log_position(error, *error_range)
        return ImVec2(corner.x + x * size.x, corner.y + (1.0 - y) * size.y)

    grey, white, yellow = (
        imgui.color_convert_float4_to_u32(imgui.ImVec4(*rgb, 1.0))
        for rgb in ((0.35, 0.36, 0.38), (0.9, 0.9, 0.9), (1.0, 0.85, 0.3))
    )
    draw.add_rect(corner, ImVec2(corner.x + size.x, corner.y + size.y), grey)
    for a, b in itertools.pairwise(points):
        draw.add_line(at(a.frame_ms, a.error), at(b.frame_ms, b.error), grey)
    mouse = imgui.get_mouse_pos()
    for point in points:
        place = at(point.frame_ms, point.error)
        draw.add_circle_filled(place, 4.0, yellow if point.is_used else white)
        if abs(mouse.x - place.x) < 7.0 and abs(mouse.y - place.y) < 7.0:
            show_tooltip(f"{point.label}\n{point.frame_ms:.1f} ms, error {point.error:.1%}")
    top = at(live_ms, error_range[1])
    draw.add_line(top, ImVec2(top.x, corner.y + size.y), yellow)
    if live is not None:
        draw.add_circle(at(*live), 6.0, yellow)
    text = f"{time_range[0]:.0f} to {time_range[1]:.0f} ms,  "
    text += f"error {error_range[0]:.1%} to {error_range[1]:.1%}"
    imgui.text_disabled(text)


def radiance_histogram(beauty: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the share of covered pixels in each bin of log2 luminance.

    Parameters
    ----------
    beauty : ndarray, shape (height, width, 4)
        Scene-linear, coverage in the fourth channel.

    Returns
    -------
    ndarray, shape (STOPS range * BINS_PER_STOP,)
        Sums to 1; what is darker or brighter counts in the first or last bin, what is
        not finite nowhere. Zeros if nothing is covered.
    """
    count = int((STOPS[1] - STOPS[0]) * BINS_PER_STOP)
    luminance = beauty[beauty[:, :, 3] > 0.0][:, :3].astype(np.float64) @ LUMINANCE
    luminance = luminance[np.isfinite(luminance)]
    if luminance.size == 0:
        return np.zeros(count)
    stops = np.log2(np.maximum(luminance, 2.0 ** STOPS[0]))
    bins = np.clip(((stops - STOPS[0]) * BINS_PER_STOP).astype(int), 0, count - 1)
    return np.asarray(np.bincount(bins, minlength=count) / luminance.size)
