"""Choosing by error: the cheapest that does, against the right reference, or an honest no."""

from __future__ import annotations

import math

import pytest
from bench.fake_renderer import MODEL_LOSS, FakeRenderer, triangle_scene

from ssdo_gl.bench.measure.panels import panel_named
from ssdo_gl.bench.measure.reference_cache import ReferenceCache
from ssdo_gl.bench.presets import PresetRung
from ssdo_gl.bench.tuning import error_bound
from ssdo_gl.bench.tuning.error_bound import MethodRung, candidates, measured_errors, within_error
from ssdo_gl.bench.tuning.tune import CannotTuneError, Choice
from ssdo_gl.settings import Settings

RUNGS = tuple(
    PresetRung("march", samples, 8, 1.0, "none", 0.1 * samples, 1.0 / samples)
    for samples in (8, 16, 32, 64, 128, 256, 512, 1024)
)
SETTINGS = Settings(size=(100, 100), radius=0.3, exposure=0.0)
NEAR, GI = panel_named("near"), panel_named("gi")
BOUNCE = candidates(("bounce",), RUNGS)
BOTH = candidates(("bounce", "gi"), RUNGS)


def errors_of(tmp_path, panel, chosen) -> dict[str, float]:
    return measured_errors(FakeRenderer(), SETTINGS, panel, chosen, ReferenceCache(tmp_path))


def never(candidate: MethodRung) -> float:
    raise AssertionError("nothing to be timed")


def choice(bound, errors, chosen, panel=GI, *, allow_rays=True, cost_ms=never) -> Choice:
    return within_error(SETTINGS, bound, panel, chosen, errors, "how", allow_rays, cost_ms)


def test_errors_are_upper_ends_of_what_is_measured(tmp_path):
    found = errors_of(tmp_path, NEAR, BOUNCE)
    values = [found[rung.label] for rung in RUNGS]
    # The fake error is a screen loss of 0.06 plus noise, on a mean of about 0.5.
    assert values == sorted(values, reverse=True)
    assert 0.06 / 0.5 <= values[-1] <= 0.06 / 0.5 * 1.15


def test_errors_are_those_of_the_reference_that_was_asked_for(tmp_path):
    last = RUNGS[-1].label
    found = errors_of(tmp_path, GI, BOUNCE)[last]
    # Of all light the fake near field lacks more than the screen does.
    assert found == pytest.approx((MODEL_LOSS - 0.06) / 0.7, rel=0.1)


def test_the_cheapest_rung_within_the_error_is_chosen(tmp_path):
    found = errors_of(tmp_path, NEAR, BOUNCE)
    allowed = 1.01 * found[RUNGS[3].label]
    chosen = choice(allowed, found, BOUNCE, NEAR)
    assert chosen.holds
    assert chosen.settings.samples == RUNGS[3].samples
    assert chosen.error <= allowed


def test_where_no_screen_space_setting_suffices_rays_do():
    found = {item.label: 0.1 for item in BOUNCE}
    for panel, method in ((NEAR, "reference-near"), (GI, "reference-gi")):
        traced = choice(0.01, found, BOUNCE, panel)
        assert traced.holds
        assert traced.settings.method == method
        assert traced.settings.max_error == 0.01
    refused = choice(0.01, found, BOUNCE, allow_rays=False)
    assert not refused.holds
    assert refused.settings.method == "bounce"
    assert "no measured setting is within 1 % of the mean of all light" in refused.sentence


def test_of_methods_that_do_the_one_that_takes_less_time_is_chosen():
    """The first rung of gi suffices; of bounce a later one; which is cheaper is measured."""
    found = {item.label: 0.04 if item.method == "gi" else 0.2 for item in BOTH}
    found |= {item.label: 0.05 for item in BOTH if item.rung.samples >= 512}
    asked = []

    def cost_ms(candidate: MethodRung) -> float:
        asked.append((candidate.method, candidate.rung.samples))
        return 1.0 if candidate.method == cheap else 2.0

    for cheap, samples in (("gi", 8), ("bounce", 512)):
        chosen = choice(0.06, found, BOTH, cost_ms=cost_ms)
        assert (chosen.settings.method, chosen.settings.samples) == (cheap, samples)
        assert f"chose {cheap} march" in chosen.sentence
    assert set(asked) == {("gi", 8), ("bounce", 512)}
    alone = choice(0.045, found, BOTH)
    assert alone.settings.method == "gi", "bounce does not reach it, so nothing is timed"


def test_what_is_compared_follows_from_method_and_reference():
    assert error_bound.panel_for(Settings(), None).name == "gi"
    assert error_bound.panel_for(Settings(), "near").name == "near"
    assert error_bound.panel_for(Settings(method="bounce"), None).name == "near"
    assert error_bound.panel_for(Settings(method="gi"), None).name == "gi"
    assert error_bound.panel_for(Settings(), "gi").name == "gi"
    with pytest.raises(CannotTuneError, match="--truth gi"):
        error_bound.panel_for(Settings(method="gi"), "near")
    assert error_bound.methods_for(Settings(), GI) == ("ssdo", "bounce", "gi")
    assert error_bound.methods_for(Settings(method="bounce"), GI) == ("bounce",)
    assert error_bound.methods_for(Settings(), NEAR) == ("bounce",)


def test_the_calibration_frame_is_small_and_keeps_its_shape():
    assert error_bound._smaller((1920, 1080)) == (320, 180)
    assert error_bound._smaller((64, 36)) == (64, 36)
    width, height = error_bound._smaller((1000, 5000))
    assert height == pytest.approx(5 * width, abs=3)
    assert width * height <= error_bound.CALIBRATION_PIXELS * 1.02


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_bad_requests_are_refused_before_a_device_is_opened(value):
    with pytest.raises(CannotTuneError, match="--max-error"):
        error_bound.choose_for_error(triangle_scene(), SETTINGS, value, backend="nonsense")
