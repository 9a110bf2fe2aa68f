"""A whole bench without OpenGL: what it finds is what was fake; it can be resumed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from bench.fake_bench import MACHINE
from bench.fake_renderer import (
    MODEL_LOSS,
    POINT_LOSS,
    READ_NOISE,
    SCREEN_LOSS,
    FakeRenderer,
    Interrupted,
    reference_image,
)

from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import errors
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.run import BenchPlan, BenchRun
from ssdo_gl.progress import StageProgress
from ssdo_gl.settings import Settings

pytest.importorskip("matplotlib")
pytest.importorskip("flip_evaluator")

BASE = Settings(size=(64, 48), radius=0.3, exposure=0.0)
PLAN = BenchPlan(rounds=2, frames=2, seeds=3, reference_seconds=60.0, batch_spp=512, flips=())
POINTS = [
    Point("radiance", "march", "bounce", "march", 16, 8, 1.0, "none", quick=True),
    Point("radiance", "march", "bounce", "march", 256, 8, 1.0, "none", quick=True),
    Point("radiance", "paper", "bounce", "rgs09", 256, 1, 1.0, "none"),
    Point("radiance", "radii", "bounce", "march", 64, 8, 1.0, "none", radius_factor=2.0),
    Point("visibility", "march", "ssao", "march", 64, 8, 1.0, "none"),
]


def run(tmp_path, renderer: FakeRenderer, monkeypatch, plan: BenchPlan = PLAN) -> Bench:
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "cache"))
    outdir = tmp_path / "out"
    outdir.mkdir(exist_ok=True)
    progress = StageProgress(None, None)
    bench_run = BenchRun(renderer, BASE, POINTS, plan, False, outdir, progress)
    return bench_run.measure("fake", MACHINE)


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Bench:
    """A finished bench that the tests only read."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        plan = dataclasses.replace(PLAN, flips=("ldr", "hdr"))
        return run(tmp_path_factory.mktemp("found"), FakeRenderer(), monkeypatch, plan)


