"""One line for every skip: what calls for it, what almost does, and how to tell.

Each scene is rendered as planned and in full; `compare` asserts that all images that were
asked for agree, and unless a line says otherwise that is every AOV. `test_skips.py` goes into
the details of most lines, `test_kept.py` has the skips over time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest
from properties.planned_and_full import (
    BLACK,
    FLOOR,
    FRONT,
    GREY,
    LAMP,
    OFF,
    PILE,
    QUAD,
    SKY,
    WINDOW,
    Compared,
    at,
    compare,
    make_scene,
)

from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, GradientEnvironment
from ssdo_gl.scene.material import Material, Texture

FAINT = dataclasses.replace(LAMP, intensity=(0.0, 0.0, 1e-3))
ALMOST_SKY = GradientEnvironment((0.5, 0.6, 0.7), (0.5, 0.6, 0.7), (0.5, 0.6, 0.69))
FAINT_SKY = ConstantEnvironment((0.0, 0.0, 1e-3))
WALL = (QUAD, at(-2.5, -1.0, -1.0) @ np.diag([5.0, 5.0, 1.0, 1.0]))


def painted(albedo, last):
    """Return the pile in `albedo`, its last body in `last`."""
    *most, (mesh, matrix) = PILE
    items = [(*item, Material(albedo=albedo)) for item in most]
    return [*items, (mesh, matrix, Material(albedo=last))]


class Skip(NamedTuple):
    """A skip, two scenes, whether what was rendered shows that it was made, and an image.

    In the second scene the image that the skip would leave black is not.
    """

    name: str
    trigger: Mapping[str, Any]
    almost: Mapping[str, Any]
    is_skipped: Callable[[Compared], bool]
    shown: str = "beauty"


SKIPS = [
    Skip(
        "no environment and no ssdo light: no directional light",
        {"lights": [LAMP]},
        {"lights": [LAMP], "environment": FAINT_SKY},
        lambda c: not c.runs("directional") and "directional" in c.ran_in_full,
        "directional",
    ),
    Skip(
        "a black environment is none",
        {"lights": [LAMP], "environment": ConstantEnvironment(BLACK)},
        {"lights": [WINDOW]},
        lambda c: not c.runs("directional"),
        "directional",
    ),
    Skip(
        "an ssdo light that is off is none",
        {"lights": [LAMP, dataclasses.replace(WINDOW, radiance=BLACK)]},
        {"lights": [LAMP, dataclasses.replace(WINDOW, radiance=(0.0, 1e-3, 0.0))]},
        lambda c: not c.runs("directional") and "directional" in c.ran_in_full,
    ),
    Skip(
        "nothing lit: no bounce",
        {"lights": [OFF]},
        {"lights": [FAINT]},
        lambda c: not c.runs("bounce") and "bounce" in c.ran_in_full,
        "bounce",
    ),
    Skip(
        "nothing lit, and nothing that glows: no bounce",
        {"lights": [OFF]},
        {"items": [*PILE[:2], (*PILE[2], Material(albedo=GREY, emission=(0.0, 0.5, 0.0)))]},
        lambda c: not (c.runs("bounce") or c.images["beauty"][..., :3].any()),
        "bounce",
    ),
    Skip(
        "black albedo everywhere: no bounce",
        {"items": painted(BLACK, BLACK), "lights": [LAMP]},
        {"items": painted(BLACK, (0.0, 1e-3, 0.0)), "lights": [LAMP]},
        lambda c: not c.runs("bounce") and "bounce" in c.ran_in_full,
        "bounce",
    ),
    Skip(
        "a box that stands alone: no occlusion looked for, no bounce",
        {"items": [PILE[1]], "lights": [LAMP], "environment": SKY},
        {"items": PILE[1:], "lights": [LAMP], "environment": SKY},
        lambda c: c.is_open and not {"ssao", "bounce"} & c.ran,
    ),
    Skip(
        "a light that is off: neither light nor map",
        {"lights": [OFF]},
        {"lights": [FAINT]},
        lambda c: not c.runs("direct", "shadow_map") and "direct" in c.ran_in_full,
    ),
    Skip(
        "images of the G-buffer alone: one pass",
        {"environment": SKY, "lights": [LAMP], "wanted": ("depth", "normal_ws", "albedo")},
        {"environment": SKY, "lights": [LAMP], "wanted": ("depth", "visibility")},
        lambda c: c.ran == {"gbuffer"},
        "visibility",
    ),
    Skip(
        "an image without the bounce: no bounce",
        {"environment": SKY, "lights": [LAMP], "wanted": ("direct", "directional")},
        {"environment": SKY, "lights": [LAMP], "wanted": ("direct", "directional", "bounce")},
        lambda c: not c.runs("bounce"),
        "bounce",
    ),
    Skip(
        "one march for directional light and bounce",
        {"environment": ALMOST_SKY, "lights": [LAMP]},
        {"environment": ALMOST_SKY, "lights": [LAMP], "overrides": {"bounce.bias": 0.011}},
        lambda c: c.shares_directions,
    ),
    Skip(
        "no emission: none read",
        {"lights": [LAMP]},
        {"items": [*PILE[:2], (*PILE[2], Material(emission=(0.0, 1e-3, 0.0)))], "lights": [LAMP]},
        lambda c: not c.runs("emission"),
        "emission",
    ),
    Skip(
        "no solid: no layer of backs",
        {"items": [FLOOR, WALL], "lights": [LAMP], "environment": SKY},
        {"items": [FLOOR, WALL, PILE[1]], "lights": [LAMP], "environment": SKY},
        lambda c: "back_faces" not in c.ran and "back_faces" in c.ran_in_full,
    ),
    Skip(
        "no surface in view: nothing",
        {"lights": [LAMP], "camera": dataclasses.replace(FRONT, target=(0.0, 0.0, 12.0))},
        {"lights": [LAMP], "camera": dataclasses.replace(FRONT, target=(4.0, 0.0, 1.0))},
        lambda c: (
            c.is_open
            and np.all(c.images["visibility"] == 1.0)
            and not {"direct", "directional", "bounce", "ssao", "shadow_map"} & c.ran
        ),
        "depth",
    ),
]


def rendered(device, shaders, case):
    known = {"items": PILE, **case}
    about = {k: known.pop(k) for k in ("lights", "environment", "camera") if k in known}
    scene = make_scene(*known.pop("items"), **about)
    return compare(device, shaders, scene, **known)


@pytest.mark.parametrize("skip", SKIPS, ids=lambda skip: skip.name)
def test_a_scene_that_calls_for_it_and_one_that_almost_does(device, shaders, skip):
    assert skip.is_skipped(rendered(device, shaders, skip.trigger))
    almost = rendered(device, shaders, skip.almost)
    assert not skip.is_skipped(almost)
    assert np.any(almost.images[skip.shown] > 0.0)


def test_without_images_the_variant_without_fetches(device):
    """A white image changes nothing but the variant that is compiled."""
    white = Texture(np.full((4, 4, 4), 255, np.uint8))
    images, fetches = [], []
    for texture in (None, white):
        material = Material(albedo=GREY, albedo_texture=texture)
        items = [(mesh, matrix, material) for mesh, matrix in PILE]
        fresh = ShaderLibrary(device.gl)
        found = rendered(device, fresh, {"items": items, "lights": [LAMP], "environment": SKY})
        images.append(found.images)
        variants = [
            dict(defines)
            for _, name, defines, *_ in fresh._by_name
            if name == "passes/gbuffer.frag"
        ]
        fetches.append({variant["HAS_ALBEDO_IMAGE"] for variant in variants})
    assert fetches == [{0}, {1}]
    for name, plain in images[0].items():
        assert np.array_equal(plain, images[1][name]), name


@pytest.mark.parametrize("environment", [None, SKY, ALMOST_SKY])
def test_pixels_of_the_sky_hold_neutral_values(device, shaders, environment):
    found = rendered(device, shaders, {"lights": [LAMP, WINDOW], "environment": environment})
    sky = found.images["depth"][..., 0] == 0.0
    assert 0.2 < sky.mean() < 0.8
    assert np.all(found.images["visibility"][sky] == 1.0)
    for name in ("direct", "directional", "bounce", "emission", "albedo", "normal_ws"):
        assert np.all(found.images[name][sky] == 0.0), name
    # The neighbours of the sky are not.
    assert np.all(found.images["albedo"][~sky] > 0.0)
