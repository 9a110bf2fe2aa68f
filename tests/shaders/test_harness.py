"""The harness that runs GLSL snippets on arrays must itself be right."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.gpu.shader import ShaderError


@pytest.mark.parametrize("count", [1, 255, 256, 257, 1000])
def test_every_input_meets_its_own_output(gl, shaders, count):
    x = np.arange(count, dtype=np.float32)
    np.testing.assert_array_equal(evaluate(gl, shaders, [], "2.0 * x", {"x": x}), 2 * x[:, None])


@pytest.mark.parametrize("components", [1, 2, 3, 4])
@pytest.mark.parametrize(
    ("dtype", "texture_dtype"), [(np.float32, "f4"), (np.int32, "i4"), (np.uint32, "u4")]
)
def test_all_types_and_widths_pass_unchanged(gl, shaders, components, dtype, texture_dtype):
    # Beyond 2^24, where a detour through float32 would round integers.
    x = (np.arange(7 * components) + 2**30 + 1).astype(dtype).reshape(7, components)
    result = evaluate(gl, shaders, [], "x", {"x": x}, components, output_dtype=texture_dtype)
    assert result.dtype == dtype
    np.testing.assert_array_equal(result, x)


def test_statements_functions_includes_and_uniforms(gl, shaders):
    result = evaluate(
        gl,
        shaders,
        ["lib/constants.glsl"],
        "float y = twice(x.y); return vec2(y + u_offset, step(3.0, PI));",
        {"x": np.array([[0.0, 1.0], [0.0, 2.0]])},
        2,
        functions="uniform float u_offset;\nfloat twice(float a) { return float(FACTOR) * a; }",
        uniforms={"u_offset": 10.0},
        defines={"FACTOR": 2},
    )
    np.testing.assert_array_equal(result, [[12, 1], [14, 1]])


def test_fault_in_the_snippet_is_reported(gl, shaders):
    with pytest.raises(ShaderError, match=r"<snippet>:\d+: .*nonsense"):
        evaluate(gl, shaders, [], "nonsense", {"x": np.ones(1)})


@pytest.mark.parametrize(
    "inputs", [{}, {"x": np.ones(2), "y": np.ones(3)}, {"x": np.ones((2, 5))}, {"x": np.ones(0)}]
)
def test_unusable_inputs_are_refused(gl, shaders, inputs):
    with pytest.raises(ValueError, match="input"):
        evaluate(gl, shaders, [], "1.0", inputs)
