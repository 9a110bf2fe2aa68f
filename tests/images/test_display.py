"""Pictures of AOVs: encoded as they should be, and never NaN."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.images.display import picture_of


def test_visibility_is_white_where_open():
    image = np.array([[[1.0], [0.0]]], np.float32)
    np.testing.assert_array_equal(picture_of("visibility", image)[0, :, 0], [255, 0])


def test_display_is_not_encoded_a_second_time():
    image = np.full((1, 1, 4), 0.2, np.float32)
    assert picture_of("display", image)[0, 0].tolist() == [51, 51, 51]


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
