"""The ladder of presets is the front of what all benches measured."""

from __future__ import annotations

from pathlib import Path

import pytest
from bench.fake_bench import results

from benchmarks import preset_ladder
from ssdo_gl.bench.analysis import as_row
from ssdo_gl.bench.presets import read_ladder
from ssdo_gl.scene.load import load_scene

ROOT = Path(__file__).parents[2]


def row(samples: int, ms: float, error: float, **changes: str) -> dict[str, str]:
    key = f"radiance-bounce-march-n{samples}"
    return {
        "key": key, "method": "bounce", "estimator": "march", "samples": str(samples),
        "steps": "8", "resolution_scale": "0.5", "filter": "edge", "radius_factor": "1.0",
        "ms": str(ms), "near_error": str(error),
    } | changes  # fmt: skip


def baseline(ms: float) -> dict[str, str]:
    return row(8, ms, 0.5) | {
        "key": preset_ladder.BASELINE,
        "estimator": "rgs09",
        "filter": "naive",
    }


def test_the_ladder_is_the_front_of_the_means_over_scenes():
    first = [baseline(10), row(16, 5, 0.10), row(32, 10, 0.06), row(64, 40, 0.05)]
    second = [baseline(40), row(16, 20, 0.20), row(32, 40, 0.10), row(64, 40, 0.07)]
    rungs, names = preset_ladder.derive([first, second])
    assert [rung.samples for rung in rungs] == [16, 32, 64]
    # Relative times 0.5, 1 and sqrt(4 * 1) = 2; mean errors.
    assert [rung.relative_time for rung in rungs] == [0.5, 1.0, 2.0]
    assert [rung.error for rung in rungs] == [0.15, 0.08, 0.06]
    assert names == {"fast": 0, "balanced": 1, "fine": 2}


def test_what_one_bench_lacks_other_radii_and_the_unfiltered_are_left_out():
    rows = [
        baseline(10),
        row(16, 5, 0.1),
        row(32, 9, 0.01, filter="none"),
        row(48, 9, 0.01, radius_factor="2.0"),
        row(64, 9, 0.01, method="ssdo"),
        row(96, 9, 0.01, near_error=""),
    ]
    rungs, _ = preset_ladder.derive([rows, [baseline(10), row(16, 5, 0.1), row(128, 4, 0.01)]])
    assert [rung.samples for rung in rungs] == [16]


def test_rungs_that_the_clock_cannot_tell_apart_are_one():
    rows = [baseline(10), row(16, 5, 0.10), row(17, 5.2, 0.08), row(32, 10, 0.0799)]
    rungs, _ = preset_ladder.derive([rows])
    assert [rung.samples for rung in rungs] == [17], "32 gains nothing, 17 replaces 16"


def test_many_small_steps_are_not_one():
    # Each is 6 % slower than the one before; all together 1.06^6 = 1.42.
    rows = [baseline(10), *(row(16 + i, 5 * 1.06**i, 0.1 * 0.8**i) for i in range(7))]
    rungs, _ = preset_ladder.derive([rows])
    times = [rung.relative_time for rung in rungs]
    assert 3 <= len(times) <= 5
    assert times[0] < 0.5 * preset_ladder.MIN_TIME_RATIO


def test_a_bench_without_the_baseline_is_refused():
    with pytest.raises(ValueError, match="baseline"):
        preset_ladder.derive([[row(16, 5, 0.1)]])
    with pytest.raises(ValueError, match="no setting"):
        preset_ladder.derive([[baseline(1)], [baseline(1) | {"near_error": ""}]])


def test_the_written_ladder_is_read_back():
    table = [{k: str(v) for k, v in as_row(r).items()} for r in results(quick=False)]
    rungs, names = preset_ladder.derive([table])
    ladder = read_ladder(preset_ladder.ladder_text(rungs, names, {"benches": ["a"], "date": "x"}))
    assert ladder.rungs == tuple(rungs)
    assert ladder.presets == names
    assert ladder.source == {"benches": ["a"], "date": "x"}


def test_one_of_the_benched_scenes_is_glossy():
    lines = (ROOT / "Makefile").read_text(encoding="utf-8").splitlines()
    (names,) = [line.split("?=")[1].split() for line in lines if line.startswith("BENCH_SCENES")]
    (metals,) = [name for name in names if name.endswith(".toml")]
    scene = load_scene(str(ROOT / metals))
    assert all(material.is_glossy for material in scene.materials if not material.emits)
