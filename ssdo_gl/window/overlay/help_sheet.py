"""The list of keys: groups in as many columns as fit, over everything else."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui

from ssdo_gl.window.input import help_groups

_MARGIN = 10.0
# Between keys and meaning, and between columns, in heights of text.
_GAP, _COLUMN_GAP = 0.8, 1.6
# Smaller text cannot be read.
_SMALLEST = 0.7
_SCALES = (1.0, 0.85, _SMALLEST)
# Of text that is large already, in a window that is too narrow for it.
_NARROW_SCALES = (0.6, 0.5, 0.42, 0.35)
_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_nav
) & ~imgui.WindowFlags_.no_scrollbar


def draw_help(window_size: tuple[int, int]) -> None:
    """Issue the widgets, in the middle of the window; smaller where that makes them fit."""
    width, height = (side - 2.0 * _MARGIN for side in window_size)
    size = imgui.get_font_size()
    padding = 2.0 * imgui.get_style().window_padding.y
    column = _column_width()
    fits = [
        (scale, count)
        for scale in _SCALES
        for count in (1, 2, 3, 4)
        if scale * count * column < width and _height(count) * scale + padding < height
    ]
    # What has to be scrolled anyway may as well be large.
    room = width - imgui.get_style().scrollbar_size - padding
    wide = [scale for scale in (*_SCALES, *_NARROW_SCALES) if scale * column < room]
    wide = wide or [_NARROW_SCALES[-1]]
    scale, count = fits[0] if fits else (wide[0], max(1, int(width / (wide[0] * column))))
    centre = ImVec2(0.5 * window_size[0], 0.5 * window_size[1])
    imgui.set_next_window_pos(centre, imgui.Cond_.always, ImVec2(0.5, 0.5))
    imgui.set_next_window_size_constraints(ImVec2(0.0, 0.0), ImVec2(width, height))
    imgui.set_next_window_bg_alpha(1.0)
    imgui.set_next_window_focus()
    imgui.begin("keys", None, _FLAGS)
    imgui.push_font(None, scale * imgui.get_style().font_size_base)
    left = imgui.get_cursor_pos_x()
    keys_width = max(imgui.calc_text_size(keys).x for keys, _ in _rows())
    if imgui.begin_table("keys", count, imgui.TableFlags_.sizing_fixed_fit):
        for titles in _columns(count):
            imgui.table_next_column()
            for title in titles:
                imgui.text_disabled(title)
                for keys, meaning in help_groups()[title]:
                    imgui.text(keys)
                    imgui.same_line(left + keys_width + _GAP * size * scale)
                    imgui.text(f"{meaning}{'  ' if count > 1 else ''}")
                imgui.spacing()
        imgui.end_table()
    imgui.pop_font()
    imgui.end()


def _rows() -> list[tuple[str, str]]:
    return [row for rows in help_groups().values() for row in rows]


def _column_width() -> float:
    widths = [max(imgui.calc_text_size(row[i]).x for row in _rows()) for i in (0, 1)]
    return sum(widths) + (_GAP + _COLUMN_GAP) * imgui.get_font_size()


def _height(count: int) -> float:
    lengths = [sum(len(help_groups()[title]) + 1.4 for title in c) for c in _columns(count)]
    return max(lengths) * imgui.get_text_line_height_with_spacing()


def _columns(count: int) -> list[list[str]]:
    """Return the titles of the groups of each column: in order, as even as they come."""
    groups = help_groups()
    total = sum(len(rows) + 1 for rows in groups.values())
    columns: list[list[str]] = [[] for _ in range(count)]
    done = 0
    for title, rows in groups.items():
        middle = done + 0.5 * (len(rows) + 1)
        columns[min(count - 1, int(middle * count / total))].append(title)
        done += len(rows) + 1
    return columns
