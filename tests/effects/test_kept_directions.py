"""A bounce that takes over what another pass found blocked is the bounce it would find."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.back_layer import BackFacesPass, DepthLayersPass
from ssdo_gl.effects.bounce import BouncePass, BounceSettings
from ssdo_gl.effects.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.effects.ssao import SsaoPass, SsaoSettings
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.screen_space_settings import kept_names

SIZE = (40, 30)


@pytest.fixture(scope="module")
def scene():
    floor = quad((-3, -1, -8), (6, 0, 0), (0, 0, 7))
    wall = quad((-3, -1, -6), (0, 4, 0), (5, 0, -1))
    boxes = [box((x, -1, -4 - x), (x + 0.5, -0.2, -3.5 - x)) for x in (-1.0, 0.1, 0.9)]
    return make_scene([floor, wall, *boxes])


@pytest.fixture
def world(gl, shaders, scene):
    """A function that runs a pass on the scene's G-buffer and on what it is given."""
    frame = make_frame(scene, SIZE)
    base = run_pass(gl, shaders, GBufferPass(), frame)
    base |= run_pass(gl, shaders, BackFacesPass(), frame)
    base |= run_pass(gl, shaders, DepthLayersPass(), frame, base)
    rng = np.random.default_rng(3)
    base["sender_radiance"] = rng.uniform(0.1, 2.0, (SIZE[1], SIZE[0], 4)).astype(np.float32)

    def run(item, **more):
        known = {**base, **more}
        return run_pass(gl, shaders, item, frame, {name: known[name] for name in item.reads})

    return run


def common(samples, steps):
    return {"samples": samples, "steps": steps, "radius": 1.0, "estimator": "march"}


@pytest.mark.parametrize("samples", [8, 24, 64, 120, 128])
@pytest.mark.parametrize("has_back", [False, True])
def test_bounce_from_kept_directions(world, samples, has_back):
    alike = common(samples, 8)
    settings = BounceSettings(**alike)
    alone = world(BouncePass(settings, has_back_layer=has_back))["bounce_raw"]
    assert np.count_nonzero(alone[..., :3]) > 30
    keepers = (
        SsaoPass(SsaoSettings(**alike), has_back_layer=has_back, keeps=settings.refinements),
        DirectionalPass(
            DirectionalSettings(**alike), has_back_layer=has_back, keeps=settings.refinements
        ),
    )
    for keeper in keepers:
        kept = world(keeper)
        assert set(kept_names(settings)) < set(kept)
        taken = BouncePass(settings, has_back_layer=has_back, takes_directions=True)
        assert "z_layers" not in taken.reads
        found = world(taken, **{name: kept[name] for name in kept_names(settings)})
        np.testing.assert_array_equal(found["bounce_raw"], alone)


@pytest.mark.parametrize("texel", [(0, 0), (39, 0), (3, 2), (17, 11)])
def test_every_texel_can_be_kept(world, texel):
    """One direction of eight is blocked by a given texel, counted from the bottom left."""
    x, y = texel
    kept = {name: np.full((SIZE[1], SIZE[0], 4), -1.0) for name in ("kept_0", "kept_1")}
    # As shaders/screen_space/kept_directions.glsl lays a texel into the bits of a float.
    kept["kept_1"][..., 2] = np.uint32(0x20000000 + x + (y << 14)).view(np.float32)
    settings = BounceSettings(**common(64, 8), hidden_senders=1.0)
    sent = np.full((SIZE[1], SIZE[0], 4), 5.0)
    sent[SIZE[1] - 1 - y, x, :3] = 1.0, 0.5, 0.25
    taken = BouncePass(settings, takes_directions=True)
    found = world(taken, sender_radiance=sent, **kept)["bounce_raw"]
    seen = found[..., 3] > 0.0
    # One product of float32 numbers and a rounding of pi.
    expected = np.broadcast_to(np.pi / 8.0 * np.array([1.0, 0.5, 0.25]), (seen.sum(), 3))
    np.testing.assert_allclose(found[seen][:, :3], expected, rtol=1e-6)
    assert np.all(found[~seen] == 0.0)


def test_keeping_changes_nothing_else(world):
    alike = common(64, 8)
    for cls, settings in ((SsaoPass, SsaoSettings), (DirectionalPass, DirectionalSettings)):
        plain = world(cls(settings(**alike), has_back_layer=True))
        kept = world(cls(settings(**alike), has_back_layer=True, keeps=2))
        for name, image in plain.items():
            np.testing.assert_array_equal(kept[name], image)


def test_open_directions_and_background_are_kept_as_open(world):
    kept = world(SsaoPass(SsaoSettings(**common(64, 8)), keeps=0))
    visibility = kept["visibility_raw"][..., 0]
    numbers = np.concatenate([kept["kept_0"], kept["kept_1"]], axis=-1)
    np.testing.assert_array_equal(np.mean(numbers < 0.0, axis=-1), visibility)
    background = kept["visibility_raw"][..., 1] == 0.0
    assert background.any() and np.all(numbers[background] == -1.0)


@pytest.mark.parametrize(
    "changes", [{}, {"control": "none"}, {"control": "ratio"}, {"estimator": "rgs09"}]
)
def test_where_it_is_known_that_nothing_blocks_nothing_is_looked_for(world, changes):
    settings = DirectionalSettings(**{**common(64, 8), **changes})
    blocked = world(DirectionalPass(settings))["directional_raw"]
    assert blocked[..., 3].min() < 0.9
    known = world(DirectionalPass(settings, is_open=True))["directional_raw"]
    assert np.all(known[..., 3] == 1.0)
