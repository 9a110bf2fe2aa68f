"""With one channel of light, passes give what each of three equal ones is without."""

from __future__ import annotations

import math

import numpy as np
import pytest
from passes.estimator_cases import corner, inputs_of, picture_frame, random_picture, run_on
from passes.pass_harness import run_pass

from ssdo_gl.passes.bounce import BouncePass, BounceSettings
from ssdo_gl.passes.composite import CompositePass
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass, EdgeAwareFilterSettings
from ssdo_gl.passes.radiance_aov import RadianceAovPass
from ssdo_gl.passes.sender_radiance import SenderRadiancePass

SIZE = (48, 36)
WIDTH, HEIGHT = SIZE
FRAME = picture_frame(SIZE, 0.5)
# A few roundings of float32: the same terms, compiled twice.
ROUNDING = 1e-6
EQUAL = {"rtol": ROUNDING, "atol": 1e-9}


def noise(seed, high=1.0, shape=(HEIGHT, WIDTH)):
    return np.random.default_rng(seed).uniform(0.0, high, (*shape, 1))


def three(grey, companion=1.0):
    """Return (h, w, 4): `grey` as red, green and blue, and one more number."""
    return np.concatenate([grey, grey, grey, np.broadcast_to(companion, grey.shape)], -1)


def test_what_is_sent_on(gl, shaders):
    inputs = {
        "albedo": three(noise(1)),
        "emission": three(noise(2), noise(3) > 0.5),
        "direct_irradiance": three(noise(4, 9.0)),
        "directional_irradiance": three(noise(5)),
    }
    inputs["albedo"][0] = 0.0  # background
    whole, lean = (SenderRadiancePass(is_grey=grey) for grey in (False, True))
    assert whole.settings_key() != lean.settings_key()
    sent, grey = (run_pass(gl, shaders, p, FRAME, inputs)["sender_radiance"] for p in (whole, lean))
    assert grey.shape == (HEIGHT, WIDTH, 1) and grey.max() > 0.5
    np.testing.assert_allclose(np.broadcast_to(grey, (HEIGHT, WIDTH, 3)), sent[..., :3], **EQUAL)


@pytest.mark.parametrize("scale", [1.0, 0.5])
@pytest.mark.parametrize("estimator", ["march", "rgs09"])
@pytest.mark.parametrize("bound", [math.inf, 0.3])
def test_the_bounce(gl, shaders, estimator, scale, bound):
    picture = random_picture(3, SIZE, FRAME.view.tan_half_fov, False)
    settings = BounceSettings(estimator=estimator, radius=0.8, resolution_scale=scale)
    whole, lean = (BouncePass(settings, sender_bound=bound, is_grey=g) for g in (False, True))
    assert whole.settings_key() != lean.settings_key()
    sent = noise(6)
    full = run_on(gl, shaders, whole, FRAME, picture, {"sender_radiance": three(sent)})
    grey = run_on(gl, shaders, lean, FRAME, picture, {"sender_radiance": sent})
    assert grey.shape[-1] == 2 and full[..., :3].max() > 0.05
    np.testing.assert_array_equal(grey[..., 1], full[..., 3])  # z
    for channel in range(3):
        np.testing.assert_allclose(grey[..., 0], full[..., channel], **EQUAL)


@pytest.mark.parametrize("fault", [np.nan, np.inf, -np.inf, -1.0])
def test_a_faulty_sender_sends_nothing(gl, shaders, fault):
    picture = corner(SIZE, FRAME.view.tan_half_fov)
    lean = BouncePass(BounceSettings(radius=0.4), is_grey=True)
    sent = np.ones((HEIGHT, WIDTH, 1))
    sound = run_on(gl, shaders, lean, FRAME, picture, {"sender_radiance": sent})
    sent[HEIGHT // 2 :, 10:30] = fault
    dark = np.where(sent == 1.0, sent, 0.0)
    found = run_on(gl, shaders, lean, FRAME, picture, {"sender_radiance": sent})
    without = run_on(gl, shaders, lean, FRAME, picture, {"sender_radiance": dark})
    np.testing.assert_array_equal(found, without)
    assert found[..., 0].sum() < sound[..., 0].sum()


@pytest.mark.parametrize("name", ["edge", "naive", "none"])
@pytest.mark.parametrize("scale", [1, 2])
def test_the_filter(gl, shaders, name, scale):
    # Depths that vary by less than a pixel's footprint, and some background.
    images = inputs_of(corner(SIZE, FRAME.view.tan_half_fov))
    images["z_vs"] = images["z_vs"] * (noise(7) > 0.1)
    z = images["z_vs"][scale - 1 :: scale, ::scale]
    value = noise(8, 9.0, z.shape[:2])
    value[5, 5:9, 0] = np.nan, -1.0, np.inf, 1e30
    settings = EdgeAwareFilterSettings(filter=name)
    whole, lean = (
        EdgeAwareFilterPass("f", settings, source="v", result="r", holds_z=True, is_grey=grey)
        for grey in (False, True)
    )
    assert whole.settings_key() != lean.settings_key()
    raw = {whole: three(value, z), lean: np.concatenate([value, z], -1)}
    kept = {key: images[key] for key in ("z_vs", "normals_vs")}
    full, grey = (
        run_pass(gl, shaders, item, FRAME, {**kept, "v": raw[item]})["r"] for item in (whole, lean)
    )
    assert grey.shape == (HEIGHT, WIDTH, 1) and np.all(np.isfinite(grey))
    # Neutral irradiance is none, unlike neutral visibility.
    assert np.all(grey[images["z_vs"] == 0.0] == 0.0)
    assert grey.max() > 2.0  # nor is it at most 1
    np.testing.assert_allclose(np.broadcast_to(grey, (HEIGHT, WIDTH, 3)), full[..., :3], **EQUAL)


def test_what_it_adds_to_the_picture(gl, shaders):
    """Surfaces that receive it are drawn in all three channels."""
    images = {
        "z_vs": np.ones((HEIGHT, WIDTH, 1)),
        "albedo": np.concatenate([noise(seed) for seed in (1, 2, 3)] + [noise(4) > 0.5], -1),
        "emission": three(noise(5)),
    }
    value = noise(9, 9.0)
    pictures = []
    for is_grey, bounce in ((False, three(value)), (True, value)):
        inputs = {**images, "b": bounce}
        passes = {
            "beauty": CompositePass(None, bounce="b", bounce_is_grey=is_grey),
            "radiance": RadianceAovPass("b", "radiance", is_grey=is_grey),
        }
        pictures.append(
            {
                name: run_pass(gl, shaders, p, FRAME, {n: inputs[n] for n in p.reads})[name]
                for name, p in passes.items()
            }
        )
        keys = [p.settings_key() for p in passes.values()]
        assert all(("IS_GREY", is_grey) in k or ("BOUNCE_IS_GREY", is_grey) in k for k in keys)
    for name, picture in pictures[0].items():
        assert picture.shape == pictures[1][name].shape == (HEIGHT, WIDTH, 4)
        assert np.ptp(picture[..., :3], axis=-1).max() > 0.5
        np.testing.assert_allclose(pictures[1][name], picture, **EQUAL)
