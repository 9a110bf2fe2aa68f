"""Cost series: what is timed, how parts are summed, what quick leaves out."""

from __future__ import annotations

import math

import pytest
from bench.fake_renderer import FakeRenderer

from ssdo_gl.bench import scaling
from ssdo_gl.settings import Settings

BASE = Settings(size=(64, 48), radius=0.3, exposure=0.0)


def test_passes_are_summed_by_part():
    parts = scaling.parts_of(
        [("gbuffer", 1.0), ("ssao", 2.0), ("bounce", 4.0), ("bounce_filter", 0.5), ("new", 0.25)]
    )
    assert parts == {
        "G-buffer": 1.0,
        "estimators": 6.0,
        "filters": 0.5,
        "rest": 0.25,
        "whole frame": 7.75,
    }


def test_quick_keeps_both_ends():
    series = scaling.measure_scaling(FakeRenderer(), BASE, 20.0, True, "wall")
    counts = scaling.SAMPLE_COUNTS
    assert series[0].x == (counts[0], counts[2], counts[-1])


def test_each_series_varies_one_quantity():
    renderer = FakeRenderer()
    series = {
        item.name: item for item in scaling.measure_scaling(renderer, BASE, 20.0, False, "wall")
    }
    assert set(series) == {"samples", "pixels", "radius", "triangles"}
    assert series["samples"].x == tuple(float(n) for n in scaling.SAMPLE_COUNTS)
    assert series["pixels"].x[2] == 64 * 48
    assert series["radius"].x == tuple(20.0 * f for f in scaling.RADIUS_FACTORS)
    settings = [used for _, used in renderer.calls]
    sampled = settings[: len(scaling.SAMPLE_COUNTS)]
    assert {s.size for s in sampled} == {BASE.size}
    assert {s.radius for s in sampled} == {0.3}
    grown = settings[-len(scaling.RADIUS_FACTORS) :]
    assert [s.radius for s in grown] == pytest.approx([0.3 * f for f in scaling.RADIUS_FACTORS])
    assert {s.samples for s in grown} == {scaling.TIMED_POINT.samples}
    whole = series["samples"].curves["whole frame"]
    assert whole == pytest.approx([renderer.cost_ms(s) + 0.1 for s in sampled])


def test_triangles_are_counted_as_they_are():
    renderer = FakeRenderer()
    series = scaling.measure_scaling(renderer, BASE, 20.0, True, "wall")[-1]
    counts = [scene.triangle_count for scene in renderer.others]
    assert series.name == "triangles"
    assert series.x == tuple(float(n) for n in counts)
    assert len(counts) == scaling.QUICK_COUNT
    assert counts[-1] == pytest.approx(400_000, rel=0.05)
    # The fake renderer has no pass called reference.
    assert all(math.isnan(v) for v in series.curves["4 rays a pixel"])


def test_every_field_shows_the_same_picture():
    scenes = [scaling.sphere_field(count) for count in scaling.TRIANGLE_COUNTS]
    assert len({scene.camera for scene in scenes}) == 1
    assert all(scene.meshes[0].closed for scene in scenes)
    first, last = (scene.bounds() for scene in (scenes[1], scenes[-1]))
    assert last[0] == pytest.approx(first[0], abs=0.02)
    assert last[1] == pytest.approx(first[1], abs=0.02)
