"""How the parts of a rectangle are walked through and weighted for its shadow."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.effects.direct import TURNS, uniforms
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.scene.lights import Form
from ssdo_gl.scene.load import load_scene

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


def test_after_four_frames_the_quarters_of_a_block_have_seen_the_same(gl, shaders):
    """Else penumbrae, too few samples for a pixel, show a grid that frames do not average."""
    y, x = np.divmod(np.arange(16), 4)
    pixels = np.stack([x, y], axis=1)
    view = FrameView((4, 4), np.zeros(3), np.eye(3), (1.0, 1.0), 0.1, 10.0)
    turned = []
    for number in range(TURNS):
        values = uniforms(Frame(view, load_scene("corner"), number))
        sent = {name: values[name] for name in ("u_pattern_offset", "u_pattern_turn")}
        begin = "first_random(pixel, STRETCH)"
        points = evaluate(
            gl, shaders, INCLUDES, begin, {"pixel": pixels}, 3, defines=DEFINES, uniforms=sent
        )
        turned.append(points.reshape(2, 2, 2, 2, 3))
    # Of each quarter: all points of its pixels in all frames.
    quarters = np.stack(turned).transpose(1, 3, 0, 2, 4, 5).reshape(4, 4 * TURNS, 3)
    first = sorted(map(tuple, quarters[0]))
    assert len(set(first)) == 4 * TURNS
    assert all(sorted(map(tuple, quarter)) == first for quarter in quarters[1:])
