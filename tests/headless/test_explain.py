"""What the explanation says adds up, and each decision gets what it saved once."""

from __future__ import annotations

import dataclasses
import io

import pytest
from rich.console import Console

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.headless.explain import (
    Explanation,
    Times,
    decisions_for_json,
    explain,
    explanation_table,
    summary,
)
from ssdo_gl.render_result import PassReport, RenderResult
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

DECISIONS = (
    Decision("sky", False, "it is plain", ("march", "filter"), ("lean",)),
    Decision("second march", False, "one is enough", ("bounce", "filter")),
    Decision("light", True, "there is a lamp", ("direct",)),
)
PASSES = (
    PassReport("lean", True, "instead", 1.5),
    PassReport("bounce", True, "it bounces", 2.0),
    PassReport("map", True, "shadows", 3.0),
    PassReport("march", False, "it is plain"),
)
RESULT = RenderResult({}, (4, 3), Settings(), PASSES, DECISIONS, (9.0,), 9.0)
PLANNED = Times({"lean": 1.0, "bounce": 2.0, "direct": 1.0}, 4.5)
FULL = Times({"march": 8.0, "filter": 2.0, "bounce": 7.0, "direct": 1.25}, 18.0)
MEASURED = Explanation(RESULT, PLANNED, FULL)


def printed(explanation):
    console = Console(file=io.StringIO(), width=120)
    console.print(explanation_table(explanation))
    return console.file.getvalue()


def test_every_pass_saves_what_it_no_longer_takes():
    assert MEASURED.saved_by_pass() == {
        "march": 8.0,
        "filter": 2.0,
        "bounce": 5.0,
        "direct": 0.25,
        "lean": -1.0,
    }


def test_every_pass_counts_for_one_decision():
    # What stands in for the march is taken off; the filter counts for the first only.
    assert MEASURED.saved_by_decision() == {"sky": 9.0, "second march": 5.0}


def test_without_measuring_nothing_is_claimed():
    plain = Explanation(RESULT)
    assert plain.saved_by_pass() == {} and plain.saved_by_decision() == {}
    assert summary(plain) is None
    assert [row["saved_ms"] for row in decisions_for_json(plain)] == [None, None, None]


def test_decisions_are_plain_data():
    assert decisions_for_json(MEASURED)[1] == {
        "effect": "second march",
        "run": False,
        "reason": "one is enough",
        "passes": ["bounce", "filter"],
        "saved_ms": 5.0,
    }
    assert decisions_for_json(MEASURED)[2]["saved_ms"] is None


def test_the_table_shows_cost_and_gain():
    lines = {line.split()[1]: line for line in printed(MEASURED).splitlines() if "│" in line}
    assert (
        "2.00" in lines["bounce"] and "5.0" in lines["bounce"] and "it bounces" in lines["bounce"]
    )
    assert "8.0" in lines["march"] and "no" in lines["march"] and "it is plain" in lines["march"]
    assert "kept after the first frame" in lines["map"]
    assert "9.0" in lines["(sky)"]
    assert "kept" not in printed(Explanation(RESULT)) and "3.00" in printed(Explanation(RESULT))


def test_the_summary_counts_passes_and_compares_frames():
    assert summary(MEASURED) == (
        "3 of 5 passes, 4.5 of 18.0 ms a frame (0.25 of the full pipeline)"
    )


@pytest.mark.parametrize(
    ("changes", "measured"),
    [({}, True), ({"effects": "full"}, False), ({"method": "reference-ao", "spp": 1}, False)],
)
def test_both_pipelines_are_timed_on_the_same_device(device, shaders, changes, measured):
    settings = dataclasses.replace(Settings(size=(32, 18), samples=8, steps=4), **changes)
    with Renderer(load_scene("corner"), settings, device=device, shaders=shaders) as renderer:
        result = renderer.render(["beauty"])
        explanation = explain(renderer, result)
        assert renderer.settings.effects == settings.effects
    assert (explanation.planned is not None) == measured
    if measured:
        assert set(explanation.full.passes) - set(explanation.planned.passes) == {
            "back_faces", "depth_layers", "directional", "directional_filter",
        }  # fmt: skip
        assert explanation.saved_by_decision()["directional occlusion"] > 0.0
