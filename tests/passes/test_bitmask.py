"""The bitmask against a march: many slices see what many directions see."""

from __future__ import annotations

import numpy as np
import pytest
from passes.estimator_cases import (
    ball_on_floor,
    corner,
    picture_frame,
    run_visibility,
)

from ssdo_gl.effects.ssao import SsaoSettings

SIZE = (64, 40)
TAN_Y = 0.25
# Both are converged to this, relative to the mean; and, in the RMS, in each block of 4 x 4
# pixels, whose 16 sets of samples complete each other.
CLAIM = 0.005


@pytest.mark.parametrize("make", [corner, ball_on_floor])
@pytest.mark.parametrize("radius, thickness", [(0.4, np.inf), (1.0, 0.3)])
def test_converged_bitmask_is_a_brute_force_march(gl, shaders, make, radius, thickness):
    """Over the same depths, fronts and backs, 128 slices are worth 512 directions."""
    frame = picture_frame(SIZE, TAN_Y)
    picture = make(SIZE, frame.view.tan_half_fov)
    # Steps as points: what a step stands for beyond itself differs.
    common = {
        "radius": radius,
        "thickness": thickness,
        "step_growth": 0.0,
        "front_slack": 0.0,
        "back_slack": 0.0,
    }
    march = SsaoSettings(estimator="march", samples=512 * 96, steps=96, **common)
    mask = SsaoSettings(estimator="bitmask", samples=128 * 2 * 64, steps=64, **common)
    expected = run_visibility(gl, shaders, picture, march, frame)
    gap = run_visibility(gl, shaders, picture, mask, frame) - expected
    assert expected.mean() < 0.97
    assert abs(gap.mean()) < CLAIM * expected.mean()
    blocks = gap.reshape(SIZE[1] // 4, 4, SIZE[0] // 4, 4).mean((1, 3))
    assert np.sqrt((blocks**2).mean()) < CLAIM
