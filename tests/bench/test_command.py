"""The bench and the choices as a user meets them, on a real device."""

from __future__ import annotations

import csv
import html
import json
import re
import shlex

import numpy as np
import pytest

from ssdo_gl.bench import presets
from ssdo_gl.bench import run as bench
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.estimators import estimator_table
from ssdo_gl.bench.measure import read_grid
from ssdo_gl.bench.run import BenchPlan, run_bench
from ssdo_gl.bench.storage import ROUNDS, append_line
from ssdo_gl.cli import main
from ssdo_gl.options.idle import idle_in_pictures
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values

pytest.importorskip("matplotlib")
pytest.importorskip("flip_evaluator")

GRID = """
[[family]]
name = "paper's ssdo, naive blur"
kind = "radiance"
method = "bounce"
estimator = "rgs09"
samples = 8
filter = "naive"

[[family]]
name = "march, full resolution"
kind = "radiance"
method = "bounce"
estimator = "march"
samples = [16, 64]
steps = 8
filter = "edge"
[family.quick]

[[family]]
name = "rays"
kind = "visibility"
method = "reference-ao"
spp = [4, 64]
"""
PLAN = BenchPlan(2, 2, 2, 20.0, 32, flips=())


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "cache"))


def test_a_bench_of_a_real_scene(tmp_path, monkeypatch):
    # Scaling opens scenes of up to 400 000 triangles: not for a test of seconds.
    monkeypatch.setattr(bench.scaling, "measure_scaling", lambda *arguments: [])
    grid = tmp_path / "grid.toml"
    grid.write_text(GRID)
    outdir = tmp_path / "out"
    settings = Settings(size=(48, 36), seed=5)
    monkeypatch.setattr(bench, "points_of_bench", lambda quick: read_grid(grid))
    found = run_bench("corner", settings, outdir, plan=PLAN, quiet=True, command="x")
    assert {path.name for path in outdir.iterdir()} >= {
        "points.csv", "bench.json", "pareto.png", "pareto.svg", "report.html", "rounds.csv",
    }  # fmt: skip
    with (outdir / "points.csv").open(newline="") as file:
        rows = {row["key"]: row for row in csv.DictReader(file)}
    assert len(rows) == 5
    few, many = (
        float(rows[f"visibility-reference-ao-spp{n}"]["visibility_error"]) for n in (4, 64)
    )
    # Independent rays would give a quarter; the sampler's stratification does better.
    assert 0.0 < many < 0.4 * few
    paper = float(rows["radiance-bounce-rgs09-n8-m1-s1-naive"]["near_error"])
    march = float(rows["radiance-bounce-march-n64-m8-s1-edge"]["near_error"])
    assert march < paper
    assert all(float(row["frame_ms"]) > 0.0 for row in rows.values())
    assert json.loads((outdir / "bench.json").read_text())["machine"]["command"] == "x"
    assert found.references["near"].ratio < 1.0
    assert all(split for split in found.splits.values())
    check_commands(found, tmp_path)


def check_commands(found: Bench, tmp_path) -> None:
    """Each point's command, as the report prints it, renders what was measured of it."""
    stats, out = tmp_path / "s.json", tmp_path / "out.npz"
    report = re.sub("</?span>", "", (tmp_path / "out" / "report.html").read_text())
    for result in found.results:
        command = found.command(result.point)
        assert html.escape(command) in report
        words = [str(out) if word == "out.png" else word for word in shlex.split(command)]
        assert words[0] == "ssdo-gl"
        assert main([*words[1:], "--stats", str(stats), "--quiet"]) == 0
        settings, used = result.point.settings(found.base), settings_of(stats)
        for name, value in json.loads(json.dumps(values(settings))).items():
            # What has no effect needs no flag, and would be refused.
            is_idle = idle_in_pictures(settings, name, result.point.wanted)
            assert is_idle or used[name] == value, name
        with np.load(out) as arrays:
            assert result.point.wanted[0] in arrays


def test_ctrl_c_says_that_the_bench_can_go_on(tmp_path, monkeypatch, capsys):
    def pressed(run, *arguments):
        append_line(run.outdir / ROUNDS, "a,1")
        raise KeyboardInterrupt

    monkeypatch.setattr(bench.BenchRun, "measure", pressed)
    out = tmp_path / "out"
    assert main(["corner", "--bench", str(out), "--quiet"]) == 130
    assert f"{out} keeps what was measured" in capsys.readouterr().err


