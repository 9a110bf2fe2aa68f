"""Transforms against definitions, in float64."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ssdo_gl import math3d

EXACT = 1e-12  # a few hundred float64 roundings of numbers of order one
directions = arrays(
    np.float64, 3, elements=st.floats(-1.0, 1.0).filter(lambda x: x == 0 or abs(x) > 1e-6)
).filter(lambda v: np.abs(v).max() > 0)


@given(directions)
def test_frames_are_right_handed_rotations_with_that_third_axis(direction):
    frame = math3d.frame_from_z(direction)
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=EXACT)
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=EXACT)
    assert frame[:, 2] == pytest.approx(direction / np.linalg.norm(direction), abs=EXACT)


@pytest.mark.parametrize("size", [1e-200, 1.0, 1e200])
def test_normalized_survives_lengths_whose_squares_leave_float64(size):
    assert math3d.normalized(np.array([3.0, 0.0, 4.0]) * size) == pytest.approx([0.6, 0, 0.8])


@pytest.mark.parametrize("bad", [[0, 0, 0], [np.nan, 1, 0], [np.inf, 0, 0]])
def test_normalized_refuses_what_has_no_direction(bad):
    with pytest.raises(ValueError, match="finite and not zero"):
        math3d.normalized(bad)


def test_the_camera_looks_along_minus_z_with_up_up():
    rotation = math3d.look_rotation([1, 2, 3], [1, 2, -7], [0, 1, 0])
    assert rotation == pytest.approx(np.eye(3), abs=EXACT)


@pytest.mark.parametrize("target", [[0, -1, 0], [0, 1, 0]])
def test_looking_along_up_is_allowed(target):
    rotation = math3d.look_rotation([0, 0, 0], target, [0, 1, 0])
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=EXACT)
    assert rotation @ target == pytest.approx([0, 0, -1], abs=EXACT)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"translate": 3.0}, "translate = 3.0: expected three finite numbers"),
        ({"translate": (1.0, 2.0)}, r"translate = \(1.0, 2.0\): expected three"),
        ({"rotate": "up"}, "rotate = 'up': expected three finite numbers"),
        ({"scale": np.nan}, "scale = nan: expected a finite number, or three"),
        ({"scale": (1.0, 1.0)}, r"scale = \(1.0, 1.0\): expected a finite number, or three"),
    ],
)
def test_a_transform_names_the_argument_that_is_no_good(numbers, message):
    with pytest.raises(ValueError, match=message):
        math3d.transform_matrix(**numbers)


def test_rotations_are_applied_x_first():
    matrix = math3d.rotation_euler([90.0, 90.0, 0.0])
    assert math3d.transform_points(matrix, [0.0, 1.0, 0.0]) == pytest.approx([1, 0, 0], abs=EXACT)


def test_perspective_maps_the_frustum_to_the_cube():
    matrix = math3d.perspective((0.8, 0.45), 0.5, 20.0)
    for z, ndc_z in ((0.5, -1.0), (20.0, 1.0)):
        clip = matrix @ [0.8 * z, 0.45 * z, -z, 1.0]
        assert clip[:3] / clip[3] == pytest.approx([1.0, 1.0, ndc_z], abs=EXACT)


def test_translation_and_scaling_are_column_vector_matrices():
    matrix = math3d.translation([1, 2, 3]) @ math3d.scaling([2, 3, 4])
    assert math3d.transform_points(matrix, [[1, 1, 1]]) == pytest.approx(np.array([[3, 5, 7]]))
