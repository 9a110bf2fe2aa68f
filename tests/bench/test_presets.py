"""Presets come out of the measured front; files and names are checked."""

from __future__ import annotations

import dataclasses

import pytest
from bench.fake_bench import results

from ssdo_gl.bench import presets
from ssdo_gl.bench.analysis import as_row
from ssdo_gl.bench.presets import load_preset, read_ladder
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError


def test_the_shipped_ladder_is_a_front_and_can_be_rendered():
    ladder = read_ladder()
    times = [rung.relative_time for rung in ladder.rungs]
    errors = [rung.error for rung in ladder.rungs]
    assert len(times) >= 4
    assert times == sorted(times)
    assert errors == sorted(errors, reverse=True)
    assert len({rung.label for rung in ladder.rungs}) == len(times)
    for rung in ladder.rungs:
        for method in ("ssao", "ssdo", "bounce", "direct"):
            rung.applied(Settings(method=method))
    assert set(ladder.presets) == {"fast", "balanced", "fine"}
    order = [ladder.presets[name] for name in ("fast", "balanced", "fine")]
    assert order == sorted(set(order)), "three different presets, from fast to fine"
    assert order[-1] == len(times) - 1


def test_the_shipped_ladder_was_measured_on_the_scenes_it_names():
    assert read_ladder().source["benches"]


@pytest.mark.parametrize("name", presets.NAMES)
def test_every_preset_gives_valid_settings(name):
    fields = load_preset(name)
    dataclasses.replace(Settings(), **fields).checked()


def test_a_preset_leaves_out_an_estimator_that_the_method_lacks():
    assert load_preset("fast")["estimator"] == "march"
    assert "estimator" not in load_preset("fast", "direct")
    assert "method" not in load_preset("reference", "reference-gi")
    assert load_preset("reference")["method"] == "reference-near"


def test_a_preset_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[settings]\nmethod = "ssao"\nsamples = 12\nresolution-scale = 0.5\n'
                    "size = [64, 36]\n")  # fmt: skip
    assert load_preset(str(path)) == {
        "method": "ssao",
        "samples": 12,
        "resolution_scale": 0.5,
        "size": (64, 36),
    }
    path.write_text("steps = 4\nexposure = 1\noverrides = { 'bounce.bias' = 0.1 }\n")
    assert load_preset(str(path)) == {
        "steps": 4, "exposure": 1, "overrides": {"bounce.bias": 0.1},
    }  # fmt: skip


def test_an_unknown_preset_is_named():
    with pytest.raises(SettingError, match="did you mean balanced"):
        load_preset("balancd")
    with pytest.raises(SettingError, match=r"missing\.toml"):
        load_preset("missing.toml")


def row(samples: int, ms: float, error: float, **changes: str) -> dict[str, str]:
    key = f"radiance-bounce-march-n{samples}"
    return {
        "key": key, "method": "bounce", "estimator": "march", "samples": str(samples),
        "steps": "8", "resolution_scale": "0.5", "filter": "edge", "radius_factor": "1.0",
        "ms": str(ms), "near_error": str(error),
    } | changes  # fmt: skip


def baseline(ms: float) -> dict[str, str]:
    return row(8, ms, 0.5) | {"key": presets.BASELINE, "estimator": "rgs09", "filter": "naive"}


def test_the_ladder_is_the_front_of_the_means_over_scenes():
    first = [baseline(10), row(16, 5, 0.10), row(32, 10, 0.06), row(64, 40, 0.05)]
    second = [baseline(40), row(16, 20, 0.20), row(32, 40, 0.10), row(64, 40, 0.07)]
    rungs, names = presets.derive([first, second])
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
    rungs, _ = presets.derive([rows, [baseline(10), row(16, 5, 0.1), row(128, 4, 0.01)]])
    assert [rung.samples for rung in rungs] == [16]


def test_rungs_that_the_clock_cannot_tell_apart_are_one():
    rows = [baseline(10), row(16, 5, 0.10), row(17, 5.2, 0.08), row(32, 10, 0.0799)]
    rungs, _ = presets.derive([rows])
    assert [rung.samples for rung in rungs] == [17], "32 gains nothing, 17 replaces 16"


def test_many_small_steps_are_not_one():
    # Each is 6 % slower than the one before; all together 1.06^6 = 1.42.
    rows = [baseline(10), *(row(16 + i, 5 * 1.06**i, 0.1 * 0.8**i) for i in range(7))]
    rungs, _ = presets.derive([rows])
    times = [rung.relative_time for rung in rungs]
    assert 3 <= len(times) <= 5
    assert times[0] < 0.5 * presets.MIN_TIME_RATIO


def test_a_bench_without_the_baseline_is_refused():
    with pytest.raises(ValueError, match="baseline"):
        presets.derive([[row(16, 5, 0.1)]])
    with pytest.raises(ValueError, match="no setting"):
        presets.derive([[baseline(1)], [baseline(1) | {"near_error": ""}]])


def test_the_written_ladder_is_read_back():
    table = [{k: str(v) for k, v in as_row(r).items()} for r in results(quick=False)]
    rungs, names = presets.derive([table])
    ladder = read_ladder(presets.ladder_text(rungs, names, {"benches": ["a"], "date": "x"}))
    assert ladder.rungs == tuple(rungs)
    assert ladder.presets == names
    assert ladder.source == {"benches": ["a"], "date": "x"}
