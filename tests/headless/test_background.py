"""What pictures and arrays hold where no surface is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scene_text import body, camera, constant_sky

import ssdo_gl
from ssdo_gl.cli import main
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.scene.defaults.default_light import BACKDROP
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings.fields import SettingError

SPHERE = camera([0, 0, 4], [0, 0, 0], exposure=1.0) + constant_sky(0.2, 0.2, 0.2)
SPHERE += body("sphere", radius=1)
SIZE = "48x27"


@pytest.fixture
def sphere(tmp_path: Path) -> Path:
    path = tmp_path / "s.toml"
    path.write_text(SPHERE)
    return path


def picture(scene: Path, *flags: str) -> np.ndarray:
    out = scene.with_suffix(".png")
    assert main([str(scene), "--snapshot", str(out), "--size", SIZE, "--quiet", *flags]) == 0
    return np.asarray(Image.open(out))


@pytest.mark.parametrize("method", ["bounce", "reference-gi"])
def test_a_transparent_picture_is_the_opaque_one_over_nothing(sphere: Path, method: str) -> None:
    flags = ("--method", method, *(("--spp", "4") if method == "reference-gi" else ()))
    opaque = picture(sphere, *flags).astype(float)
    clear = picture(sphere, *flags, "--background", "transparent").astype(float)
    assert opaque.shape[2] == 3 and clear.shape[2] == 4
    alpha = clear[..., 3]
    assert {0.0, 255.0} < set(np.unique(alpha))
    # Edges of four frames are a quarter, a half, three quarters there.
    assert set(np.unique(alpha)) <= {0.0, 64.0, 128.0, 191.0, 255.0}
    np.testing.assert_array_equal(clear[alpha == 255.0, :3], opaque[alpha == 255.0])
    assert (clear[alpha == 0.0] == 0.0).all()


def test_a_colour_is_shown_as_it_is_named(sphere: Path) -> None:
    shown = picture(sphere, "--background", "#ff8000")
    assert shown[0, 0].tolist() == [255, 128, 0]
    # The sphere stays as it is: it is lit by the environment, seen or not.
    np.testing.assert_array_equal(shown[13, 24], picture(sphere)[13, 24])
    assert picture(sphere, "--background", "environment")[0, 0].tolist() == (
        picture(sphere)[0, 0].tolist()
    )


def test_arrays_hold_what_is_shown_before_exposure(sphere: Path) -> None:
    clear = ssdo_gl.render(str(sphere), size=(48, 27), background="transparent")
    assert clear[0, 0].tolist() == [0.0, 0.0, 0.0, 0.0]
    white = ssdo_gl.render(str(sphere), size=(48, 27), background="white")
    # At 1 EV, a radiance of one half is white.
    assert white[0, 0].tolist() == pytest.approx([0.5, 0.5, 0.5, 0.0])
    seen = ssdo_gl.render(str(sphere), size=(48, 27))
    assert seen[0, 0].tolist() == pytest.approx([0.2, 0.2, 0.2, 0.0])
    np.testing.assert_array_equal(seen[13, 24], clear[13, 24])


def test_a_scene_may_ask_for_it(sphere: Path) -> None:
    sphere.write_text(f'{SPHERE}\n[render]\nbackground = "black"\n')
    assert picture(sphere)[0, 0].tolist() == [0, 0, 0]
    assert picture(sphere, "--background", "white")[0, 0].tolist() == [255, 255, 255]


def test_soft_boxes_are_not_seen_behind_a_model(sphere: Path) -> None:
    scene = load_scene(sphere, light="studio")
    assert scene.backdrop == BACKDROP
    white = ssdo_gl.render(scene, size=(48, 27), background="white")
    assert white[0, 0].tolist() == pytest.approx([0.5, 0.5, 0.5, 0.0])
    seen = ssdo_gl.render(scene, size=(48, 27))
    assert seen[0, 0].tolist() == pytest.approx([*BACKDROP, 0.0])
    shown = ssdo_gl.render(scene, size=(48, 27), aov="display")
    # At 1 EV; sRGB of 0.56 is 0.773.
    assert shown[0, 0, :3] == pytest.approx(0.773, abs=0.004)


@pytest.mark.parametrize("text", ["#ff88", "orange", "", "#gggggg"])
def test_other_words_are_refused(text: str) -> None:
    with pytest.raises(SettingError, match=r"one of environment, transparent, .*, or #rrggbb"):
        settings_for({}, {"background": text})
