"""Choosing settings: the right rung, few measurements, memory, honest refusals."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest
from bench.fake_renderer import FakeRenderer, triangle_scene

from ssdo_gl.bench.presets import Ladder, PresetRung
from ssdo_gl.bench.tuning import calibration, tune
from ssdo_gl.bench.tuning.calibration import Calibration
from ssdo_gl.settings import Settings

RUNGS = tuple(
    PresetRung("march", samples, 8, 1.0, "none", 0.1 * samples, 1.0 / samples)
    for samples in (8, 16, 32, 64, 128, 256, 512, 1024)
)
LADDER = Ladder(RUNGS, {"fast": 0, "balanced": 3, "fine": 7}, {})
SETTINGS = Settings(size=(100, 100), radius=0.3, exposure=0.0)


@pytest.fixture(autouse=True)
def quiet_machine(monkeypatch):
    monkeypatch.setattr(calibration, "load_average", lambda: 0.1)


def choose(
    tmp_path, budget: float, renderer: FakeRenderer | None = None, recalibrate: bool = False
) -> tune.Choice:
    tmp_path.mkdir(exist_ok=True)
    return tune.within_budget(
        renderer or FakeRenderer(),
        SETTINGS,
        budget,
        LADDER,
        Calibration(tmp_path),
        "key",
        recalibrate,
    )


def remembered(tmp_path) -> dict[str, object]:
    content: dict[str, object] = json.loads((tmp_path / "key.json").read_text())
    return content


@pytest.mark.parametrize("budget", [2.0, 3.0, 9.0, 14.5, 50.0, 1e4])
def test_the_last_rung_that_fits_is_chosen(tmp_path, budget):
    renderer = FakeRenderer()
    choice = choose(tmp_path, budget, renderer)
    costs = [renderer.cost_ms(rung.applied(SETTINGS)) for rung in RUNGS]
    fitting = [i for i, cost in enumerate(costs) if cost <= budget * tune.FILL]
    assert choice.holds
    assert choice.settings.samples == RUNGS[fitting[-1]].samples
    assert choice.frame_ms == pytest.approx(costs[fitting[-1]])
    assert f"{budget:g} ms" in choice.sentence
    assert "\n" not in choice.sentence


def test_an_impossible_budget_is_called_impossible(tmp_path):
    choice = choose(tmp_path, 0.5)
    assert not choice.holds
    assert choice.settings.samples == RUNGS[0].samples
    assert "no measured setting fits 0.5 ms, with 5 % to spare, at " in choice.sentence


def test_few_rungs_are_measured_and_fewer_the_second_time(tmp_path):
    first, second = FakeRenderer(), FakeRenderer()
    one = choose(tmp_path, 9.0, first)
    two = choose(tmp_path, 9.0, second)
    assert first.count("timed") <= 4, "bisection of eight rungs"
    assert second.count("timed") == 2, "the remembered rung and the one above it"
    assert one.settings == two.settings


def test_memory_of_a_faster_machine_does_not_break_the_budget(tmp_path):
    choose(tmp_path, 9.0, FakeRenderer())
    slow = FakeRenderer(speed=4.0)
    choice = choose(tmp_path, 9.0, slow)
    assert slow.cost_ms(choice.settings) <= 9.0


def test_memory_of_a_slower_machine_does_not_waste_the_budget(tmp_path):
    choose(tmp_path, 9.0, FakeRenderer(speed=4.0))
    fast = FakeRenderer()
    assert choose(tmp_path, 9.0, fast).settings == choose(tmp_path / "x", 9.0, fast).settings


@pytest.mark.parametrize(
    "text",
    [
        "[1,", "[]", "{}", '{"values": 3}', '{"values": {}, "date": "x", "load": 1}',
        '{"values": {"march 8x8 full none": "x"}, "date": "x", "load": 1}',
        '{"values": {"march 8x8 full none": NaN}, "date": "x", "load": 1}',
        '{"values": {"march 8x8 full none": 0}, "date": "x", "load": 1}',
        '{"values": {"march 8x8 full none": 1}, "date": 2, "load": 1}',
        '{"values": {"march 8x8 full none": 1}, "date": "x", "load": "y"}',
    ],
)  # fmt: skip
def test_a_damaged_memory_counts_as_none(tmp_path, text):
    choose(tmp_path, 9.0)
    (tmp_path / "key.json").write_text(text)
    choice = choose(tmp_path, 9.0)
    assert choice.holds
    assert "beginning with" not in choice.sentence


def test_it_is_remembered_when_and_at_what_load(tmp_path, monkeypatch):
    monkeypatch.setattr(calibration, "load_average", lambda: 0.3)
    choose(tmp_path, 9.0)
    kept = remembered(tmp_path)
    assert kept["load"] == 0.3
    assert f"beginning with times of {kept['date']} at load 0.3" in choose(tmp_path, 9.0).sentence


def test_times_of_another_load_are_forgotten(tmp_path):
    for budget in (2.0, 9.0, 1e4):
        choose(tmp_path, budget, FakeRenderer(speed=4.0))
    slow = remembered(tmp_path)["values"]
    choice = choose(tmp_path, 9.0)
    assert "off by a factor of 0.25" in choice.sentence
    now, true = remembered(tmp_path)["values"], FakeRenderer()
    assert len(now) < len(slow)
    for rung in RUNGS:
        if rung.label in now:
            assert now[rung.label] == pytest.approx(true.cost_ms(rung.applied(SETTINGS)))


def test_recalibration_forgets_everything(tmp_path):
    choose(tmp_path, 1e4)
    choice = choose(tmp_path, 2.0, recalibrate=True)
    assert "beginning with" not in choice.sentence
    assert RUNGS[-1].label not in remembered(tmp_path)["values"]


def test_times_taken_on_a_busy_machine_are_called_that(tmp_path, monkeypatch):
    assert "busy" not in choose(tmp_path, 9.0).sentence
    monkeypatch.setattr(calibration, "load_average", lambda: 1e3)
    assert "--recalibrate when it is not" in choose(tmp_path, 9.0).sentence


class OddOrder(FakeRenderer):
    """A scene in which the last rung is the cheapest."""

    def cost_ms(self, settings: Settings) -> float:
        return 1.5 if settings.samples == RUNGS[-1].samples else 50.0 + settings.samples


def test_the_cheapest_is_the_cheapest_of_all_that_is_known(tmp_path):
    choose(tmp_path, 1e4, OddOrder())
    refused = choose(tmp_path, 1.0, OddOrder())
    assert not refused.holds
    assert f"the cheapest, {RUNGS[-1].label}, takes 1.5 ms" in refused.sentence
    chosen = choose(tmp_path, 9.0, OddOrder())
    assert chosen.holds
    assert chosen.settings.samples == RUNGS[-1].samples


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_bad_requests_are_refused_before_a_device_is_opened(value):
    with pytest.raises(tune.CannotTuneError, match="--budget-ms"):
        tune.choose_for_budget(triangle_scene(), SETTINGS, value, backend="nonsense")


def test_methods_that_the_ladder_does_not_concern_are_refused():
    for method in ("direct", "reference-gi"):
        with pytest.raises(tune.CannotTuneError, match=method):
            tune.choose_for_budget(triangle_scene(), Settings(method=method), 10.0)


def test_scene_classes_tell_apart_what_costs_differently():
    scene = triangle_scene()
    same = calibration.scene_class(scene, SETTINGS)
    assert calibration.scene_class(scene, dataclasses.replace(SETTINGS, seed=3)) == same
    for change in ({"size": (200, 100)}, {"method": "ssao"}, {"shadows": "none"}, {"radius": 3.0}):
        assert calibration.scene_class(scene, dataclasses.replace(SETTINGS, **change)) != same
    assert calibration.scene_class(dataclasses.replace(scene, title="x"), SETTINGS) == same
