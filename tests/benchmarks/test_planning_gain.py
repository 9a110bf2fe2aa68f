"""The table of what planning saves, on one small scene."""

from __future__ import annotations

from benchmarks import planning_gain as bench_effects
from benchmarks.planning_gain import (
    SceneCost,
    main,
    measure,
    table_of,
)
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.scene.load import builtin_names, load_scene

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
        # Of a picture of one frame rays tell all light, from wherever they meet a surface.
        "cached_irradiance", "sender_radiance",
    }  # fmt: skip
    assert cost.passes_possible - cost.passes_run == len(spared)
    assert 0.0 < cost.planning_ms < cost.replanning_ms
    assert min(cost.planned, cost.gbuffer, cost.static, cost.planned_ms, cost.full_ms) > 0.0


def test_the_table_is_markdown():
    head, rule, row = table_of([COST]).splitlines()
    assert head.count("|") == rule.count("|") == row.count("|") == 10
    assert "7 of 11" in row and "0.125" in row and "0.50" in row


def test_scenes_are_measured_in_turn(monkeypatch, capsys):
    monkeypatch.setattr(bench_effects, "measure", lambda name, *_: COST)
    assert main(["corner", "furnace", "--size", "32x18"]) == 0
    assert capsys.readouterr().out.count("7 of 11") == 2
    assert main([]) == 0
    assert capsys.readouterr().out.count("7 of 11") == len(builtin_names()) > 5
