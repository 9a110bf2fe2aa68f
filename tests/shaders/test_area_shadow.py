"""How the parts of a rectangle are walked through and weighted for its shadow."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.scene.lights import Form

INCLUDES = ["lights/area_shadow.glsl"]
COUNTS = {"BLOCKER_COUNT": 3, "FILTER_COUNT": 4}
DEFINES = {"LIGHT_FORM": int(Form.AREA), "GLOSSY": 0, **COUNTS}


@pytest.mark.parametrize("count", COUNTS.values())
@pytest.mark.parametrize("columns", [1, 2, 4])
def test_a_walk_takes_all_samples_of_each_part(gl, shaders, columns, count):
    """Row by row; and each part belongs to the quarter that it lies in."""
    steps = np.arange(columns * columns * count)
    body = f"""
        PartWalk walk = PartWalk(vec2(0.0), 0, vec3(0.5));
        for (int i = 0; i < step_number; ++i)
            walk = next_sample(walk, {columns}.0, {count});
        vec4 quarter = quarter_of(walk, {columns}.0);
        float quarters = quarter.x + quarter.y + quarter.z + quarter.w;
        float which = dot(quarter, vec4(0.0, 1.0, 2.0, 3.0));
        return vec4(walk.part, float(walk.number), quarters == 1.0 ? which : -1.0);
    """
    found = evaluate(gl, shaders, INCLUDES, body, {"step_number": steps}, 4, defines=DEFINES)
    part, number = np.divmod(steps, count)
    row, column = np.divmod(part, columns)
    upper = [2 * place >= columns for place in (column, row)]
    expected = np.stack([column, row, number, upper[0] + 2 * upper[1]], axis=1)
    np.testing.assert_array_equal(found, expected)


def test_samples_of_a_walk_are_all_of_one_sequence(gl, shaders):
    """Stretches of the parts do not overlap, nor those of the pixels beside: no number twice."""
    columns, count = 2, COUNTS["FILTER_COUNT"]
    body = f"""
        PartWalk walk = PartWalk(vec2(0.0), 0, vec3(0.0));
        for (int i = 0; i < step_number; ++i)
            walk = next_sample(walk, {columns}.0, {count});
        return walk.random;
    """
    steps = np.arange(columns * columns * count)
    found = evaluate(gl, shaders, INCLUDES, body, {"step_number": steps}, 3, defines=DEFINES)
    assert np.all((found >= 0.0) & (found < 1.0))
    assert len(np.unique(np.round(found, 4), axis=0)) == len(steps)


def test_a_part_weighs_what_its_light_brings(gl, shaders):
    """cos cos / d^2 times the square of the height, of parallel planes and tilted ones."""
    rng = np.random.default_rng(5)
    n = 1000
    height = rng.uniform(0.01, 20.0, n)
    axis = np.array([0.0, 0.0, 1.0])
    to_light = np.column_stack([rng.normal(0.0, 2.0, (n, 2)) * height[:, None], height])
    normal = rng.normal(size=(n, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    distance = np.linalg.norm(to_light, axis=1)
    cosines = [np.einsum("ij,ij->i", normal, to_light) / distance, to_light @ axis / distance]
    expected = np.maximum(cosines[0], 0.0) * cosines[1] / distance**2 * height**2
    found = evaluate(gl, shaders, INCLUDES, "part_weight(to_light, normal, height)",
                     {"to_light": to_light, "normal": normal, "height": height},
                     defines=DEFINES)  # fmt: skip
    np.testing.assert_allclose(found[:, 0], expected, rtol=2e-5, atol=1e-6)
