"""Variants that leave out what a scene lacks give what the whole pass gives."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.ssao import ConstantVisibilityPass
from ssdo_gl.passes.composite import CompositePass
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms

SIZE = (24, 18)
WIDTH, HEIGHT = SIZE


@pytest.fixture
def frame():
    return make_frame(make_scene([quad((-1, -1, -3), (2, 0, -1), (0, 1.5, 0))]), SIZE)


@pytest.fixture
def base(gl, shaders, frame):
    """The G-buffer of a sheet that leaves some background."""
    images = run_pass(gl, shaders, GBufferPass(), frame)
    assert 0.1 < np.mean(images["z_vs"] > 0.0) < 0.9
    return images


def noise(seed, channels, high=1.0):
    return np.random.default_rng(seed).uniform(0.0, high, (HEIGHT, WIDTH, channels))


def test_constant_visibility_is_open_and_depends_on_nothing(gl, shaders, frame):
    item = ConstantVisibilityPass()
    one = run_pass(gl, shaders, item, frame)["visibility"]
    assert one.shape == (HEIGHT, WIDTH, 1) and np.all(one == 1.0)
    assert item.reads == () and item.depends_on == ()


def test_without_emission_nothing_is_added(gl, shaders, frame, base):
    inputs = {**base, "emission": np.zeros((HEIGHT, WIDTH, 4)), "e": noise(1, 4)}
    whole, lean = (CompositePass("none", ["e"], emitted) for emitted in (["emission"], []))
    assert "emission" not in lean.reads and whole.settings_key() != lean.settings_key()
    pictures = [
        run_pass(gl, shaders, item, frame, {n: inputs[n] for n in item.reads})["beauty"]
        for item in (whole, lean)
    ]
    np.testing.assert_array_equal(*pictures)
    assert pictures[0][..., :3].max() > 0.0


def test_senders_without_emission_of_their_own(gl, shaders, frame, base):
    lamps = noise(2, 4)
    lamps[..., 3] = 0.0  # delivered by lights
    inputs = {**base, "emission": lamps, "direct_irradiance": noise(3, 4)}
    whole, lean = (
        SenderRadiancePass(SenderTerms(("direct_irradiance",), emitted))
        for emitted in (("emission",), ())
    )
    assert "emission" not in lean.reads and whole.settings_key() != lean.settings_key()
    sent = [
        run_pass(gl, shaders, item, frame, {n: inputs[n] for n in item.reads})["sender_radiance"]
        for item in (whole, lean)
    ]
    np.testing.assert_array_equal(*sent)
    assert sent[0][..., :3].max() > 0.0
