"""Shadows of lights of every kind, against float64."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from effects.lit_floor import CAMERA, CARD, FLOOR, LIGHTS, UP, draw, floor_points, power, unshadowed
from oracle import shadows
from passes.pass_harness import box, make_scene, quad

from ssdo_gl.effects.direct import DirectSettings
from ssdo_gl.effects.shadows.shadow_map import ShadowMapSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight


@pytest.mark.parametrize("kind", ["point", "directional"])
def test_low_steps_throw_shadows(gl, shaders, kind):
    """A step three texels of the map high darkens all but a texel of what it should."""
    light = {
        "point": PointLight((-4.0, 2.0, 0.0), (9.0, 9.0, 9.0)),
        "directional": DirectionalLight((0.894427, -0.447214, 0.0), (1.0, 1.0, 1.0)),
    }[kind]
    # A texel is at most 0.02 where the step is: 10 units over 1024, and 2 * 4.5 over 512.
    floor = quad((-5.0, 0.0, 5.0), (10.0, 0.0, 0.0), (0.0, 0.0, -10.0))
    step = box((-1.0, 0.0, -1.0), (0.0, 0.06, 1.0))
    camera = Camera((0.3, 0.8, 0.0), (0.06, 0.0, 0.0), fov_y=20.0)
    scene = make_scene([floor, step], lights=[light], camera=camera)
    frame, images, found = draw(gl, shaders, scene, map_settings=ShadowMapSettings(256))
    points, seen = floor_points(frame, images)
    length = 0.06 * 2.0
    dark = (np.abs(points[:, 1]) < 1e-4) & (points[:, 0] > 0.02) & (points[:, 0] < length - 0.04)
    assert dark.sum() > 200
    assert np.all(found[seen][dark] == 0.0)
    lit = (np.abs(points[:, 1]) < 1e-4) & (points[:, 0] > length + 0.06)
    assert np.all(found[seen][lit] > 0.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("kind", ["point", "spot", "wide spot", "directional"])
def test_hard_shadow_of_a_card(gl, shaders, kind, scale):
    """Where the segment to the light meets the card it is dark, elsewhere fully lit."""
    light = LIGHTS[kind]
    card = tuple(np.asarray(a) * scale for a in CARD)
    factor = {"position": scale, "intensity": scale**2}
    scaled = dataclasses.replace(
        light,
        **{
            n: tuple(np.multiply(getattr(light, n), f))
            for n, f in factor.items()
            if hasattr(light, n)
        },
    )
    floor = dataclasses.replace(FLOOR, positions=FLOOR.positions * scale)
    camera = dataclasses.replace(CAMERA, position=tuple(np.multiply(CAMERA.position, scale)))
    scene = make_scene([floor, quad(*card)], lights=[scaled], camera=camera)
    frame, images, found = draw(gl, shaders, scene, (96, 72), map_settings=ShadowMapSettings(512))
    points, seen = floor_points(frame, images)
    on_floor = np.abs(points[:, 1]) < 1e-3 * scale
    points = points[on_floor] / scale
    plain = unshadowed(light, points) * power(light)[0]
    if kind == "directional":
        ends = points - 100.0 * np.asarray(light.direction)
    else:
        ends = np.broadcast_to(light.position, points.shape)
    dark = shadows.card_blocks(points, ends, *CARD)
    # The edge is blurred over two texels; the widest is the sun's, 20 / 1024 at a slant.
    grown = [np.add(CARD[0], (-d, 0, -d)) for d in (0.06, -0.06)]
    sizes = [np.add(1.0, 2 * d) for d in (0.06, -0.06)]
    outer, inner = (
        shadows.card_blocks(points, ends, corner, (size, 0, 0), (0, 0, size))
        for corner, size in zip(grown, sizes, strict=True)
    )
    result = found[seen][on_floor][:, 0]
    assert inner.sum() > 50
    assert np.all(result[inner] == 0.0)
    np.testing.assert_allclose(result[~outer], plain[~outer], rtol=1e-4, atol=1e-4 * plain.max())
    assert np.all(dark[inner])
    assert np.all(result <= plain * (1.0 + 1e-4) + 1e-5 * plain.max())


# Against the integral over 32 x 32 points of the light, on the floor up to 3 units away.
# The method takes all that stands before a part of the light for one depth and samples
# that with noise: its measured RMS error and bias, with a margin of a third.
PENUMBRA = {1: (0.12, 0.03), 2: (0.052, 0.01), 4: (0.03, 0.005)}


@pytest.mark.parametrize("parts_per_side", PENUMBRA)
def test_penumbra_of_an_edge(gl, shaders, parts_per_side):
    """A half plane above a floor, under a rectangle: from full to none, and where."""
    edge = ((-20.0, 1.0, -20.0), (20.0, 0.0, 0.0), (0.0, 0.0, 40.0))
    light = RectangleLight((-0.6, 2.5, -0.4), (1.2, 0, 0), (0, 0, 0.8), (1.0, 1.0, 1.0))
    camera = Camera((0.3, 0.9, 2.5), (0.3, 0.0, 0.0), fov_y=60.0)
    scene = make_scene([FLOOR, quad(*edge)], lights=[light], camera=camera)
    frame, images, found = draw(
        gl,
        shaders,
        scene,
        settings=DirectSettings(blocker_samples=8, filter_samples=16),
        map_settings=ShadowMapSettings(512, parts_per_side),
    )
    points, seen = floor_points(frame, images)
    on_floor = (np.abs(points[:, 1]) < 1e-3) & (points[:, 2] > -3.0)
    points, result = points[on_floor], found[seen][on_floor][:, 0]
    plain = unshadowed(light, points)
    geometry = (light.corner, light.edge_u, light.edge_v)
    wanted = shadows.rectangle_visibility(points, UP, geometry, [edge])
    partly = (wanted > 0.02) & (wanted < 0.98)
    assert partly.sum() > 300
    error = result / plain - wanted
    rms, bias = PENUMBRA[parts_per_side]
    assert np.sqrt(np.mean(error[partly] ** 2)) < rms
    assert abs(error[partly].mean()) < bias
    # One of the 16 samples of one part may err where a shadow begins or ends.
    assert np.abs(error[wanted > 0.999]).max() < 1.5 / 16.0
    assert np.abs(error[wanted < 0.001]).max() < 1.5 / 16.0


def test_a_body_on_the_floor_is_dark_where_it_touches(gl, shaders):
    """No light leaks in under a box: the floor beside it, away from the light, is black."""
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    camera = Camera((-2.5, 1.5, 0.0), (-0.5, 0.0, 0.0), fov_y=40.0)
    for light in (
        PointLight((3.0, 2.5, 0.1), (5.0, 5.0, 5.0)),
        DirectionalLight((-0.8, -0.6, 0.0), (1.0, 1.0, 1.0)),
        RectangleLight((3.0, 2.4, -0.1), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2), (9.0, 9.0, 9.0)),
    ):
        if isinstance(light, RectangleLight):
            light = dataclasses.replace(light, edge_u=(0, 0, 0.2), edge_v=(0, 0.2, 0))
        scene = make_scene([FLOOR, body], lights=[light], camera=camera)
        frame, images, found = draw(
            gl, shaders, scene, (96, 72), map_settings=ShadowMapSettings(512)
        )
        _, _, plain = draw(gl, shaders, scene, (96, 72), maps=False)
        points, seen = floor_points(frame, images)
        beside = (np.abs(points[:, 1]) < 1e-4) & (np.abs(points[:, 2]) < 0.4)
        beside &= (points[:, 0] < -0.5) & (points[:, 0] > -0.8)
        assert beside.sum() > 100
        assert np.all(plain[seen][beside] > 0.0)
        assert np.all(found[seen][beside] == 0.0)
