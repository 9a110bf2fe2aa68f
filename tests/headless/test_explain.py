"""What the explanation says adds up, and each decision gets what it saved once."""

from __future__ import annotations

import dataclasses
import io

import numpy as np
import pytest
from rich.console import Console

from ssdo_gl.effects.request import Decision
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.headless.explain import (
    Explanation,
    Spread,
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
VIEW = FrameView((4, 3), np.zeros(3), np.eye(3), (1.0, 1.0), 0.1, 1.0)
RESULT = RenderResult({}, VIEW, (4, 3), Settings(), PASSES, DECISIONS, (9.0,), 9.0)
LEAN = {"lean": 1.0, "bounce": 2.0, "direct": 1.0}
FULL = {"march": 8.0, "filter": 2.0, "bounce": 7.0, "direct": 1.0}
# One disturbed frame of each; the direct pass is the same work, so its differences are noise.
PLANNED_ROUNDS = [
    Times(LEAN | {"direct": 1.3}, 4.8),
    Times(LEAN, 4.5),
    Times(LEAN | {"bounce": 3.0}, 5.5),
]
FULL_ROUNDS = [
    Times(FULL, 18.5),
    Times(FULL | {"direct": 1.4}, 18.9),
    Times(FULL | {"march": 9.0}, 19.5),
]
MEASURED = Explanation(RESULT, PLANNED_ROUNDS, FULL_ROUNDS)


def printed(explanation):
    console = Console(file=io.StringIO(), width=140)
    console.print(explanation_table(explanation))
    return console.file.getvalue()


def rows_of(text):
    cells = [
        [c.strip() for c in line.split("│")[1:-1]] for line in text.splitlines() if "│" in line
    ]
    return {row[0]: row[1:] for row in cells}


def test_every_pass_saves_what_it_no_longer_takes():
    saved = MEASURED.saved_by_pass()
    assert saved["march"] == Spread(8.0, 8.0, 9.0)
    assert saved["bounce"] == Spread(5.0, 4.0, 5.0)
    assert saved["direct"] == Spread(0.0, pytest.approx(-0.3), pytest.approx(0.4))
    assert saved["lean"] == Spread(-1.0, -1.0, -1.0)
    assert {name for name, spread in saved.items() if spread.is_saving} == {
        "march", "filter", "bounce",
    }  # fmt: skip


def test_every_pass_counts_for_one_decision():
    # What stands in for the march is taken off; the filter counts for the first only.
    assert MEASURED.saved_by_decision() == {
        "sky": Spread(9.0, 9.0, 10.0),
        "second march": Spread(5.0, 4.0, 5.0),
    }


def test_without_measuring_nothing_is_claimed():
    plain = Explanation(RESULT)
    assert plain.saved_by_pass() == {} and plain.saved_by_decision() == {}
    assert summary(plain) is None and plain.typical() is None
    for row in decisions_for_json(plain):
        assert row["saved_ms"] is None and row["saved_ms_range"] is None


def test_decisions_are_plain_data():
    assert decisions_for_json(MEASURED)[1] == {
        "effect": "second march",
        "run": False,
        "reason": "one is enough",
        "passes": ["bounce", "filter"],
        "saved_ms": 5.0,
        "saved_ms_range": [4.0, 5.0],
    }
    assert decisions_for_json(MEASURED)[2]["saved_ms"] is None


def test_the_table_adds_up_to_the_frame():
    rows = rows_of(printed(MEASURED))
    parts = [*LEAN, "between passes"]
    shown = {name: row[1] for name, row in rows.items()}
    # The pass `map` is kept, `march` does not run, `direct` is timed but not listed here.
    assert shown["map"] == "" and "kept after the first frame" in rows["map"][3]
    total = sum(float(shown[name]) for name in parts if name in shown) + 1.3
    assert total == pytest.approx(float(shown["whole frame"]))
    assert shown["whole frame"] == "4.80", "the frame of median duration"


def test_the_table_shows_savings_with_their_range_and_no_noise():
    rows = rows_of(printed(MEASURED))
    assert rows["bounce"][:3] == ["yes", "2.00", "5.00 [4.00, 5.00]"]
    assert rows["march"][:3] == ["no", "", "8.00 [8.00, 9.00]"]
    assert rows["lean"][2] == "", "what a pass costs more is no saving"
    assert rows["(sky)"][2] == "9.00 [9.00, 10.00]"
    noisy = [Times({"bounce": 2.0 + 0.1 * i}, 3.0) for i in (-1, 0, 1)]
    same = Explanation(RESULT, noisy, noisy[::-1])
    assert {row[2] for row in rows_of(printed(same)).values()} == {""}
    assert "kept" not in printed(Explanation(RESULT)) and "3.00" in printed(Explanation(RESULT))


def test_the_summary_counts_every_pass_that_the_table_lists():
    # lean, bounce and map ran; march did not; the full pipeline has filter and direct, too.
    assert summary(MEASURED) == (
        "3 of 6 passes ran; 4.8 ms a frame, 18.9 with all of them: "
        "0.26 [0.24, 0.28] of the full pipeline's"
    )
    same = Explanation(RESULT, PLANNED_ROUNDS, PLANNED_ROUNDS[::-1])
    assert "no difference that could be told from noise" in summary(same)


@pytest.mark.parametrize(
    ("changes", "measured"),
    [({}, True), ({"effects": "full"}, False), ({"method": "reference-ao", "spp": 1}, False)],
)
def test_both_pipelines_are_timed_on_the_same_device(device, shaders, changes, measured):
    small = Settings(method="bounce", size=(32, 18), samples=8, steps=4)
    settings = dataclasses.replace(small, **changes)
    with Renderer(load_scene("corner"), settings, device=device, shaders=shaders) as renderer:
        result = renderer.render(["beauty"])
        said: list[str] = []
        explanation = explain(renderer, result, progress=lambda *step: said.append(step[0]))
        assert renderer.settings.effects == settings.effects
    assert bool(explanation.planned) == bool(said) == measured
    if measured:
        assert set(explanation.full[0].passes) - set(explanation.planned[0].passes) == {
            "back_faces", "depth_layers", "directional", "directional_filter",
            "reflections", "reflections_filter",
            "reflected_radiance",
        }  # fmt: skip
        assert explanation.saved_by_decision()["directional occlusion"].median > 0.0
        for times in (*explanation.planned, *explanation.full):
            assert sum(times.passes.values()) <= times.frame
