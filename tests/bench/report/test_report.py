"""The report: valid HTML that needs nothing else, with the bench's numbers in it."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
from html import escape
from html.parser import HTMLParser

import pytest
from bench.fake_bench import bench
from rich.console import Console

from ssdo_gl.bench.analysis import front_of
from ssdo_gl.bench.measure.errors import Scalars
from ssdo_gl.bench.measure.machine import CLOCK_NAMES
from ssdo_gl.bench.report import outputs, plots, terminal
from ssdo_gl.bench.report.page import report_html
from ssdo_gl.bench.report.tables import part_text
from ssdo_gl.bench.statistics.bootstrap import Interval

pytest.importorskip("matplotlib")

# Elements that have no end tag in HTML.
VOID = {"meta", "img", "input", "br", "link"}


class Page(HTMLParser):
    """Collects elements and complains about tags that do not match."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: dict[str, str] = {}
        self.all_text: list[str] = []
        self.faults: list[str] = []
        self.feed(text)
        self.close()
        self.faults += [f"<{tag}> is never closed" for tag in self.open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> closes nothing at {self.getpos()}")

    def handle_data(self, data: str) -> None:
        self.all_text.append(data)
        if self.open:
            key = self.open[-1]
            self.text[key] = self.text.get(key, "") + data

    def values(self, name: str) -> list[str]:
        return [v for _, attributes in self.tags if (v := attributes.get(name)) is not None]


@pytest.fixture(scope="module")
def page() -> Page:
    return Page(report_html(bench()))


def test_every_tag_is_closed(page):
    assert page.faults == []


def test_the_checker_sees_a_fault():
    assert Page("<p><b>x</p>").faults
    assert Page("<p>x").faults


def test_nothing_is_fetched_from_elsewhere(page):
    for name in ("src", "href", "data", "action", "poster", "srcset"):
        for value in page.values(name):
            assert value.startswith("data:"), f"{name}={value[:60]}"
    assert not re.search(r"url\((?!#)|@import", page.text["style"])
    assert "fetch(" not in page.text["script"]
    assert "XMLHttpRequest" not in page.text["script"]
    policy = next(a["content"] for t, a in page.tags if t == "meta" and "http-equiv" in a)
    assert policy is not None
    assert policy.startswith("default-src 'none'"), "the browser refuses anything external"


def test_ids_are_unique(page):
    ids = page.values("id")
    assert len(ids) == len(set(ids))


def test_user_text_is_escaped(page):
    assert page.text["h1"] == "A <room> & more: what accuracy costs"
    assert not any(tag in ("angle", "room", "device") for tag, _ in page.tags)


def test_the_data_of_the_script_can_be_read_and_cannot_end_it():
    found = bench()
    text = report_html(found)
    raw = text.partition('<script type="application/json" id="data">')[2].partition("</script>")[0]
    assert not set("<>&") & set(raw)
    cards = [candidate["card"] for panel in json.loads(raw) for candidate in panel["front"]]
    assert len(cards) == len(set(cards)) > len(front_of(found.results, "near"))
    for name in cards:
        assert f'<template id="card-{name}">' in text


def test_pictures_are_in_the_page_with_their_maps_and_a_scale():
    found = bench()
    text = report_html(found)
    for i, picture in enumerate(found.pictures):
        assert escape(picture.name) in text
        for name, png in (("picture", picture.png), ("flip", picture.flip_png)):
            tag = re.search(f'<img id="{name}-{i}" [^>]*base64,([^"]*)"', text)
            assert (base64.b64decode(tag[1]) if tag else None) == png
    # The colours of `pictures.flip_map_png`, from no difference to the largest.
    assert "linear-gradient(to right, #000004" in text
    assert "#fcfdbf)" in text


def test_every_setting_has_a_row(page):
    assert sum(tag == "tr" for tag, _ in page.tags) >= len(bench().results)
    assert "bounce march 8x8 full edge" in page.text["td"]


def test_failed_pixels_are_shown(page):
    found = bench()
    verdict = found.results[0].verdicts["near"]
    broken = dataclasses.replace(
        verdict, scalars=dataclasses.replace(verdict.scalars, failures=12345)
    )
    result = dataclasses.replace(found.results[0], verdicts={"near": broken})
    text = report_html(bench(results=[result, *found.results[1:]]))
    assert '<td data-value="12345" class="failed">12345</td>' in text
    assert 'class="failed"' not in report_html(found)


def test_an_unsure_reference_is_called_unsure():
    found = bench()
    poor = {
        name: dataclasses.replace(reference, standard_error=0.02)
        for name, reference in found.references.items()
    }
    assert "less sure" in report_html(bench(references=poor))
    assert "less sure" not in report_html(found)


def test_a_part_whose_error_is_the_references_noise_is_not_called_exact():
    assert part_text(0.0) == "within noise"
    assert part_text(0.0123) == "1.23 %"


def test_one_clock_is_named_for_frames_and_passes():
    found = bench(clock="process")
    page = Page(report_html(found))
    clock = CLOCK_NAMES["process"]
    assert f"By the clock of the table ({clock})" in page.text["figcaption"]
    names = [f"frame time, ms ({clock})"] * len(found.references)
    names += [f"ms ({clock})"] * len(found.series)
    assert [t for t in page.all_text if clock in t and t.startswith(("frame", "ms"))] == names


def test_a_report_without_pictures_scaling_or_splits_is_still_a_report():
    text = report_html(bench(pictures=[], series=[], splits={}))
    assert Page(text).faults == []
    assert "No pictures were kept" in text


@pytest.mark.parametrize("scale", [0.0, float("inf"), float("nan")])
def test_errors_without_a_logarithm_do_not_stop_the_report(scale):
    found = bench()
    odd = [
        dataclasses.replace(
            result,
            verdicts={
                name: dataclasses.replace(
                    verdict,
                    error=Interval(scale, scale, scale),
                    on_front=False,
                    scalars=Scalars(noise=scale, systematic=scale),
                )
                for name, verdict in result.verdicts.items()
            },
        )
        for result in found.results
    ]
    assert Page(report_html(bench(results=odd, splits={}))).faults == []


def test_the_same_bench_gives_the_same_bytes(page):
    assert Page(report_html(bench())).tags == page.tags


def test_the_terminal_says_it_in_about_ten_lines():
    file = open("/dev/null", "w")  # noqa: SIM115
    console = Console(record=True, width=120, file=file, soft_wrap=True)
    with console.file:
        terminal.print_summary(bench(), console)
    lines = [line for line in console.export_text().splitlines() if line.strip()]
    assert len(lines) <= 11
    assert any(line.startswith("take ") for line in lines)
    assert any(line.startswith("of all light: take ") for line in lines)
    command = bench().command(bench().recommendation.result.point)
    assert lines[-1] == command
    assert "--size 320x180" in command and "--antialias 1" in command
    # As the scene was loaded that was measured.
    assert "--up z" in command


def test_rows_of_the_terminal_keep_both_ends_and_the_recommended_one():
    found = bench().results
    front = sorted(found, key=lambda r: r.timing.frame_ms.value)
    for always in front:
        rows = terminal.chosen_rows(front, always)
        assert len(rows) == terminal.MAX_ROWS
        assert rows[0] is front[0]
        assert rows[-1] is front[-1]
        assert always in rows
    assert terminal.chosen_rows(front[:3], None) == front[:3]


def test_files_are_written(tmp_path):
    outputs.write_report(bench(), tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"points.csv", "bench.json", "pareto.png", "pareto.svg", "report.html"}
    lines = (tmp_path / "points.csv").read_text().splitlines()
    assert len(lines) == 1 + len(bench().results)
    assert lines[0].startswith("key,label,")
    assert json.loads((tmp_path / "bench.json").read_text())["machine"]["cores"] == 2


def test_no_legend_of_a_plot_hides_points():
    figure = plots.pareto_figure(bench())
    plots.as_bytes(figure, "png")
    assert figure.axes
    for chart in figure.axes:
        assert chart.get_legend().get_window_extent().y1 < chart.bbox.y0


def test_the_line_of_the_converged_march_is_named_where_no_point_can_lie():
    for chart in plots.pareto_figure(bench()).axes:
        lines = [line for line in chart.get_lines() if line.get_linestyle() == "--"]
        named = [text.get_text() for text in chart.get_legend().get_texts()]
        assert named.count("the march, converged") == len(lines)
        assert all("converged" not in text.get_text() for text in chart.texts)
    assert lines


def test_a_missing_library_is_noticed_before_any_work(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(Exception, match=r"ssdo_gl\[bench\]"):
        outputs.check_libraries()
