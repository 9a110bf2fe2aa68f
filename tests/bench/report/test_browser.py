"""The page in a browser: what is typed is answered as Python answers it. Optional."""

from __future__ import annotations

import csv
import dataclasses
import io
import shutil
from html import unescape

import pytest
from bench.fake_bench import bench, pictures

from ssdo_gl.bench.analysis import front_of
from ssdo_gl.bench.measure.panels import panel_named
from ssdo_gl.bench.report.advice import cheapest_within, most_accurate_within
from ssdo_gl.bench.report.page import report_html

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no browser at hand")


@pytest.fixture(scope="module")
def found():
    """A bench with pictures of two references, and of a member of either's front."""
    both = [front_of(bench().results, name)[i].point.label for name, i in (("near", 0), ("gi", -1))]
    one = pictures()[0]
    kept = [
        dataclasses.replace(one, name=name, is_reference=i < 2, against=against)
        for i, (name, against) in enumerate(
            [("near", ""), ("paths", ""), (both[0], "near"), (both[1], "paths")]
        )
    ]
    return bench(pictures=kept)


@pytest.fixture(scope="module")
def page(found, tmp_path_factory):
    """The report of the fake bench on a telephone, at night."""
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(report_html(found))
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        view = browser.new_page(viewport={"width": 400, "height": 800}, color_scheme="dark")
        faults: list[str] = []
        view.on("pageerror", lambda fault: faults.append(str(fault)))
        view.on("console", lambda message: faults.append(message.text))
        view.goto(file.as_uri())
        yield view
        browser.close()
    assert faults == []


def setting(page, asked):
    return page.inner_text(f"#{asked}-answer .setting >> nth=0")


def test_what_is_typed_is_answered(page, found):
    for index, name in enumerate(("near", "gi", "visibility")):
        page.select_option("#judge", str(index))
        panel, front = panel_named(name), front_of(found.results, name)
        for ms in (5.5, 9.0, 40.0):
            page.fill("#have", str(ms))
            assert setting(page, "have") == most_accurate_within(front, ms).point.label
        for result in (front[-1], front[0]):
            percent = 101.0 * result.verdicts[name].error.value
            page.fill("#bear", str(percent))
            chosen = cheapest_within(front, panel, percent / 100.0)
            assert setting(page, "bear") == chosen.point.label
            command = unescape(page.inner_text("#bear-answer code >> nth=0"))
            assert command == found.command(chosen.point)
    page.fill("#have", "")
    assert "above 0" in page.inner_text("#have-answer")
    page.fill("#have", "30")
    page.select_option("#judge", "0")


def test_nothing_is_wider_than_a_telephone(page):
    assert page.evaluate("document.documentElement.scrollWidth") == 400


def test_files_can_be_downloaded(page, found):
    with page.expect_download() as waiting:
        page.click('a[download="points.csv"]')
    with open(waiting.value.path(), newline="") as file:
        text = file.read()
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["key"] for row in rows] == [r.point.key for r in found.results]


def test_a_mark_shows_its_picture_beside_its_reference_by_the_keyboard(page, found):
    for picture in reversed(found.pictures[2:]):
        page.focus(f'.dot.front[data-label="{picture.name}"] >> nth=0')
        assert page.inner_text("#name-left") != picture.name
        assert picture.name in page.inner_text("#tip")
        page.keyboard.press("Enter")
        assert page.inner_text("#name-left") == picture.name
        assert page.inner_text("#name-right") == picture.against


def test_a_heading_sorts(page):
    page.click('#points th button:text-is("ms")')
    cells = page.eval_on_selector_all(
        "#points tbody tr td:nth-child(2)", "cells => cells.map(cell => +cell.dataset.value)"
    )
    assert cells == sorted(cells)
