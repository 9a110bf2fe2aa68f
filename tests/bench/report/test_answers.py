"""A time or an error is answered with the best that was measured, by the page as in Python."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from html import unescape
from importlib.resources import files

import pytest
from bench.fake_bench import bench

from ssdo_gl.bench.analysis import front_of, recommend
from ssdo_gl.bench.measure.panels import error_panels, panel_named
from ssdo_gl.bench.presets import NAMES
from ssdo_gl.bench.report.advice import (
    answer_data,
    answer_section,
    card,
    cheapest_within,
    measured_panels,
    most_accurate_within,
    parts_section,
    presets_section,
    recommendations,
    usual_answers,
)

BOUNDS_MS = (0.1, 5.0, 8.0, 12.0, 30.0, 1e6)
BOUNDS = (1e-6, 0.03, 0.05, 0.08, 0.5, 10.0)


@pytest.fixture(scope="module")
def found():
    return bench()


@pytest.mark.parametrize("panel", ["near", "gi", "visibility"])
def test_nothing_measured_is_a_better_answer(found, panel):
    def error(result):
        return result.verdicts[panel].error.value

    judged = [r for r in found.results if panel in r.verdicts]
    front = front_of(found.results, panel)
    for bound in BOUNDS_MS:
        fitting = [r for r in judged if r.timing.ms.value <= bound]
        chosen = most_accurate_within(front, bound)
        assert (chosen is None) == (not fitting)
        if chosen is not None:
            assert chosen.timing.ms.value <= bound
            assert error(chosen) == min(map(error, fitting))
    for bound in BOUNDS:
        fitting = [r for r in judged if error(r) <= bound]
        chosen = cheapest_within(front, panel_named(panel), bound)
        assert (chosen is None) == (not fitting)
        if chosen is not None:
            assert error(chosen) <= bound
            assert chosen.timing.ms.value == min(r.timing.ms.value for r in fitting)


def test_the_script_of_the_page_looks_up_the_same(found):
    node = shutil.which("node")
    if node is None:
        pytest.skip("no JavaScript at hand")
    fronts = [panel["front"] for panel in answer_data(found)]
    script = files("ssdo_gl.bench.report").joinpath("report.js").read_text(encoding="utf-8")
    lookup = "\n".join(re.findall(r"^function (?:mostAcc|cheapest).*$", script, re.MULTILINE))
    program = f"""{lookup}
    const out = [];
    for (const front of {json.dumps(fronts)}) {{
      for (const ms of {json.dumps(BOUNDS_MS)}) out.push(mostAccurateWithin(front, ms));
      for (const error of {json.dumps(BOUNDS)}) out.push(cheapestWithin(front, error));
    }}
    console.log(JSON.stringify(out.map(c => c && c.card)));"""
    done = subprocess.run([node, "-e", program], capture_output=True, text=True, check=True)
    expected = []
    for panel in measured_panels(found):
        front = front_of(found.results, panel.name)
        chosen = [most_accurate_within(front, ms) for ms in BOUNDS_MS]
        chosen += [cheapest_within(front, panel, error) for error in BOUNDS]
        expected += [c and f"{panel.name}-{front.index(c)}" for c in chosen]
    assert json.loads(done.stdout) == expected
    assert None in expected


def test_an_answer_holds_setting_error_time_certainty_and_command(found):
    panel = panel_named("near")
    result = front_of(found.results, "near")[-1]
    verdict = result.verdicts["near"]
    text = unescape(re.sub("<[^>]*>", "", card(found, panel, result)))
    for part in (
        result.point.label,
        f"{100 * verdict.error.value:.3g} %",
        f"{100 * verdict.error.low:.3g} % to {100 * verdict.error.high:.3g} %",
        f"{result.timing.ms.value:.3g} ms",
        f"{100 * verdict.confidence:.0f} % sure",
        f"bounce alone{100 * verdict.scalars.parts['bounce']:.3g} %",
        found.command(result.point),
    ):
        assert part in text
    assert "--size 320x180" in text and "--antialias 1" in text and "'a <b>.toml'" in text


def test_every_panel_can_be_asked(found):
    section = answer_section(found)
    for panel in error_panels():
        assert f">{panel.title}</option>" in section
    assert section.count('<input type="number"') == 2
    only = [
        dataclasses.replace(r, verdicts={"gi": r.verdicts["gi"]})
        for r in found.results
        if "gi" in r.verdicts
    ]
    few = bench(results=only, recommendation=recommend(only, "gi"))
    assert len(answer_data(few)) == 1
    assert answer_section(few).count("<option") == 1


def test_who_has_no_number_is_told_by_each_reference_of_pictures(found):
    text = unescape(recommendations(found))
    for name in ("near", "gi"):
        sentence = recommend(found.results, name).sentence
        assert f"{panel_named(name).title}: {sentence}." in text
    assert "isibility" not in text


def test_nothing_measured_is_no_fault():
    assert "No error was measured" in answer_section(bench(results=[]))


def test_usual_bounds_are_answered_without_a_script(found):
    rows = usual_answers(found).split("<tr>")
    front = front_of(found.results, "near")
    row = next(row for row in rows if "30 frames a second: 33.3 ms" in row)
    assert most_accurate_within(front, 1000 / 30).point.label in row
    assert "nothing measured" in next(row for row in rows if "3 % error" in row)


def test_presets_and_budgets_are_explained_with_complete_commands(found):
    section = presets_section(found)
    codes = re.findall("<code>(.*?)</code>", section)
    commands = [unescape(re.sub("<[^>]*>", "", code)) for code in codes]
    for name in NAMES:
        asked = [c for c in commands if c.endswith(f"--preset {name}")]
        assert len(asked) == 1 and "--size 320x180" in asked[0] and "--antialias 1" in asked[0]
    assert any(c.endswith("--budget-ms 30") and "--snapshot" in c for c in commands)
    assert any(c.endswith("--max-error 0.05") and "--snapshot" in c for c in commands)
    # The one preset that the quick grid holds.
    here = next(r for r in found.results if r.point.key == "radiance-bounce-march-n32-m8-s1-edge")
    row = next(row for row in section.split("<tr>") if row.startswith("<td>balanced<"))
    assert f"<td>{here.timing.ms.value:.3g}</td>" in row


def test_the_worst_part_is_a_heading(found):
    verdict = found.recommendation.result.verdicts["near"]
    share = f"{100 * verdict.scalars.parts['bounce']:.3g} %"
    section = parts_section(found)
    assert f"<h2>Bounce alone is {share} wrong" in section
    assert section.index("</b> bounce") < section.index("</b> directional"), "worst first"
    none = dataclasses.replace(verdict, scalars=dataclasses.replace(verdict.scalars, parts={}))
    result = dataclasses.replace(found.recommendation.result, verdicts={"near": none})
    kept = dataclasses.replace(found.recommendation, result=result)
    assert parts_section(bench(recommendation=kept)) == ""
