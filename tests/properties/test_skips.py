"""Every skip: a scene that calls for it, one that almost does, and images that agree."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from properties.planned_and_full import (
    BLACK,
    BOX,
    FRONT,
    GREY,
    QUAD,
    TORUS,
    WHITE,
    at,
    compare,
    make_scene,
    turned,
)

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
)
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material

POINT = PointLight((1.5, 3.0, 2.5), (20.0, 20.0, 20.0))
SUN = DirectionalLight((0.3, -0.8, -0.52), WHITE)
PANEL = RectangleLight((-1.0, 2.5, -1.0), (2, 0, 0), (0, 0, 2), (3.0, 3.0, 3.0))
WINDOW = dataclasses.replace(PANEL, shadow="ssdo")
SPOT = SpotLight((0.0, 4.0, 0.0), (0.0, -1.0, 0.0), (20.0, 20.0, 20.0), 10.0, 30.0)
SKY = ConstantEnvironment((0.5, 0.6, 0.7))
DAWN = GradientEnvironment((0.5, 0.6, 0.7), (0.9, 0.5, 0.3), (0.2, 0.2, 0.2))
FLOOR = (QUAD, at(-2.5, -1.0, 2.5) @ turned(-90.0, 0.0, 0.0) @ np.diag([5.0, 5.0, 1.0, 1.0]))
PILE = (FLOOR, (BOX, at(-0.6, -0.5, 0.0)), (TORUS, at(0.8, -0.7, 0.2)))


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


def test_without_sky_and_window_there_is_no_directional_light(both):
    skipped = both(*PILE, lights=[POINT])
    assert not skipped.runs("directional") and "directional" in skipped.ran_in_full
    black = both(*PILE, lights=[POINT], environment=ConstantEnvironment(BLACK))
    assert not black.runs("directional")
    faint = both(*PILE, lights=[POINT], environment=ConstantEnvironment((0.0, 0.0, 1e-3)))
    assert faint.runs("directional") and np.any(faint.images["directional"] > 0.0)
    assert both(*PILE, lights=[WINDOW]).runs("directional")


def test_black_surfaces_send_nothing_on(both):
    def painted(albedo):
        return [(mesh, matrix, Material(albedo=albedo)) for mesh, matrix in PILE]

    assert not both(*painted(BLACK), lights=[POINT], environment=DAWN).runs("bounce")
    dark = [*painted(BLACK)[:-1], painted((0.0, 0.02, 0.0))[-1]]
    almost = both(*dark, lights=[POINT], environment=DAWN)
    assert almost.runs("bounce") and np.any(almost.images["bounce"] > 0.0)


def test_what_is_not_lit_sends_nothing_on(both):
    unlit = both(*PILE, lights=[dataclasses.replace(POINT, intensity=BLACK)])
    assert not (unlit.runs("direct") or unlit.runs("bounce"))
    assert np.all(unlit.images["beauty"][..., :3] == 0.0)
    glow = Material(albedo=GREY, emission=(0.0, 0.5, 0.0))
    glowing = both(*PILE[:2], (*PILE[2], glow))
    assert glowing.runs("bounce") and np.any(glowing.images["bounce"] > 0.0)


def test_emission_is_read_only_where_something_emits(both):
    assert not both(*PILE, lights=[POINT]).runs("emission")
    lamp = both(*PILE[:2], (*PILE[2], Material(emission=(0.0, 1e-3, 0.0))), lights=[POINT])
    assert lamp.runs("emission") and np.any(lamp.images["emission"] > 0.0)


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
    inside = both(room, lights=[POINT], radius=4.0, camera=wide)
    assert not inside.is_open and inside.images["visibility"].min() < 0.95


@pytest.mark.parametrize("shadow", ["map", "ssdo"])
def test_a_light_that_is_off_is_left_out(both, shadow):
    lamp = dataclasses.replace(POINT, shadow=shadow)
    skipped = both(*PILE, lights=[SUN, dataclasses.replace(lamp, intensity=BLACK)])
    assert skipped.decided.lights == (True, False)
    assert not skipped.runs("directional")
    almost = both(*PILE, lights=[SUN, lamp])
    assert almost.decided.lights == (True, True)
    assert almost.runs("directional") == (shadow == "ssdo")


def test_a_light_that_is_left_out_makes_no_map_of_another_finer(both):
    # With the six faces of the one that is off, tiles are halved to fit into the atlas.
    off = dataclasses.replace(POINT, intensity=BLACK)
    skipped = both(*PILE, lights=[off, SUN], overrides={"shadow_map.max_atlas": 1024})
    assert skipped.decided.lights == (False, True)


def test_a_light_that_is_left_out_moves_no_samples_of_another(both):
    lamp = dataclasses.replace(POINT, shadow="ssdo")
    off = dataclasses.replace(lamp, intensity=BLACK)
    skipped = both(*PILE, lights=[off, lamp], steps=2)
    assert skipped.decided.lights == (False, True)


def test_a_view_of_nothing_needs_nothing(both):
    away = Camera((0.0, 0.0, 6.0), (0.0, 0.0, 12.0))
    empty = both(*PILE, lights=[POINT], environment=DAWN, camera=away)
    assert empty.is_open
    assert not {"direct", "directional", "bounce", "ssao", "shadow_map"} & empty.ran
    assert np.all(empty.images["visibility"] == 1.0)
    corner = Camera((0.0, 0.0, 6.0), (4.0, 0.0, 1.0))
    some = both(*PILE, lights=[POINT], environment=DAWN, camera=corner)
    assert {"direct", "directional"} <= some.ran and np.any(some.images["depth"] > 0.0)


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
        {"lights": [POINT]},
        {"lights": [WINDOW]},
        {"environment": DAWN, "resolution_scale": 0.5},
        {"environment": DAWN, "samples": 64},
    ],
)
def test_one_march_serves_the_bounce_too(both, more):
    shared = both(*PILE, **{"lights": [POINT], **more})
    assert shared.shares_directions and np.any(shared.images["bounce"] > 0.0)
    apart = {"bounce.thickness": 0.4}
    alone = both(*PILE, **{"lights": [POINT], **more}, overrides=apart)
    assert not alone.shares_directions


@pytest.mark.parametrize("combine", ["ambient", "multiply", "report"])
@pytest.mark.parametrize("lights", [(), (POINT,)])
@pytest.mark.parametrize("environment", [None, SKY])
def test_visibility_multiplies_only_what_is_there(both, combine, lights, environment):
    found = both(
        *PILE, lights=lights, environment=environment, method="ssao", combine=combine,
        wanted=("beauty",),
    )  # fmt: skip
    multiplies = bool(lights) if combine != "ambient" else environment is not None
    expected = multiplies or (combine == "multiply" and environment is not None)
    assert found.runs("ssao") == expected


def test_g_buffer_images_run_one_pass(both):
    found = both(*PILE, environment=DAWN, lights=[POINT], wanted=("depth", "normal_ws"))
    assert found.ran == {"gbuffer"}


def test_infinite_radius(both):
    assert both(*PILE, environment=DAWN, radius=math.inf).runs("bounce")
    lone = both((BOX, at(0, 0, 0)), environment=DAWN, radius=math.inf)
    assert lone.is_open
