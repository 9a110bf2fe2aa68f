"""Every corner of the settings: sizes, samples, steps, radii, subsets of outputs."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hard_cases.hard_scene import RADIUS, room
from hard_cases.invariants import sane
from hard_cases.methods import FEW_TEXELS, METHODS, SCREEN_SPACE, label, render

from ssdo_gl.images.files import exr_bytes
from ssdo_gl.renderer import Renderer
from ssdo_gl.settings import AOVS, Settings

SETTINGS = {
    "1 sample": {"samples": 1, "steps": 1, "spp": 1, "shadow_rays": 1},
    "1024 samples": {"samples": 1024, "steps": 16},
    "1 step": {"samples": 16, "steps": 1},
    "more steps than samples": {"samples": 4, "steps": 64},
    "radius 0": {"radius": 0.0},
    "radius 1e-9": {"radius": 1e-9},
    "radius below a pixel": {"radius": 1e-3},
    "radius 1e9": {"radius": 1e9},
    "radius inf": {"radius": float("inf")},
    "half resolution": {"resolution_scale": 0.5},
    "no filter": {"filter": "none"},
    "naive filter": {"filter": "naive"},
    "half resolution, naive filter": {"resolution_scale": 0.5, "filter": "naive"},
    "size 1x1": {"size": (1, 1)},
    "size 1x17": {"size": (1, 17)},
    "size 33x1": {"size": (33, 1)},
    "odd size": {"size": (37, 23)},
    "odd size at half resolution": {"size": (37, 23), "resolution_scale": 0.5},
    "antialias 3": {"antialias": 3},
    "no shadows": {"shadows": "none"},
    "shadow maps of the usual size": {"maps": {}},
    "traced shadows": {"shadows": "traced"},
    "largest seed": {"seed": 2**31 - 1},
}


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", SETTINGS)
def test_images_stay_sane(device, shaders, record, method, case):
    settings = {"size": (32, 24), **SETTINGS[case]}
    images = render(device, shaders, room(), method, **settings)
    if settings.get("antialias", 1) > 1:
        # The average of normals over a pixel's edge is no unit vector.
        del images["normal_ws"]
    height, width = images["beauty"].shape[:2]
    assert (width, height) == settings["size"]
    record(case, label(method), sane(images), 0, "insane values")


@pytest.mark.parametrize("method", SCREEN_SPACE[1:], ids=label)
def test_a_radius_of_nothing_occludes_nothing(device, shaders, record, method):
    if method[1] == "zbuffer":
        pytest.skip("the seed report's variant has no radius in the world")
    for radius in (0.0, 1e-9):
        images = render(device, shaders, room(), method, radius=radius)
        record("radius 0: occlusion", label(method), 1.0 - images["visibility"].min(), 0.0)
        record("radius 0: bounce", label(method), images["bounce"].max(), 0.0, "radiance")


@pytest.mark.parametrize("method", SCREEN_SPACE[1:], ids=label)
def test_a_larger_radius_never_brightens(device, shaders, record, method):
    """V_R falls as R grows; at 256 samples its mean must not rise by more than noise."""
    if method[1] == "zbuffer":
        pytest.skip("the seed report's variant has no radius in the world")
    means = [
        render(device, shaders, room(), method, radius=r, samples=256, images=("visibility",))[
            "visibility"
        ].mean()
        for r in (0.05, 0.1, 0.2, 0.4, 0.8)
    ]
    # 3072 pixels of 256 samples: the noise of the mean is below 1e-3.
    record("larger radius", label(method), float(np.diff(means).max()), 1e-3, "brighter")


SUBSETS = [s for n in range(1, len(AOVS) + 1) for s in itertools.combinations(AOVS, n)]


def check_subsets(device, shaders, record, method, case, subsets):
    """Culling what nobody asked for must not change what was asked for."""
    settings = Settings(
        method=method[0], estimator=method[1], size=(16, 12), samples=8, steps=4, spp=2,
        shadow_rays=1, radius=RADIUS, overrides=FEW_TEXELS,
    )  # fmt: skip
    changed = 0
    with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
        everything = renderer.render(AOVS).images
        for subset in subsets:
            images = renderer.render(subset).images
            assert set(images) == set(subset)
            # Shaders of other variants may round otherwise, by a few ulp.
            changed += sum(
                not np.allclose(images[name], everything[name], rtol=1e-6, atol=1e-7)
                for name in subset
            )
    record(case, label(method), changed, 0, "images changed")


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_a_subset_of_images_is_the_same_as_all(device, shaders, record, method):
    """Each image alone, all but each, and some in between; every one is a slow test."""
    ends = [s for s in SUBSETS if len(s) in (1, len(AOVS) - 1)]
    check_subsets(device, shaders, record, method, "subsets of outputs", ends + SUBSETS[::97])


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS, ids=label)
def test_every_subset_of_images_is_the_same_as_all(device, shaders, record, method):
    check_subsets(device, shaders, record, method, "all 1023 subsets of outputs", SUBSETS)


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_nothing_is_kept_in_half_floats(device, shaders, record, method):
    """65504 is the largest of them: no image of any stage is stored in a type so small."""
    half = 0
    for effects in ("auto", "full"):
        settings = Settings(
            method=method[0], estimator=method[1], effects=effects, size=(4, 4), spp=1
        )
        with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
            _, plan = renderer._plan(AOVS)
            written = [spec for item in plan.order for spec in item.writes.values()]
        assert written
        half += sum(spec.dtype == "f2" for spec in written)
    record("images in half floats", label(method), half, 0, "images")


def test_files_keep_what_half_floats_could_not(tmp_path, record):
    """An .exr may hold halves, whose Inf would be this program's: 1e8 must come back."""
    OpenEXR = pytest.importorskip("OpenEXR")
    beauty = np.full((4, 4, 4), 1e8, np.float32)
    beauty[0, 0] = 1e-8
    path = tmp_path / "bright.exr"
    path.write_bytes(exr_bytes({"beauty": beauty}, {}))
    with OpenEXR.File(str(path)) as file:
        read = np.concatenate(
            [channel.pixels.reshape(4, 4, -1) for channel in file.channels().values()], axis=2
        )
    gap = float(np.abs(np.sort(read, axis=None) - np.sort(beauty, axis=None)).max())
    record("1e8 and 1e-8 in an .exr", "file", gap, 0.0, "off")


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS, ids=label)
def test_4k(device, shaders, record, method):
    """Every tile of the references, and coordinates beyond what 11 bits hold."""
    size = (3840, 2160)
    images = render(device, shaders, room(), method, size=size, samples=8, spp=2)
    assert images["beauty"].shape[:2] == size[::-1]
    record("4K", label(method), sane(images), 0, "insane values")