@pytest.mark.parametrize("flags", [[], ["--estimators"]])
@pytest.mark.parametrize("names", [["out"], ["out", "mine.txt"]])
def test_ctrl_c_before_anything_is_measured_leaves_nothing(
    tmp_path, monkeypatch, capsys, flags, names
):
    def pressed(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(bench, "describe_machine", pressed)
    monkeypatch.setattr(estimator_table, "write", pressed)
    out = tmp_path.joinpath(*names[:1])
    for name in names[1:]:
        out.mkdir()
        (out / name).write_text("of the user")
    before = sorted(tmp_path.rglob("*"))
    assert main(["corner", "--bench", str(out), "--quiet", *flags]) == 130
    assert sorted(tmp_path.rglob("*")) == before
    assert "keeps" not in capsys.readouterr().err


def refused(capsys, arguments: list[str]) -> str:
    assert main(arguments) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


def test_mistakes_are_named(tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert "file" in refused(capsys, ["corner", "--bench", str(blocked / "out")])
    assert "--bench" in refused(capsys, ["corner", "--quick", "--snapshot", "x.png"])
    out = str(tmp_path / "x.png")
    assert "--snapshot" in refused(
        capsys, ["corner", "--bench", str(tmp_path / "b"), "--snapshot", out]
    )
    assert "did you mean 'fine'" in refused(
        capsys, ["corner", "--preset", "fin", "--snapshot", out]
    )
    assert "--budget-ms = 0.0" in refused(capsys, ["corner", "--budget-ms", "0", "--snapshot", out])
    assert "one of them" in refused(
        capsys, ["corner", "--budget-ms", "9", "--max-error", "0.1", "--snapshot", out]
    )
    assert "direct" in refused(
        capsys, ["corner", "--method", "direct", "--budget-ms", "9", "--snapshot", out]
    )


def test_a_folder_of_the_user_is_left_alone(tmp_path, capsys):
    (tmp_path / "errors").mkdir()
    (tmp_path / "errors" / "mine.txt").write_text("years of work")
    assert "holds errors" in refused(capsys, ["corner", "--bench", str(tmp_path), "--quick"])
    assert (tmp_path / "errors" / "mine.txt").read_text() == "years of work"


SMALL = ["--size", "48x36", "--antialias", "1"]


def settings_of(path) -> dict[str, object]:
    content = json.loads(path.read_text())
    settings: dict[str, object] = content["settings"]
    return settings


def test_a_preset_sets_what_no_flag_does(tmp_path):
    stats = tmp_path / "s.json"
    fast = presets.load_preset("fast")
    arguments = ["corner", *SMALL, "--snapshot", str(tmp_path / "x.png"), "--stats", str(stats)]
    assert main([*arguments, "--preset", "fast", "--samples", "24"]) == 0
    used = settings_of(stats)
    assert used["samples"] == 24
    assert used["resolution_scale"] == fast["resolution_scale"]


def test_a_generous_budget_gives_the_best_setting(tmp_path, capsys):
    stats = tmp_path / "s.json"
    arguments = ["corner", *SMALL, "--snapshot", str(tmp_path / "x.png"), "--stats", str(stats)]
    # A 48x36 frame takes milliseconds with any setting; ten minutes are enough.
    assert main([*arguments, "--budget-ms", "600000"]) == 0
    best = presets.read_ladder().rungs[-1]
    assert settings_of(stats)["samples"] == best.samples
    assert capsys.readouterr().out.startswith(f"chose {best.label}")


def test_an_impossible_budget_still_gives_a_picture(tmp_path, capsys):
    out = tmp_path / "x.png"
    assert main(["corner", *SMALL, "--snapshot", str(out), "--budget-ms", "0.001"]) == 0
    assert out.exists()
    assert "no measured setting fits 0.001 ms" in capsys.readouterr().err


def test_a_generous_error_gives_the_cheapest_setting(tmp_path, capsys):
    stats = tmp_path / "s.json"
    arguments = ["corner", *SMALL, "--snapshot", str(tmp_path / "x.png"), "--stats", str(stats)]
    assert main([*arguments, "--max-error", "10"]) == 0
    assert "calibrated in" in capsys.readouterr().out
    cheapest = presets.read_ladder().rungs[0]
    assert settings_of(stats)["samples"] == cheapest.samples
    assert settings_of(stats)["method"] == "ssdo"
    assert main([*arguments, "--max-error", "10"]) == 0
    assert "calibrated before" in capsys.readouterr().out


def test_all_light_within_a_bound_takes_gi(tmp_path, capsys):
    """Of corner `bounce` misses a quarter of the light."""
    stats = tmp_path / "s.json"
    out = tmp_path / "x.png"
    arguments = ["corner", *SMALL, "--snapshot", str(out), "--stats", str(stats)]
    assert main([*arguments, "--max-error", "0.12", "--truth", "gi"]) == 0
    line = capsys.readouterr().out.splitlines()[0]
    assert line.startswith("chose gi march") and "of the mean of all light" in line
    assert settings_of(stats)["method"] == "gi"


def test_a_reference_of_the_bound_needs_a_bound(capsys):
    assert "--truth belongs" in refused(capsys, ["corner", "--truth", "gi", "--snapshot", "x.png"])
    assert "use --truth gi" in refused(
        capsys,
        ["corner", "--method", "gi", "--truth", "near", "--max-error", "1", "--snapshot", "x.png"],
    )
