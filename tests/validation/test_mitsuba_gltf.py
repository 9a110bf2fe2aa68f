"""The path tracer's glossy surfaces against a BSDF of glTF's written for Mitsuba 3."""

from __future__ import annotations

import numpy as np
import pytest
from scene_text import body, box, camera, material, quad, table
from validation.test_mitsuba import RUNS, ours

from benchmarks.mitsuba_gltf import register
from benchmarks.mitsuba_scene import load_mitsuba, mitsuba_scene, render
from ssdo_gl.scene.formats.toml import read_description

SIZE = (16, 12)
# Paths per pixel and run. Python evaluates Mitsuba's side: 20 000 surfaces a second.
FRAMES, SPP = 4, 4
REST = (
    camera([0, 1.0, 4], [0, 0.3, 0], 35)
    + table(
        "environment", kind="gradient",
        zenith=[0.4, 0.7, 1.2], horizon=[0.9, 0.9, 0.9], ground=[0.2, 0.1, 0.1],
    )
    + quad([-3, 0, 3], [6, 0, 0], [0, 0, -6], "floor")
    + box([-1.2, 0, -0.5], [-0.1, 1.1, 0.5], "body")
    + "transform = { rotate = [0, 25, 0] }\n"
    + body("cone", "body", base=[0.8, 0, 0], top=[0.8, 1.2, 0], radius=0.6)
)  # fmt: skip


@pytest.mark.parametrize("bounces", [1, None])
@pytest.mark.parametrize(
    ("floor", "metallic", "rough"), [(1.0, 1.0, 0.3), (0.4, 0.0, 0.6), (0.7, 0.5, 0.5)]
)
def test_means_agree(device, shaders, tmp_path, floor, metallic, rough, bounces):
    mi = load_mitsuba()
    register(mi)
    text = REST + material("floor", 0.6, 0.5, 0.4, roughness=floor)
    text += material("body", 1.0, 0.77, 0.34, metallic=metallic, roughness=rough)
    scene = read_description(text, "scene.toml")
    loaded = mitsuba_scene(mi, scene, tmp_path)
    depth = -1 if bounces is None else bounces + 2
    theirs = np.array(
        [render(mi, loaded, scene.camera, SIZE, depth, FRAMES * SPP, run) for run in range(RUNS)]
    )
    mine = ours(device, shaders, scene, SIZE, bounces, FRAMES, SPP * 4)
    means = [images.mean(axis=(1, 2)) for images in (mine, theirs)]
    errors = [mean.std(axis=0, ddof=1) / np.sqrt(RUNS) for mean in means]
    difference = np.abs(means[0].mean(axis=0) - means[1].mean(axis=0))
    # Half a per cent, and what the noise of so few paths may add at most.
    allowed = 0.005 * means[1].mean(axis=0) + 3.5 * np.hypot(*errors)
    assert np.all(difference < allowed), (difference, allowed)
    assert np.all(np.hypot(*errors) < 0.006 * means[1].mean(axis=0))
