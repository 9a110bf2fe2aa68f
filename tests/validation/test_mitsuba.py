"""The path tracer against Mitsuba 3: per pixel, and in the mean to half a per cent."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from oracle.monte_carlo import two_sample_deviation
from passes.ray_harness import Tracer

from benchmarks.mitsuba_scene import compared_scene, load_mitsuba, mitsuba_scene, render
from ssdo_gl.effects.references.reference_gi import ReferenceGiPass, ReferenceGiSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.scene.scene import Scene

# What both must agree to in the mean; the standard error of each mean is a fifth of it.
MEAN_TOLERANCE = 5e-3
# Pixels may differ by this share of the mean: facets and rectangles reach Mitsuba in
# float32 world units, and its rays start 1e-4 of a coordinate off where ours start 4e-6
# of the scene off.
PIXEL_ALLOWANCE = 2e-3
RUNS = 16
DEPTHS = {"direct": (0, 2), "one bounce": (1, 3), "full": (None, -1)}


def ours(
    device, shaders, scene: Scene, size: tuple[int, int], bounces: int | None, frames: int, spp: int
) -> NDArray[np.float64]:
    """Return RUNS images, each the mean of `frames` with samples all over the pixels."""
    rng = np.random.default_rng(3)
    item = ReferenceGiPass(
        ReferenceGiSettings(spp=spp, bounces=bounces),
        RayFeatures.of(scene),
        kind_of(scene.environment),
    )
    images = []
    with Tracer(device, shaders, scene, size) as tracer:
        view = tracer.frame.view
        for run in range(RUNS):
            total = np.zeros((size[1], size[0], 3))
            # One sample of the pixel's area in each cell of a grid.
            side = int(np.sqrt(frames))
            for i in range(side * side):
                cell = np.array([i % side, i // side])
                jitter = tuple((cell + rng.uniform(size=2)) / side - 0.5)
                tracer.frame = dataclasses.replace(
                    tracer.frame, view=dataclasses.replace(view, jitter_px=jitter)
                )
                seed = run * side * side + i
                total += tracer.run(item, seed=seed)["gi_radiance"][..., :3]
            images.append(total / side**2)
    return np.array(images)


def compare(device, shaders, folder: Path, name: str, depth: str, size, frames, spp) -> None:
    mi = load_mitsuba()
    scene = compared_scene(name)
    bounces, max_depth = DEPTHS[depth]
    loaded = mitsuba_scene(mi, scene, folder)
    theirs = np.array(
        [
            render(mi, loaded, scene.camera, size, max_depth, frames * spp, seed)
            for seed in range(RUNS)
        ]
    )
    mine = ours(device, shaders, scene, size, bounces, frames, spp)
    mean = theirs.mean()
    assert mean > 0.01
    for channel in range(3):
        ratio = mine[..., channel].mean() / theirs[..., channel].mean()
        assert ratio == pytest.approx(1.0, abs=MEAN_TOLERANCE)
    assert two_sample_deviation(mine, theirs, PIXEL_ALLOWANCE * mean) <= 1.0


@pytest.mark.parametrize("depth", list(DEPTHS))
@pytest.mark.parametrize("name", ["cornell_meso", "coloured_lights", "stairs"])
def test_small_images_agree(device, shaders, tmp_path, name: str, depth: str) -> None:
    compare(device, shaders, tmp_path, name, depth, (24, 18), 9, 8)


@pytest.mark.slow
@pytest.mark.parametrize("depth", list(DEPTHS))
@pytest.mark.parametrize("name", ["cornell_meso", "coloured_lights", "stairs"])
def test_larger_images_agree(device, shaders, tmp_path, name: str, depth: str) -> None:
    compare(device, shaders, tmp_path, name, depth, (64, 64), 16, 16)
