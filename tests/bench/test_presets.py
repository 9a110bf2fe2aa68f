"""Presets come out of the measured front; files and names are checked."""

from __future__ import annotations

import dataclasses

import pytest

from ssdo_gl.bench import presets
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
    assert load_preset("reference")["method"] == "reference-gi"


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
    with pytest.raises(SettingError, match="did you mean 'balanced'"):
        load_preset("balancd")
    with pytest.raises(SettingError, match=r"missing\.toml"):
        load_preset("missing.toml")
