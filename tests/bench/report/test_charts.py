"""Charts: marks where their numbers are, and one key for all of them, by day and by night."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest
from bench.fake_bench import bench

from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.report import key
from ssdo_gl.bench.report.charts import LogChart, log_ticks, short
from ssdo_gl.bench.report.figures import (
    front_chart,
    samples_charts,
    scaling_charts,
    split_chart,
)
from ssdo_gl.bench.report.page import measured_panels, report_html
from ssdo_gl.bench.scaling import PARTS
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.methods import METHODS


@pytest.fixture(scope="module")
def found():
    return bench()


def test_equal_ratios_are_equal_lengths():
    chart = LogChart("t", "x", "y", [1.0, 100.0], [0.01, 1.0])
    (x1, y1), (x2, y2), (x3, y3) = (chart.place(10.0**i, 10.0 ** (i - 2)) for i in range(3))
    assert x2 - x1 == pytest.approx(x3 - x2) and x2 > x1
    assert y2 - y1 == pytest.approx(y3 - y2) and y2 < y1, "larger is higher"
    assert chart.place(1e9, 1e9) == chart.place(125.0, 1.25), "what is beyond stays at the edge"


def test_ticks_are_round_and_few():
    assert log_ticks(0.8, 12.0) == [1.0, 2.0, 5.0, 10.0]
    assert log_ticks(0.8, 1.2e4) == [1.0, 10.0, 100.0, 1e3, 1e4]
    assert [short(v) for v in (0.05, 20.0, 4e4, 2e6)] == ["0.05", "20", "40k", "2M"]


@pytest.mark.parametrize("values", [[], [0.0, float("nan")], [3.0]])
def test_any_values_make_a_chart(values):
    chart = LogChart("t", "x", "y", values, values)
    chart.curve(values, values, "curve")
    ET.fromstring(chart.svg())


def test_every_point_has_a_mark_at_its_numbers(found):
    for panel in measured_panels(found):
        svg = front_chart(found, panel).svg
        judged = [r for r in found.results if panel.name in r.verdicts]
        dots = re.findall(r'<g class="dot.*?</g>', svg, re.DOTALL)
        assert len(dots) == len(judged)
        on_front = [r for r in judged if r.verdicts[panel.name].on_front]
        assert sum("tabindex" in dot for dot in dots) == len(on_front)
        places = {}
        for dot in dots:
            label = re.search('data-label="([^"]*)"', dot)[1]
            place = re.search(r"translate\(([\d.]+) ([\d.]+)\)", dot)
            places[label] = tuple(map(float, place.groups()))
        by_time = sorted(judged, key=lambda r: r.timing.ms.value)
        by_error = sorted(judged, key=lambda r: -r.verdicts[panel.name].error.value)
        for order, axis in ((by_time, 0), (by_error, 1)):
            drawn = [places[r.point.label][axis] for r in order]
            assert drawn == sorted(drawn)


@pytest.mark.parametrize(("x", "anchor"), [(1.5, "end"), (90.0, "start"), (10.0, "start")])
def test_a_level_is_named_where_no_point_covers_its_name(x, anchor):
    chart = LogChart("t", "x", "y", [1.0, 100.0], [0.01, 1.0])
    chart.level(0.1, "the march, converged", [(x, 0.098), (1.5, 0.9)])
    (found,) = re.findall(r'text-anchor="(\w+)">the march', chart.svg())
    assert found == anchor


def test_one_colour_and_shape_for_a_name_in_every_chart(found):
    shown = {r.point.label: r.point for r in found.results}
    for panel in measured_panels(found):
        svg = front_chart(found, panel).svg
        for dot in re.findall(r'<g class="dot.*?</g>', svg, re.DOTALL):
            point = shown[re.search('data-label="([^"]*)"', dot)[1]]
            color = f"c{key.color_index(key.color_name(point))}"
            classes = re.findall('class="([^"]*)"', dot)
            assert f"mark {color}" in classes or f"mark {color} hollow" in classes
    # What the key draws is what the charts draw.
    entries = {text: element for element, text in key.entries(list(shown.values()))}
    for name in ESTIMATORS:
        if name in entries:
            assert f'c{key.color_index(name)}"' in entries[name]
    names = [key.color_index(n) for n in ("no estimator", "rays", *ESTIMATORS)]
    assert len(set(names)) == len(names), "no two share a colour"
    shapes = {key.marker(name) for name in METHODS}
    assert len(shapes) == len(METHODS), "no two share a shape"


def test_each_colour_is_readable_on_both_papers():
    def luminance(text):
        parts = [int(text[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    for dark, paper in ((False, "#f4f6f8"), (True, "#1f242a")):
        colors = re.findall(r"--(\w\d+):(#\w{6})", key.css_colors(dark=dark))
        assert len(colors) == len(key.COLORS) + 10
        for name, color in colors:
            low, high = sorted((luminance(color), luminance(paper)))
            # Of graphics the accessibility guidelines ask 3; yellow on white has less.
            least = 3.0 if name.startswith("c") else 1.7
            assert (high + 0.05) / (low + 0.05) >= least, (name, dark)


def test_parts_of_the_frame_have_one_colour_each(found):
    text = "".join(chart.svg for chart in scaling_charts(found))
    text += split_chart(found, found.results[:2]).svg
    assert {key.part_index(name) for name in PARTS.values()} == set(range(len({*PARTS.values()})))
    others = {key.part_index(name) for name in ("rest", "whole frame", "4 rays a pixel")}
    assert len(others) == 3 and min(others) == len({*PARTS.values()}), "nor do others share one"
    bounce = re.search(r'class="bar (p\d)"[^>]*><title>bounce:', text)
    assert bounce[1] == f"p{key.part_index('estimators')}"
    assert f'"curve {bounce[1]}"' in text


def test_a_single_sample_count_is_no_curve(found):
    few = [r for r in found.results if r.point.samples == 16 or r.point.filter != "none"]
    assert samples_charts(bench(results=few)) == []
    assert len(samples_charts(found)) == 2
    assert "No unfiltered settings were measured" in report_html(bench(results=few))


def test_a_point_shows_filter_and_resolution():
    full, half, plain = (
        key.point_mark(Point("radiance", "f", "bounce", "march", 16, 8, scale, name), 0.0, 0.0)
        for scale, name in ((1.0, "edge"), (0.5, "edge"), (1.0, "none"))
    )
    assert "hollow" in plain and "hollow" not in full + half
    assert full.replace("4.5", "3.2") == half != full
