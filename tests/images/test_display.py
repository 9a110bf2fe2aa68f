"""Pictures: AOVs encoded as they should be, light averaged, exposure measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ssdo_gl.images.average import ImageAverage
from ssdo_gl.images.display import picture_of
from ssdo_gl.images.metering import measured_exposure


def test_visibility_is_white_where_open():
    image = np.array([[[1.0], [0.0]]], np.float32)
    np.testing.assert_array_equal(picture_of("visibility", image)[0, :, 0], [255, 0])


def test_display_is_not_encoded_a_second_time():
    image = np.array([[[0.2, 0.2, 0.2, 1.0]]], np.float32)
    assert picture_of("display", image)[0, 0].tolist() == [51, 51, 51]
    image[..., 3] = 0.4
    assert picture_of("display", image)[0, 0].tolist() == [51, 51, 51, 102]


def test_depth_is_bright_near_and_black_where_nothing_is():
    image = np.array([[[1.0], [3.0], [0.0]]], np.float32)
    pixels = picture_of("depth", image)[0, :, 0].tolist()
    assert pixels == [255, 26, 0]


def test_normals_map_to_the_unit_cube():
    image = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]], np.float32)
    assert picture_of("normal_ws", image)[0].tolist() == [[128, 128, 255], [0, 0, 0]]


@pytest.mark.parametrize("name", ["beauty", "depth", "normal_ws", "position_ws"])
@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf])
def test_poison_does_not_reach_other_pixels(name, poison):
    image = np.ones((2, 2, 3), np.float32)
    image[0, 0] = poison
    assert picture_of(name, image).shape == (2, 2, 3)


def test_a_gradient_is_dithered_to_its_mean_and_whole_steps_stay():
    # 32 x 32 pixels a quarter of a step above 100: without dither all of them are 100.
    image = np.full((32, 32, 4), 100.25 / 255.0, np.float32)
    pixels = picture_of("display", image)[:, :, 0]
    assert set(np.unique(pixels)) == {100, 101}
    # Means of 8 x 8 pixels are within a twelfth of a step: no patch of noise stands out.
    patches = pixels.reshape(4, 8, 4, 8).mean(axis=(1, 3))
    np.testing.assert_allclose(patches, 100.25, atol=1.0 / 12.0)
    levels = np.arange(256, dtype=np.float32)[None, :, None] / np.float32(255.0)
    whole = picture_of("display", np.broadcast_to(levels, (64, 256, 3)))
    np.testing.assert_array_equal(whole[:, :, 0], np.broadcast_to(np.arange(256), (64, 256)))


def test_data_is_not_dithered():
    image = np.broadcast_to(np.linspace(1.0, 2.0, 64, dtype=np.float32)[None, :, None], (8, 64, 1))
    pixels = picture_of("depth", image)
    assert (pixels == pixels[:1]).all()


def of(value, name):
    image = np.full((2, 3, 4), value, np.float32)
    image[..., 3] = 1.0
    return {name: image}


def test_linear_images_average_as_they_are():
    average = ImageAverage()
    for value in (1.0, 2.0, 6.0):
        average.add(of(value, "beauty"))
    assert average.images()["beauty"][..., :3] == pytest.approx(3.0)
    assert average.images()["beauty"].dtype == np.float32


def test_black_and_white_make_the_code_of_half_the_light():
    average = ImageAverage()
    average.add(of(0.0, "display"))
    average.add(of(1.0, "display"))
    # sRGB code of 0.5 (IEC 61966-2-1): 1.055 * 0.5^(1/2.4) - 0.055 = 0.7354.
    assert average.images()["display"][..., :3] == pytest.approx(0.7354, abs=1e-4)
    assert (average.images()["display"][..., 3] == 1.0).all()


def test_what_is_transparent_does_not_darken_what_is_not():
    average = ImageAverage()
    clear = {"display": np.zeros((2, 3, 4), np.float32)}
    for images in (of(0.5, "display"), clear, clear, clear):
        average.add(images)
    assert average.images()["display"][..., :3] == pytest.approx(0.5, abs=1e-6)
    assert average.images()["display"][..., 3] == pytest.approx(0.25)


def test_a_single_frame_passes_unchanged():
    average = ImageAverage()
    average.add(of(0.3, "display"))
    assert np.array_equal(average.images()["display"], of(0.3, "display")["display"])


def picture(*greys: float) -> NDArray[np.float32]:
    """Return a picture of equal shares of grey, covered everywhere."""
    image = np.ones((4, len(greys), 4), np.float32)
    image[..., :3] = np.asarray(greys, np.float32)[None, :, None]
    return image


@pytest.mark.parametrize("level", [1e-6, 0.01, 0.35, 1.0, 1e6])
def test_an_even_grey_comes_to_its_target(level: float) -> None:
    # Rounded to a tenth of an EV.
    expected = np.log2(0.35 / level)
    assert measured_exposure(picture(level)) == pytest.approx(expected, abs=0.051)


@given(st.floats(-20.0, 20.0))
def test_it_undoes_the_strength_of_the_light(stops: float) -> None:
    image = picture(0.05, 0.1, 0.4, 0.5)
    brighter = image * np.float32(2.0**stops)
    brighter[..., 3] = 1.0
    change = measured_exposure(image) - measured_exposure(brighter)
    assert change == pytest.approx(stops, abs=0.11)


def test_highlights_keep_their_shapes() -> None:
    # A tenth of the picture is 100 times as bright as the rest: it must come to 1.
    exposure = measured_exposure(picture(*[0.01] * 9, 1.0))
    assert 2.0**exposure == pytest.approx(1.0, rel=0.05)


def test_what_is_black_or_not_there_says_nothing() -> None:
    assert measured_exposure(picture(0.0)) == 0.0
    behind = picture(5.0)
    behind[..., 3] = 0.0
    assert measured_exposure(behind) == 0.0
    poisoned = picture(0.35, 0.35)
    poisoned[0, 0, 0] = np.nan
    assert measured_exposure(poisoned) == 0.0


def test_within_its_slack_exposure_is_left_alone() -> None:
    # 0.35 / 5: 2.3 stops below the target, of which 1.5 are granted.
    assert measured_exposure(picture(0.35 / 5), slack=1.5) == pytest.approx(0.8)
    assert measured_exposure(picture(0.35 / 2), slack=1.5) == 0.0
    assert measured_exposure(picture(0.9), slack=1.5) == 0.0
    # However dark a thing is, the grey of the ground under it is not to become white.
    assert measured_exposure(picture(1e-3), slack=1.5, most=1.0) == 1.0
    # White-out is not.
    assert measured_exposure(picture(2.0), slack=3.0) == pytest.approx(-1.0)
