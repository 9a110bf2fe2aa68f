"""Pictures of AOVs: encoded as they should be, and never NaN."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.images.display import picture_of


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
