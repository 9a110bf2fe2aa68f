"""The table of what planning saves, on one small scene."""

from __future__ import annotations

import dataclasses

from benchmarks import planning_gain as bench_effects
from benchmarks.planning_gain import (
    SceneCost,
    analysis_ms,
    built_in_scenes,
    main,
    measure,
    table_of,
    targets_of,
)
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings.resolve import settings_for

COST = SceneCost("room", 7, 11, 50.0, 100.0, 0.5, 0.125, 0.0015, 0.004, 0.25)


def test_a_scene_s_cost():
    scene = load_scene("corner")
    cost = measure("corner", scene, settings_for(scene.render, {"size": (48, 27)}), rounds=1)
    # One light, no sky, no solid, nothing that emits or shines: of all passes, these are spared.
    spared = {
        "back_faces", "depth_layers", "directional", "directional_filter",
        "reflectance_table", "reflections", "reflections_filter", "reflected_radiance",
        "glow_tree", "emitters", "emitters_filter",
        # The sum of the terms is written as a display shows it.
        "tone_map",
    }  # fmt: skip
    assert cost.passes_possible - cost.passes_run == len(spared)
    assert 0.0 < cost.planning_ms < cost.replanning_ms
    assert min(cost.planned, cost.gbuffer, cost.static, cost.planned_ms, cost.full_ms) > 0.0


def test_the_table_is_markdown():
    head, rule, row = table_of([COST]).splitlines()
    assert head.count("|") == rule.count("|") == row.count("|") == 10
    assert "7 of 11" in row and "0.125" in row and "0.50" in row


def test_targets_stand_beside_the_worst_that_was_measured():
    corner = dataclasses.replace(COST, scene="corner", planned=0.47, gbuffer=0.01)
    rows = targets_of([COST, corner], {"a ball": 51.0}).splitlines()[2:]
    assert rows[0].endswith("| 0.5 | 0.47 | yes |")
    assert rows[1].endswith("| 0.25 | 0.125 | yes |")
    assert rows[2].endswith("| 0.1 | 0.0015 | yes |")
    assert rows[3].endswith("| 0.2 | 0.004 | yes |")
    assert "a ball" in rows[4] and rows[4].endswith("| 50 | 51 | no |")
    assert len(targets_of([COST], {}).splitlines()) == 2 + 3


def test_content_is_analysed_in_several_guises(monkeypatch):
    monkeypatch.setattr(bench_effects, "ANALYSED_TRIANGLES", 3000)
    monkeypatch.setattr(bench_effects, "ROUNDS", 1)
    times = analysis_ms()
    assert len(times) == 4 and min(times.values()) > 0.0
    assert "boxes, 3000 triangles" in times


def test_scenes_are_measured_in_turn(monkeypatch, capsys):
    monkeypatch.setattr(bench_effects, "measure", lambda name, *_: COST)
    monkeypatch.setattr(bench_effects, "analysis_ms", lambda: {"a ball": 1.0})
    assert main(["corner", "furnace", "--size", "32x18"]) == 0
    assert capsys.readouterr().out.count("7 of 11") == 2
    assert main([]) == 0
    assert capsys.readouterr().out.count("7 of 11") == len(built_in_scenes()) > 5
