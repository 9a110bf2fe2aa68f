"""Skips that take more than a line of `test_skip_table.py`; images agree as there."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from properties.planned_and_full import (
    BLACK,
    BOX,
    DAWN,
    FRONT,
    LAMP,
    OFF,
    PILE,
    SKY,
    TORUS,
    WHITE,
    WINDOW,
    at,
    compare,
    make_scene,
    turned,
)

from ssdo_gl.scene.lights import DirectionalLight

SUN = DirectionalLight((0.3, -0.8, -0.52), WHITE)


@pytest.fixture
def both(device, shaders):
    """Compare the planned rendering of a scene with the full one."""

    def run(*items, **more):
        known = {key: more.pop(key) for key in ("lights", "environment", "camera") if key in more}
        return compare(device, shaders, make_scene(*items, **known), **more)

    return run


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
@pytest.mark.parametrize(
    "settings", [{}, {"resolution_scale": 0.5}, {"filter": "none"}, {"filter": "naive"}]
)
def test_a_constant_sky_under_every_filter(both, estimator, settings):
    found = both(*PILE, environment=SKY, estimator=estimator, **settings)
    assert found.images["visibility"].min() < 0.9


@pytest.mark.parametrize("method", ["ssao", "bounce"])
def test_one_box_is_open_everywhere(both, method):
    matrix = turned(20.0, 30.0, 10.0) @ np.diag([2.0, 2.0, 2.0, 1.0])
    lone = both((BOX, matrix), lights=[SUN], environment=DAWN, method=method)
    assert lone.is_open
    assert not {"bounce", "ssao", "back_faces"} & lone.ran
    assert np.all(lone.images["visibility"] == 1.0)
    dented = both((TORUS, matrix), lights=[SUN], environment=DAWN, method=method)
    assert not dented.is_open and dented.images["visibility"].min() < 0.99


def test_a_box_seen_from_its_inside_is_no_open_view(both):
    room = (BOX, np.diag([14.0, 14.0, 14.0, 1.0]))
    wide = dataclasses.replace(FRONT, fov_y=100.0)
    inside = both(room, lights=[LAMP], radius=4.0, camera=wide)
    assert not inside.is_open and inside.images["visibility"].min() < 0.95


@pytest.mark.parametrize("shadow", ["map", "ssdo"])
def test_a_light_that_is_off_is_left_out(both, shadow):
    lamp = dataclasses.replace(LAMP, shadow=shadow)
    skipped = both(*PILE, lights=[SUN, dataclasses.replace(lamp, intensity=BLACK)])
    assert skipped.decided.lights == (True, False)
    assert not skipped.runs("directional")
    almost = both(*PILE, lights=[SUN, lamp])
    assert almost.decided.lights == (True, True)
    assert almost.runs("directional") == (shadow == "ssdo")


def test_a_light_that_is_left_out_makes_no_map_of_another_finer(both):
    # With the six faces of the one that is off, tiles are halved to fit into the atlas.
    skipped = both(*PILE, lights=[OFF, SUN], overrides={"shadow_map.max_atlas": 1024})
    assert skipped.decided.lights == (False, True)


def test_a_light_that_is_left_out_moves_no_samples_of_another(both):
    lamp = dataclasses.replace(LAMP, shadow="ssdo")
    off = dataclasses.replace(lamp, intensity=BLACK)
    skipped = both(*PILE, lights=[off, lamp], steps=2)
    assert skipped.decided.lights == (False, True)


def test_lights_alone_are_not_looked_for_in_other_directions(both):
    wanted = ("beauty", "directional", "bounce")
    lamps = both(*PILE, lights=[WINDOW], wanted=wanted)
    assert lamps.runs("directional") and lamps.decided.spares("hemisphere")
    assert not both(*PILE, lights=[WINDOW]).decided.spares("hemisphere")
    sky = both(*PILE, lights=[WINDOW], environment=DAWN, wanted=wanted)
    assert not sky.decided.spares("hemisphere")


@pytest.mark.parametrize(
    "more",
    [
        {"environment": DAWN},
        {"environment": SKY},
        {"lights": [LAMP]},
        {"lights": [WINDOW]},
        {"environment": DAWN, "resolution_scale": 0.5},
        {"environment": DAWN, "samples": 64},
    ],
)
def test_one_march_serves_the_bounce_too(both, more):
    shared = both(*PILE, **{"lights": [LAMP], **more})
    assert shared.shares_directions and np.any(shared.images["bounce"] > 0.0)
    apart = {"bounce.thickness": 0.4}
    alone = both(*PILE, **{"lights": [LAMP], **more}, overrides=apart)
    assert not alone.shares_directions


@pytest.mark.parametrize("combine", ["ambient", "multiply", "report"])
@pytest.mark.parametrize("lights", [(), (LAMP,)])
@pytest.mark.parametrize("environment", [None, SKY])
def test_visibility_multiplies_only_what_is_there(both, combine, lights, environment):
    found = both(
        *PILE, lights=lights, environment=environment, method="ssao", combine=combine,
        wanted=("beauty",),
    )  # fmt: skip
    multiplies = bool(lights) if combine != "ambient" else environment is not None
    expected = multiplies or (combine == "multiply" and environment is not None)
    assert found.runs("ssao") == expected


def test_infinite_radius(both):
    assert both(*PILE, environment=DAWN, radius=math.inf).runs("bounce")
    lone = both((BOX, at(0, 0, 0)), environment=DAWN, radius=math.inf)
    assert lone.is_open
