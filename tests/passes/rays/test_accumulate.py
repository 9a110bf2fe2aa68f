"""Sums of samples: how they are cut up, and the error that they state of themselves."""

from __future__ import annotations

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from passes.pass_harness import make_frame, make_scene
from program_of_text import fullscreen_source

from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.rays import accumulate as module
from ssdo_gl.passes.rays.accumulate import (
    USUAL_SAMPLES,
    Schedule,
    SumOutput,
    Sums,
    accumulate,
    shared_bits_mask,
    stream_of,
)

# Both halves bring what they were told to.
KNOWN_HALVES = """#version 330 core
#include "lib/random.glsl"
uniform sampler2D t_half_a;
uniform sampler2D t_half_b;
uniform uint u_stream_a;
layout(location = 0) out vec4 o_sum;
void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(t_half_a, texel, 0);
    vec4 b = texelFetch(t_half_b, texel, 0);
    o_sum = float(u_sample_count) * (u_stream == u_stream_a ? a : b);
}
"""
# Sums of 256 float32 in a block: some 30 roundings that add up at random.
TOLERANCE = 2e-6


def stated(gl, shaders, halves, depth, channels, spp=4):
    """Return the statistics of known means of both halves, (height, width, 4) each."""
    height, width = depth.shape[:2]
    images = {"half_a": halves[0], "half_b": halves[1], "z_vs": depth}
    textures = {name: texture_from_image(gl, image) for name, image in images.items()}
    result = make_texture(gl, (width, height), 4, "f4")
    target = make_framebuffer(gl, [result])
    frame = make_frame(make_scene(), (width, height))
    context = PassContext(gl, shaders, None, frame, {"z_vs": textures["z_vs"]}, target)
    sums = Sums(gl, (width, height), 1)
    # Twice: nothing of a frame before may be left in them.
    for _ in range(2):
        statistics = accumulate(
            context,
            fullscreen_source(shaders, KNOWN_HALVES),
            {"u_stream_a": stream_of(frame.seed, 0)},
            {f"t_{name}": textures[name] for name in ("half_a", "half_b")},
            sums,
            [SumOutput("mean", channels)],
            Schedule(spp, 1, 1),
            "known halves",
        )
    mean = read_texture(result)
    for item in (target, result, *textures.values()):
        item.release()
    return statistics, mean


def random_halves(shape, seed):
    rng = np.random.default_rng(seed)
    halves = rng.uniform(0.0, 4.0, (2, *shape, 4)).astype(np.float32)
    depth = (rng.random((*shape, 1)) < 0.7).astype(np.float32)
    return halves, depth


@pytest.mark.parametrize("scale", [1.0, 1e-25, 1e25])
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("shape", [(1, 1), (16, 33), (50, 150)])
def test_the_error_is_half_the_distance_of_the_halves(
    gl, shaders, monkeypatch, shape, channels, scale
):
    """Whatever the unit of light, and whatever tiles the frame is cut into."""
    monkeypatch.setattr(module, "RAYS_PER_DRAW", 64 * 64)
    halves, depth = random_halves(shape, 3)
    depth[0, 0] = 1.0
    halves *= np.float32(scale)
    statistics, mean = stated(gl, shaders, halves, depth, channels)
    np.testing.assert_allclose(mean, halves.mean(axis=0), rtol=1e-6)
    seen = halves[:, depth[..., 0] > 0.0][..., :channels].astype(np.float64)
    error = np.sqrt(np.mean((seen[0] - seen[1]) ** 2)) / 2.0
    assert statistics["standard_error"]["mean"] == pytest.approx(error, rel=TOLERANCE)
    relative = statistics["relative_standard_error"]["mean"]
    assert relative == pytest.approx(error / seen.mean(), rel=TOLERANCE)


@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_does_not_count(gl, shaders, poison):
    halves, depth = random_halves((20, 20), 5)
    depth[2, 3] = 1.0
    halves[1, 2, 3, 1] = poison
    depth_without = depth.copy()
    depth_without[2, 3] = 0.0
    found, wanted = (stated(gl, shaders, halves, d, 3)[0] for d in (depth, depth_without))
    assert found["standard_error"] == wanted["standard_error"]
    # In a channel that nobody asks for, it does no harm.
    assert stated(gl, shaders, halves, depth, 1)[0] != wanted


def test_nothing_is_stated_of_nothing(gl, shaders):
    halves, depth = random_halves((20, 20), 6)
    empty = stated(gl, shaders, halves, np.zeros_like(depth), 3)[0]
    assert empty["standard_error"] == {"mean": None}
    # One half alone has nothing to be compared with.
    assert stated(gl, shaders, halves, depth, 3, spp=1)[0]["standard_error"] == {"mean": None}
    same = stated(gl, shaders, halves[[0, 0]], depth, 3)[0]
    assert same["standard_error"] == {"mean": 0.0}
    assert same["relative_standard_error"] == {"mean": 0.0}


@pytest.mark.parametrize("spp", [1, 2, 3, 16, 17, 255, 256, 1000])
@pytest.mark.parametrize("most_per_draw", [1, 8, 32])
def test_rounds_are_counted_without_making_them(spp: int, most_per_draw: int) -> None:
    schedule = Schedule(spp, rays_per_sample=2, most_per_draw=most_per_draw)
    rounds = list(schedule.rounds())
    assert schedule.round_count == len(rounds)
    assert sum(count for _, _, count in rounds) == spp


def test_neighbours_share_what_is_surely_filled() -> None:
    """A run with a bound may end after any number: what it shares must not depend on more."""
    for spp in (16, 64, 256):
        fixed, bounded = (Schedule(spp, 1, 8, bound).shared_bits_mask for bound in (None, 0.01))
        assert fixed == bounded == shared_bits_mask(spp // 2)
    assert Schedule(1 << 20, 1, 8, 0.01).shared_bits_mask == shared_bits_mask(USUAL_SAMPLES)
    assert Schedule(1 << 20, 1, 8).shared_bits_mask == shared_bits_mask(1 << 19)
