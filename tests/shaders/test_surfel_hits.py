"""What a ray of a surfel met goes through two words and back."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

INCLUDES = ["rays/surfel_hits.glsl"]
COUNT = 1000
# Half a step of what the words keep.
ALBEDO_STEP = {0: 0.5 / 65535.0, 1: 0.5 / 16383.0}
MOST_SLOPE, SLOPE_STEP = 0.05, 0.5 * 0.05 / 63.0
ROUNDING = 1e-7
PACKED = "packed_hit(SurfelHit(surfel, albedo, slope))"


def hits() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    albedo = rng.uniform(-0.1, 1.1, (COUNT, 3))
    albedo[0], albedo[1] = 0.0, 1.0
    slope = rng.uniform(-0.01, 0.06, COUNT)
    slope[:2] = 0.0, MOST_SLOPE
    surfel = rng.integers(0, 65536, COUNT).astype(np.uint32)
    surfel[:3] = 0, 65534, 65535
    return {"surfel": surfel, "albedo": albedo, "slope": slope}


@pytest.mark.parametrize("glossy", [0, 1])
def test_a_hit_comes_back_from_its_words(gl, shaders, glossy):
    given, defines = hits(), {"GLOSSY": glossy}

    def back(part, components, dtype="f4"):
        body = f"unpacked_hit({PACKED}).{part}"
        return evaluate(
            gl, shaders, INCLUDES, body, given, components, output_dtype=dtype, defines=defines
        )

    np.testing.assert_array_equal(back("surfel", 1, "u4")[:, 0], given["surfel"])
    albedo = np.clip(given["albedo"], 0.0, 1.0)
    np.testing.assert_allclose(back("albedo", 3), albedo, atol=ALBEDO_STEP[glossy] + ROUNDING)
    slope = glossy * np.clip(given["slope"], 0.0, MOST_SLOPE)
    np.testing.assert_allclose(back("slope", 1)[:, 0], slope, atol=SLOPE_STEP + ROUNDING)
