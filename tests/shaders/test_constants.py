"""The constants are the float32 nearest to what their names say."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

CONSTANTS = {
    "PI": np.pi,
    "TWO_PI": 2 * np.pi,
    "HALF_PI": np.pi / 2,
    "INV_PI": 1 / np.pi,
    "INV_TWO_PI": 0.5 / np.pi,
    "FLOAT_EPSILON": np.finfo(np.float32).eps,
    "FLOAT_MAX": np.finfo(np.float32).max,
}


@pytest.mark.parametrize("name", CONSTANTS)
def test_constant_is_the_nearest_float(gl, shaders, name):
    (value,) = evaluate(gl, shaders, ["lib/constants.glsl"], name, {"unused": np.ones(1)})[:, 0]
    assert value == np.float32(CONSTANTS[name])
