"""Scenes in other units; families at equal time and error; the first report's table."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest
from bench.fake_renderer import SCREEN_LOSS, FakeRenderer, reference_image, triangle_scene

from benchmarks import report_table, world_scale
from benchmarks.equal import Curve, agreement, compare, curve_of
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

BASE = Settings(size=(64, 48), radius=0.3, exposure=0.0)


@pytest.mark.parametrize("name", ["cornell_meso", "coloured_lights"])
def test_scaling_back_gives_the_scene_again(name):
    scene = load_scene(name)
    back = world_scale.scaled_scene(world_scale.scaled_scene(scene, 64.0), 1.0 / 64.0)
    for one, other in zip(scene.objects, back.objects, strict=True):
        np.testing.assert_array_equal(one.world_from_object, other.world_from_object)
    assert back.camera == scene.camera
    assert [type(light) for light in back.lights] == [type(light) for light in scene.lights]
    low, high = scene.bounds()
    big = world_scale.scaled_scene(scene, 64.0)
    np.testing.assert_allclose(big.bounds(), (64.0 * low, 64.0 * high))
    assert big.default_radius() == pytest.approx(64.0 * scene.default_radius())


def test_curves_hold_levels_and_errors_for_every_scale():
    target = reference_image(BASE.size, "bounce")
    reference = Reference({"bounce": target}, {"bounce": np.zeros_like(target)}, 2, 8, 0.0)
    mask = target[:, :, 0] > 0.0
    radii = []

    @contextlib.contextmanager
    def open_renderer(scene):
        renderer = FakeRenderer()
        yield renderer
        radii.extend(settings.radius for _, settings in renderer.calls)

    curves = world_scale.measure_world_scale(
        triangle_scene(), BASE, reference, mask, open_renderer, factors=(0.1, 10.0)
    )
    assert len(curves) == 3
    march = curves[-1]
    level = float(target[mask].mean())
    assert march.levels == pytest.approx([1 + SCREEN_LOSS / level] * 2, rel=0.02)
    assert min(march.errors) > SCREEN_LOSS / level * 0.98
    assert radii == pytest.approx([0.03] * 3 + [3.0] * 3)
    clamps = [
        dict(world_scale.estimators(radius)[curves[0].name].overrides) for radius in (0.03, 3.0)
    ]
    assert [c["bounce.distance_clamp"] * r for c, r in zip(clamps, (0.03, 3.0), strict=True)] == (
        pytest.approx([1.0, 1.0])
    ), "the paper clamps at one world unit whatever R is"


def test_families_are_compared_along_their_own_fronts():
    slow = Curve("paper", (10.0, 20.0), (0.2, 0.1), ("a", "b"))
    fast = Curve("march", (4.0, 9.0, 40.0), (0.3, 0.05, 0.01), ("c", "d", "e"))
    assert (fast.error_at(9.0), fast.error_at(8.9)) == (0.05, 0.3)
    assert (fast.time_at(0.05), fast.time_at(0.049)) == (9.0, 40.0)
    found = compare(slow, fast)
    assert found.equal_time == (("a", 10.0, 0.2, 0.05), ("b", 20.0, 0.1, 0.05))
    assert found.equal_error == (("a", 10.0, 0.2, 9.0), ("b", 20.0, 0.1, 9.0))
    assert found.error_ratio == pytest.approx(math.sqrt(0.25 * 0.5))
    assert found.time_ratio == pytest.approx(math.sqrt(0.9 * 0.45))


def test_what_cannot_be_compared_is_said_to_be_so():
    found = compare(Curve("a", (1.0,), (0.01,), ("x",)), Curve("b", (2.0,), (0.5,), ("y",)))
    assert found.equal_time[0][3] == math.inf
    assert found.equal_error[0][3] == math.inf
    assert math.isnan(found.error_ratio)
    assert math.isnan(found.time_ratio)


def test_a_curve_is_the_front_of_its_families():
    def row(family: str, ms: float, error: str) -> dict[str, str]:
        return {
            "family": family, "ms": str(ms), "near_error": error, "label": f"{family}{ms}",
        }  # fmt: skip

    rows = [row("f", 2, "0.2"), row("f", 1, "0.3"), row("f", 3, "0.25"), row("g", 1, "0.1"),
            row("f", 4, "")]  # fmt: skip
    assert curve_of(rows, "n", ("f",)).times == (1.0, 2.0)
    assert curve_of(rows, "n", ("f", "g")).times == (1.0,)


def test_the_report_normalised_what_it_should_not():
    # 5820 ms at 1024 samples, 39 ms of them fixed; printed was 5820 * 16 / 1024 = 91.
    assert report_table.report_normalised(5820, 0, 1024) == pytest.approx(91, abs=0.5)
    assert report_table.report_normalised(5820, 39, 1024) == pytest.approx(129.3, abs=0.1)


def test_fixed_and_growing_cost_are_told_apart():
    methods = [m for m in report_table.ROWS if not m.settings["method"].startswith("ref")]
    rows = {row.method.name: row for row in report_table.measure(FakeRenderer(), BASE, methods)}
    paper = rows["SSDO and bounce, paper's, 1024 reads"]
    pixels = 64 * 48 / 1e4
    assert paper.fixed_ms == pytest.approx(pixels)
    assert paper.per_sample_ms == pytest.approx(0.1 * pixels)
    assert paper.normal_ms == pytest.approx(pixels * 2.6)
    assert math.isnan(rows["visible surfaces (z-buffer)"].fixed_ms)


def test_every_row_of_the_report_is_a_valid_setting():
    for method in report_table.ROWS:
        settings = {"estimator": None, **method.settings}
        if method.count_field:
            settings[method.count_field] = method.count
        Settings(**settings).checked()


def test_runs_contradict_each_other_only_where_both_are_sure():
    first = np.array([1.0, 1.0, 0.0, 0.5, 0.95])
    second = np.array([0.0, 0.6, 1.0, 1.0, 0.99])
    assert agreement(first, second, 0.9) == [0, 2]
