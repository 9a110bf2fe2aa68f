"""Choosing settings: the right rung, few measurements, honest refusals."""

from __future__ import annotations

import math

import pytest
from bench.fake_renderer import FakeRenderer, triangle_scene

from ssdo_gl.bench.presets import Ladder, PresetRung
from ssdo_gl.bench.tuning import tune
from ssdo_gl.settings import Settings

RUNGS = tuple(
    PresetRung("march", samples, 8, 1.0, "none", 0.1 * samples, 1.0 / samples)
    for samples in (8, 16, 32, 64, 128, 256, 512, 1024)
)
LADDER = Ladder(RUNGS, {"fast": 0, "balanced": 3, "fine": 7}, {})
SETTINGS = Settings(size=(100, 100), radius=0.3, exposure=0.0)


@pytest.fixture(autouse=True)
def quiet_machine(monkeypatch):
    monkeypatch.setattr(tune, "load_average", lambda: 0.1)


def choose(budget: float, renderer: FakeRenderer | None = None) -> tune.Choice:
    return tune.within_budget(renderer or FakeRenderer(), SETTINGS, budget, LADDER)


@pytest.mark.parametrize("budget", [2.0, 3.0, 9.0, 14.5, 50.0, 1e4])
def test_the_last_rung_that_fits_is_chosen(budget):
    renderer = FakeRenderer()
    choice = choose(budget, renderer)
    costs = [renderer.cost_ms(rung.applied(SETTINGS)) for rung in RUNGS]
    fitting = [i for i, cost in enumerate(costs) if cost <= budget * tune.FILL]
    assert choice.holds
    assert choice.settings.samples == RUNGS[fitting[-1]].samples
    assert choice.frame_ms == pytest.approx(costs[fitting[-1]])
    assert f"{budget:g} ms" in choice.sentence
    assert "\n" not in choice.sentence


def test_an_impossible_budget_is_called_impossible():
    choice = choose(0.5)
    assert not choice.holds
    assert choice.settings.samples == RUNGS[0].samples
    assert "no measured setting fits 0.5 ms, with 5 % to spare, at " in choice.sentence


@pytest.mark.parametrize("speed", [0.25, 1.0, 4.0])
def test_the_first_time_says_where_to_look(speed):
    for budget in (2.0, 9.0, 14.5, 50.0):
        renderer = FakeRenderer(speed=speed)
        choose(budget * speed, renderer)
        assert renderer.count("timed") <= 3, "one in the middle, the last that fits, the next"


def test_times_taken_on_a_busy_machine_are_called_that(monkeypatch):
    assert "busy" not in choose(9.0).sentence
    monkeypatch.setattr(tune, "load_average", lambda: 1e3)
    assert "busy (load 1000.0), so times are too long" in choose(9.0).sentence


class OddOrder(FakeRenderer):
    """A scene in which the last rung is the cheapest."""

    def cost_ms(self, settings: Settings) -> float:
        return 1.5 if settings.samples == RUNGS[-1].samples else 50.0 + settings.samples


@pytest.mark.parametrize("budget", [1.0, 9.0, 54.5, 70.0, 1e4])
def test_what_does_not_fit_is_not_chosen_in_whatever_order_times_grow(budget):
    renderer = OddOrder()
    choice = choose(budget, renderer)
    assert choice.holds == (renderer.cost_ms(choice.settings) <= budget * tune.FILL)
    assert renderer.count("timed") <= len(RUNGS)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_bad_requests_are_refused_before_a_device_is_opened(value):
    with pytest.raises(tune.CannotTuneError, match="--budget-ms"):
        tune.choose_for_budget(triangle_scene(), SETTINGS, value, backend="nonsense")


def test_methods_that_the_ladder_does_not_concern_are_refused():
    for method in ("direct", "reference-gi"):
        with pytest.raises(tune.CannotTuneError, match=method):
            tune.choose_for_budget(triangle_scene(), Settings(method=method), 10.0)
