"""The ladder in minutes: what it is measured on, and what comes of it."""

from __future__ import annotations

import pytest

from benchmarks import rungs
from benchmarks.preset_ladder import BASELINE
from ssdo_gl.bench.measure import read_grid
from ssdo_gl.bench.presets import FIELDS, read_ladder


def test_its_grid_holds_the_baseline_and_the_shipped_rungs():
    points = read_grid(rungs.GRID)
    assert BASELINE in {point.key for point in points}
    measured = [{name: getattr(point, name) for name in FIELDS} for point in points]
    assert all(rung.fields() in measured for rung in read_ladder().rungs)


FAMILY = """
[[family]]
name = "{name}"
kind = "radiance"
method = "bounce"
estimator = "{estimator}"
samples = {samples}
steps = 1
resolution_scale = 1.0
filter = "{filter}"
"""


def test_two_settings_of_a_scene_make_a_ladder(monkeypatch, tmp_path, capsys):
    grid = tmp_path / "grid.toml"
    paper = FAMILY.format(name=rungs.PAPER[0], estimator="rgs09", samples=8, filter="naive")
    march = FAMILY.format(name=rungs.MARCH[1], estimator="march", samples=16, filter="edge")
    grid.write_text(paper + march)
    monkeypatch.setattr(rungs, "GRID", grid)
    monkeypatch.setattr(rungs, "ROUNDS", 1)
    monkeypatch.setattr(rungs, "REFERENCE_GOAL", 0.1)
    assert rungs.main([str(tmp_path / "out"), "corner", "--size", "48x27"]) == 0
    printed = capsys.readouterr().out
    assert "| bounce rgs09 8 full naive | 1.00 | 1.00 |" in printed
    ladder = read_ladder(printed[printed.index("[source]") :])
    assert ladder.source["benches"] == ["corner 48x27"]
    best = ladder.rungs[-1]
    assert (best.estimator, best.samples) == ("march", 16)
    assert 0.0 < best.error < 1.0
    lines = (tmp_path / "out" / "corner.csv").read_text().splitlines()
    assert len(lines) == 3


def test_a_size_that_is_none_is_refused_in_one_line(tmp_path, capsys):
    with pytest.raises(SystemExit) as refused:
        rungs.main([str(tmp_path), "corner", "--size", "wide"])
    assert refused.value.code == 2
    assert "size" in capsys.readouterr().err.splitlines()[-1]
