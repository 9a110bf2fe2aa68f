"""References: accumulation, stopping, caching and what makes a cached one stale."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from bench.fake_renderer import MeasuresEach

from ssdo_gl.bench.measure import reference_cache
from ssdo_gl.bench.measure.reference_cache import (
    Accumulator,
    Goal,
    Reference,
    ReferenceCache,
    obtain,
    reference_key,
)
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (32, 24)
MASK = np.ones((24, 32), dtype=bool)
SIGMA = 0.4


def scene(albedo: float = 0.5, title: str = "") -> Scene:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    mesh = Mesh(positions, np.array([[0, 1, 2]]))
    return Scene(
        (mesh,),
        (Material(albedo=(albedo,) * 3),),
        (SceneObject(0, 0),),
        Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0)),
        title=title,
    )


class FakeReference(MeasuresEach):
    """Renders a constant image of 1 with noise, and counts how often it is asked."""

    def __init__(self) -> None:
        self.scene, self.device_name = scene(), "fake"
        self.seeds: list[int] = []

    def images(self, settings: Settings, wanted: object = ()) -> dict[str, np.ndarray]:
        self.seeds.append(settings.seed)
        noise = np.random.default_rng(settings.seed).normal(0.0, SIGMA, (24, 32, 3))
        return {"beauty": (1.0 + noise).astype(np.float32)}


BATCH = Settings(method="reference-near", size=SIZE, radius=0.3, spp=8)


def rendered(tmp_path, reference: FakeReference, wanted: Goal) -> Reference:
    cache = ReferenceCache(tmp_path)
    return obtain(reference, BATCH, ("beauty",), wanted, MASK, cache)


def goal(standard_error: float, max_seconds: float = 60.0) -> Goal:
    return Goal("beauty", standard_error, relative=False, max_seconds=max_seconds)


def test_the_accumulator_gives_mean_and_variance_of_the_mean():
    rng = np.random.default_rng(0)
    batches = rng.random((5, 4, 3, 2))
    kept = Accumulator()
    for batch in batches:
        kept.add({"a": batch})
    result = kept.reference(spp=20, seconds=1.0)
    np.testing.assert_allclose(result.images["a"], batches.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(result.variance["a"], batches.var(axis=0, ddof=1) / 5, rtol=1e-5)


def test_one_batch_knows_nothing_of_its_error():
    kept = Accumulator()
    kept.add({"a": np.ones((2, 2, 1))})
    assert kept.reference(1, 0.0).standard_error("a", np.ones((2, 2), dtype=bool)) == math.inf


def test_a_reference_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="NaN"):
        Accumulator().add({"a": np.array([[[np.nan]]])})


def test_the_standard_error_is_that_of_the_mean():
    kept = Accumulator()
    reference = FakeReference()
    for seed in range(16):
        kept.add(reference.images(dataclasses.replace(BATCH, seed=seed)))
    # sigma / sqrt(16); 2304 values of variance with 15 degrees of freedom: 1 %.
    assert kept.reference(16, 0).standard_error("beauty", MASK) == pytest.approx(
        SIGMA / 4, rel=0.03
    )
    assert kept.reference(16, 0).relative_standard_error("beauty", MASK) == pytest.approx(
        SIGMA / 4, rel=0.05
    )


def test_batches_are_added_until_the_goal_is_reached(tmp_path):
    reference = FakeReference()
    result = rendered(tmp_path, reference, goal(0.1))
    # sigma / sqrt(n) <= 0.1 at n = 16, give or take the scatter of the estimate.
    assert 14 <= result.batches <= 18
    assert result.spp == 8 * result.batches
    assert len(set(reference.seeds)) == len(reference.seeds), "every batch has its own seed"
    assert result.standard_error("beauty", MASK) <= 0.1


def test_time_ends_what_the_goal_does_not(tmp_path):
    reference = FakeReference()
    result = rendered(tmp_path, reference, goal(1e-9, max_seconds=0.0))
    assert result.batches == reference_cache.MIN_BATCHES, "no reference without a standard error"


def test_a_cached_reference_is_reused_and_extended_with_new_seeds(tmp_path):
    first, second, third = FakeReference(), FakeReference(), FakeReference()
    coarse = rendered(tmp_path, first, goal(0.2))
    again = rendered(tmp_path, second, goal(0.2))
    assert second.seeds == []
    np.testing.assert_array_equal(again.images["beauty"], coarse.images["beauty"])
    # The scatter is kept in float32.
    np.testing.assert_allclose(again.variance["beauty"], coarse.variance["beauty"], rtol=1e-6)
    fine = rendered(tmp_path, third, goal(0.1))
    assert fine.batches == len(first.seeds) + len(third.seeds)
    assert not set(first.seeds) & set(third.seeds)
    assert fine.spp == 8 * fine.batches


def test_a_damaged_cache_file_is_rendered_again(tmp_path):
    rendered(tmp_path, FakeReference(), goal(0.2))
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:100])
    reference = FakeReference()
    rendered(tmp_path, reference, goal(0.2))
    assert reference.seeds


NEAR = Settings(method="reference-near", size=SIZE, radius=0.3)


@pytest.mark.parametrize(
    "change",
    [{"radius": 0.4}, {"size": (33, 24)}, {"method": "reference-ao"}, {"shadows": "traced"},
     {"overrides": {"direct.x": 1}}, {"spp": 7}],
)  # fmt: skip
def test_what_changes_a_reference_changes_its_key(change):
    other = dataclasses.replace(NEAR, **change)
    assert reference_key(scene(), other, "r", ("a",)) != reference_key(scene(), NEAR, "r", ("a",))


@pytest.mark.parametrize("change", [{"seed": 9}, {"samples": 3}, {"exposure": 2.0}])
def test_what_leaves_a_reference_alone_keeps_its_key(change):
    other = dataclasses.replace(NEAR, **change)
    assert reference_key(scene(), other, "r", ("a",)) == reference_key(scene(), NEAR, "r", ("a",))


def test_full_light_transport_does_not_depend_on_the_radius():
    near, far = (
        dataclasses.replace(NEAR, method="reference-gi", radius=r, bounces=b)
        for r, b in ((0.3, None), (0.6, None))
    )
    assert reference_key(scene(), near, "r", ("a",)) == reference_key(scene(), far, "r", ("a",))
    other = dataclasses.replace(near, bounces=1)
    assert reference_key(scene(), near, "r", ("a",)) != reference_key(scene(), other, "r", ("a",))


def test_scene_and_renderer_are_part_of_the_key():
    key = reference_key(scene(), NEAR, "r", ("a",))
    assert reference_key(scene(albedo=0.6), NEAR, "r", ("a",)) != key
    assert reference_key(scene(), NEAR, "another GPU", ("a",)) != key
    assert reference_key(scene(), NEAR, "r", ("a", "b")) != key
    assert reference_key(scene(), NEAR, "r", ("b", "a")) == reference_key(
        scene(), NEAR, "r", ("a", "b")
    )
    assert reference_key(scene(title="renamed"), NEAR, "r", ("a",)) == key


def test_a_changed_reference_shader_invalidates(monkeypatch):
    key = reference_key(scene(), NEAR, "r", ("a",))
    monkeypatch.setattr(reference_cache, "shader_fingerprint", lambda prefixes: "edited")
    assert reference_key(scene(), NEAR, "r", ("a",)) != key


def test_without_a_cache_references_last_as_long_as_the_command(tmp_path, monkeypatch, capsys):
    """Neither a cache that cannot be made nor one that is full ends what was asked for."""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "file"))
    never = ReferenceCache()
    full = ReferenceCache(tmp_path / "gone")
    for cache in (never, full):
        first, second = FakeReference(), FakeReference()
        coarse = obtain(first, BATCH, ("beauty",), goal(0.2), MASK, cache)
        fine = obtain(second, BATCH, ("beauty",), goal(0.1), MASK, cache)
        assert fine.batches == len(first.seeds) + len(second.seeds) > coarse.batches
        assert not set(first.seeds) & set(second.seeds)
    no_folder, no_file = capsys.readouterr().err.splitlines()
    assert no_folder.startswith("ssdo-gl: references are not kept: ")
    assert "SSDO_GL_CACHE" in no_folder and "gone" in no_file