def level(name: str = "beauty") -> float:
    """Return the mean reference over the pixels that count."""
    height = BASE.size[1]
    image = reference_image(BASE.size, name)[height // 8 :, 1:]
    return float(image[:, :, :3].mean())


def test_errors_are_what_was_fake(found):
    coarse, fine, paper, other, visibility = found.results
    # 2500 pixels of 3 channels and 3 seeds know a mean square to 1 %; the reference's
    # standard error, a tenth of the loss or less, is subtracted.
    near = fine.verdicts["near"]
    expected = np.hypot(SCREEN_LOSS, READ_NOISE / 16) / level()
    assert near.error.value == pytest.approx(expected, rel=0.05)
    assert near.error.low < expected < near.error.high * 1.02
    assert near.scalars.systematic == pytest.approx(SCREEN_LOSS / level(), rel=0.05)
    assert near.scalars.noise == pytest.approx(READ_NOISE / 16 / level(), rel=0.05)
    assert near.scalars.own_bias == pytest.approx(0.0, abs=0.01), "no step but noise differs"
    assert near.bias.value == pytest.approx(SCREEN_LOSS / level(), rel=0.05)
    assert coarse.verdicts["near"].scalars.noise == pytest.approx(4 * near.scalars.noise, rel=0.1)
    assert paper.verdicts["near"].scalars.systematic == pytest.approx(
        (SCREEN_LOSS + POINT_LOSS) / level(), rel=0.05
    )
    assert paper.verdicts["near"].scalars.own_bias == pytest.approx(
        POINT_LOSS / level(), rel=0.05
    ), "what a march with more reads would not lose"
    assert "near" not in other.verdicts
    assert visibility.verdicts["visibility"].scalars.systematic == pytest.approx(
        SCREEN_LOSS, rel=0.05
    ), "visibility errors are absolute"


def test_full_transport_judges_the_model_too(found):
    fine = found.results[1].verdicts["gi"]
    gap = abs(SCREEN_LOSS - MODEL_LOSS)
    assert fine.scalars.systematic == pytest.approx(gap / (level() + MODEL_LOSS), rel=0.05)


def test_references_are_refined_to_a_tenth_of_the_smallest_error(found):
    for name, reference in found.references.items():
        assert reference.ratio <= 0.1 * 1.3, name
        assert reference.batches >= 2
    assert found.references["near"].floor == pytest.approx(SCREEN_LOSS / level(), rel=0.05)


def test_the_front_is_that_of_the_fake_costs(found):
    fronts = {r.point.key for r in found.results if any(v.on_front for v in r.verdicts.values())}
    assert POINTS[0].key in fronts
    assert POINTS[1].key in fronts
    assert found.splits.keys() == fronts


def test_scaling_and_pictures_are_there(found):
    assert [series.name for series in found.series] == [
        "samples",
        "pixels",
        "radius",
        "triangles",
    ]
    # Spheres come in whole rings: the counts are close to what is wanted, not equal.
    assert found.series[3].x[0] == pytest.approx(400, rel=0.1)
    assert found.series[3].x[-1] == pytest.approx(400_000, rel=0.05)
    assert sum(p.is_reference for p in found.pictures) == 3
    assert any(p.name == POINTS[1].label and p.flip_png for p in found.pictures)


def test_flip_is_measured_where_it_was_asked_for(found):
    for result in found.results:
        for verdict in result.verdicts.values():
            assert np.isnan(verdict.scalars.flip_ldr) == (result.point.kind == "visibility")
    shown = {p.name for p in found.pictures}
    for result in found.results[:3]:
        hdr = [v.scalars.flip_hdr for v in result.verdicts.values()]
        assert all(0.0 < value < 1.0 for value in hdr) == (result.point.label in shown)


def test_a_finished_bench_measures_nothing_again(tmp_path, monkeypatch):
    first = run(tmp_path, FakeRenderer(), monkeypatch)
    renderer = FakeRenderer(speed=7.0)
    again = run(tmp_path, renderer, monkeypatch)
    assert renderer.count("timed") == 0
    assert again.results[0].timing.frame_ms.value == pytest.approx(
        first.results[0].timing.frame_ms.value, rel=1e-4
    )
    assert [r.verdicts["near"].error for r in again.results if "near" in r.verdicts] == [
        r.verdicts["near"].error for r in first.results if "near" in r.verdicts
    ]


@pytest.mark.parametrize("calls", [3, 25, 60])
def test_an_interrupted_bench_ends_like_one_that_was_not(tmp_path, monkeypatch, calls):
    whole = run(tmp_path / "a", FakeRenderer(), monkeypatch) if make(tmp_path) else None
    with pytest.raises(Interrupted):
        run(tmp_path / "b", FakeRenderer(interrupt_after=calls), monkeypatch)
    resumed = run(tmp_path / "b", FakeRenderer(), monkeypatch)
    assert whole is not None
    for one, other in zip(whole.results, resumed.results, strict=True):
        assert one.verdicts.keys() == other.verdicts.keys()
        for name, verdict in one.verdicts.items():
            assert other.verdicts[name].error.value == pytest.approx(verdict.error.value, rel=1e-5)


def make(tmp_path) -> bool:
    for name in "ab":
        (tmp_path / name).mkdir()
    return True


def test_another_bench_in_the_folder_is_measured_anew(tmp_path, monkeypatch):
    run(tmp_path, FakeRenderer(), monkeypatch)
    renderer = FakeRenderer()
    run(tmp_path, renderer, monkeypatch, dataclasses.replace(PLAN, seeds=2))
    assert renderer.count("timed") == PLAN.rounds * len(POINTS)


def test_damaged_files_are_measured_again(tmp_path, monkeypatch):
    whole = run(tmp_path, FakeRenderer(), monkeypatch)
    for path in [*tmp_path.rglob("*.npz"), tmp_path / "out" / "rounds.csv"]:
        path.write_bytes(b"\0damaged\n")
    renderer = FakeRenderer()
    again = run(tmp_path, renderer, monkeypatch)
    assert renderer.count("timed") == PLAN.rounds * len(POINTS)
    for one, other in zip(whole.results, again.results, strict=True):
        for name, verdict in one.verdicts.items():
            assert other.verdicts[name].error.value == pytest.approx(verdict.error.value, rel=1e-5)


@pytest.mark.parametrize(
    ("machine", "clock"),
    [
        ({"software": True, "load": 0.1}, "wall"),
        ({"software": True, "load": None}, "wall"),
        ({"software": True, "load": 1e3}, "process"),
        ({"software": False, "load": 1e3}, "gpu"),
    ],
)
def test_the_clock_is_the_one_that_can_be_trusted(tmp_path, machine, clock):
    bench_run = BenchRun(
        FakeRenderer(), BASE, POINTS, PLAN, False, tmp_path, StageProgress(None, None)
    )
    assert bench_run._clock({**MACHINE, **machine}) == clock
    assert bool(bench_run.notes) == (clock == "process")


def test_passes_are_timed_by_the_clock_of_the_frames(tmp_path, monkeypatch):
    renderer = FakeRenderer()
    monkeypatch.setitem(MACHINE, "load", 1e3)
    assert run(tmp_path, renderer, monkeypatch).clock == "process"
    assert renderer.split_clocks == {"process"}


def test_a_black_frame_is_refused(tmp_path, monkeypatch):
    renderer = FakeRenderer()
    plain = renderer.images

    def no_surface(settings, wanted):
        return {
            name: 0 * image if name == "depth" else image
            for name, image in plain(settings, wanted).items()
        }

    renderer.images = no_surface
    with pytest.raises(ValueError, match="no surface"):
        run(tmp_path, renderer, monkeypatch)


def test_stored_measurements_are_exact(tmp_path, monkeypatch, found):
    store = errors.ErrorStore(tmp_path / "store", "key")
    rng = np.random.default_rng(0)
    blocks = errors.BlockErrors(*(rng.random((2, 5)) for _ in range(2)), rng.random(5), np.ones(5))
    scalars = errors.Scalars(0.1, 0.2, parts={"bounce": 0.3}, failures=0)
    store.save(POINTS[0], {"near": errors.Judged(blocks, scalars)})
    kept = store.load(POINTS[0])
    assert kept is not None
    np.testing.assert_array_equal(kept["near"].blocks.squared, blocks.squared)
    assert kept["near"].scalars.parts == {"bounce": 0.3}
    assert store.load(POINTS[1]) is None
    assert errors.ErrorStore(tmp_path / "store", "other").load(POINTS[0]) is None


def test_emitters_and_background_do_not_count():
    mask = errors.judged_pixels(FakeRenderer(), dataclasses.replace(BASE, size=(16, 16)))
    assert not mask[:2].any()
    assert not mask[:, 0].any()
    assert mask[2:, 1:].all()


@pytest.mark.parametrize("reason", [None, "it stands alone"])
def test_all_light_is_measured_where_some_comes_from_beyond_the_radius(tmp_path, reason):
    renderer = FakeRenderer()
    renderer.why_spared = lambda settings, effect: reason  # type: ignore[attr-defined]
    points = [
        *POINTS,
        Point("radiance", "f", "gi", "march"),
        Point("radiance", "f", "reference-gi"),
    ]
    progress = StageProgress(None, None)
    bench_run = BenchRun(renderer, BASE, points, PLAN, False, tmp_path, progress)
    bench_run.leave_out_needless()
    left_out = [p.method for p in points if p not in bench_run.points]
    assert left_out == ([] if reason is None else ["gi"])
    assert [reason in note for note in bench_run.notes if reason] == [True] * len(left_out)
