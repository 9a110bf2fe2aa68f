"""Progressive Monte Carlo: many short draws into float32 sums, with their own error.

The samples of a pixel are split into two halves with independent scrambling. Half the
difference of the halves' means estimates the standard error of the whole mean, without
assuming anything about how low-discrepancy points converge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.gpu.shader import Program
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.ray_uniforms import stream_of

# Rays in one draw. 2^24 take up to two seconds on two cores of llvmpipe, which has no
# watchdog, and a tenth of that on the slowest graphics processor: watchdogs fire after two
# seconds. With a quarter of it, path tracing drew one bin at a time: on a single core.
RAYS_PER_DRAW = 1 << 24
# Rays of one pixel in one draw. llvmpipe silently ends the loops of a shader after 65535
# turns, all of them counted together; a ray takes some 20 on average and seldom 150.
RAYS_PER_PIXEL = 400
# Tiles are multiples of llvmpipe's 64 x 64 bins, so that none is drawn twice.
TILE_STEP_PX = 64
# Below this many samples in each half the error estimate itself is mostly noise.
MIN_SAMPLES_TO_STOP = 8

Tile = tuple[int, int, int, int]


@dataclass(frozen=True)
class SumOutput:
    """One sum that the accumulating shader adds to.

    Attributes
    ----------
    resource : str
        The resource that its mean becomes.
    channels : int
        How many of its channels the standard error is taken over.
    """

    resource: str
    channels: int


@dataclass(frozen=True)
class Schedule:
    """How the work is cut up. The same for the same input: sums depend on their order.

    Attributes
    ----------
    spp : int
        Samples per pixel, both halves together.
    rays_per_sample : int
        Rough number of rays that a sample costs.
    most_per_draw : int
        Samples of one draw, at most.
    max_error : float or None
        Stop once the standard error, relative to the mean, is below.
    """

    spp: int
    rays_per_sample: int
    most_per_draw: int
    max_error: float | None = None

    @property
    def samples_per_draw(self) -> int:
        """Samples of one half that one draw adds to each pixel of a tile."""
        return max(1, min(self.most_per_draw, RAYS_PER_PIXEL // self.rays_per_sample))

    def half_counts(self) -> tuple[int, int]:
        """Return the samples of each half; with an odd number the first has one more."""
        return self.spp - self.spp // 2, self.spp // 2

    def tiles(self, size: tuple[int, int]) -> list[Tile]:
        """Return (x, y, width, height) of tiles that keep a draw within its rays."""
        pixels = max(1, RAYS_PER_DRAW // (self.samples_per_draw * self.rays_per_sample))
        side = max(TILE_STEP_PX, math.isqrt(pixels) // TILE_STEP_PX * TILE_STEP_PX)
        width, height = size
        return [
            (x, y, min(side, width - x), min(side, height - y))
            for y in range(0, height, side)
            for x in range(0, width, side)
        ]

    def rounds(self) -> Iterator[tuple[int, int, int]]:
        """Yield (half, first sample, samples) such that the halves grow together."""
        counts = self.half_counts()
        for first in range(0, counts[0], self.samples_per_draw):
            for half, count in enumerate(counts):
                if first < count:
                    yield half, first, min(self.samples_per_draw, count - first)


def shared_bits_mask(samples_per_half: int) -> int:
    """Return the mask of leading bits that neighbouring pixels scramble alike.

    As many bits b in each dimension as 4^b samples can fill: then every pixel visits
    every cell, and what the pixels share leaves no pattern in the mean.
    """
    return (1 << (max(samples_per_half, 1).bit_length() - 1) // 2) - 1


class _Sums:
    """The accumulating textures of both halves, and how much each tile holds."""

    def __init__(self, gl: moderngl.Context, size: tuple[int, int], count: int) -> None:
        self.textures = [[make_texture(gl, size, 4, "f4") for _ in range(count)] for _ in range(2)]
        self.targets = [make_framebuffer(gl, textures) for textures in self.textures]
        self.done: list[dict[Tile, int]] = [{}, {}]
        for target in self.targets:
            target.clear()

    def release(self) -> None:
        for target in self.targets:
            target.release()
        for texture in (texture for half in self.textures for texture in half):
            texture.release()


def accumulate(
    context: PassContext,
    program: Program,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
    outputs: Sequence[SumOutput],
    schedule: Schedule,
    label: str,
) -> dict[str, Any]:
    """Add up samples and write their mean into ``context.target``.

    `program` adds to ``layout(location = i) out vec4``, one for each of `outputs`, also
    for pixels that show no surface, and includes ``lib/random.glsl``. An interrupt
    (Ctrl-C) ends the accumulation early and is otherwise swallowed: what has converged
    is written, and the result says so.

    Returns
    -------
    dict
        ``spp`` (least samples of any pixel), ``standard_error`` and
        ``relative_standard_error`` (by resource: root mean square over covered pixels,
        in the resource's unit and relative to its mean, without those that hold a NaN or
        an infinity; None with fewer than two samples), ``partial`` (interrupted),
        ``stopped_by`` ("spp", "max_error" or "interrupt").
    """
    assert context.target is not None
    sums = _Sums(context.gl, context.target.size, len(outputs))
    try:
        program.set(uniforms, textures)
        stopped_by = _draw_all(context, program, sums, outputs, schedule, label)
        _resolve(context, sums, outputs)
        covered = read_texture(context.inputs["z_vs"])[..., 0] > 0.0
        counts = [dict(done) for done in sums.done]
        tiles = schedule.tiles(context.target.size)
        least = min(sum(half.get(tile, 0) for half in counts) for tile in tiles)
        errors = {
            output.resource: _standard_error(sums, i, output.channels, covered)
            for i, output in enumerate(outputs)
        }
    finally:
        sums.release()
    return {
        "spp": least,
        "standard_error": {name: pair and pair[0] for name, pair in errors.items()},
        "relative_standard_error": {name: pair and pair[1] for name, pair in errors.items()},
        "partial": stopped_by == "interrupt",
        "stopped_by": stopped_by,
    }


def _draw_all(
    context: PassContext,
    program: Program,
    sums: _Sums,
    outputs: Sequence[SumOutput],
    schedule: Schedule,
    label: str,
) -> str:
    """Run the rounds; return why they ended."""
    assert context.target is not None
    gl, size = context.gl, context.target.size
    tiles = schedule.tiles(size)
    rounds = list(schedule.rounds())
    total = len(rounds) * len(tiles)
    step = 0
    covered: NDArray[np.bool_] | None = None
    try:
        for half, first, count in rounds:
            program.set(
                {
                    "u_stream": stream_of(context.frame.seed, half),
                    "u_first_sample": first,
                    "u_sample_count": count,
                    "u_shared_bits": shared_bits_mask(schedule.half_counts()[1]),
                }
            )
            for tile in tiles:
                _add(gl, program, sums.targets[half], tile)
                # One draw at a time: a queue of them could not be interrupted.
                gl.finish()
                sums.done[half][tile] = first + count
                step += 1
                if context.progress is not None:
                    context.progress(label, step, total)
            is_due = half == 1 and _is_power_of_two((first + count) // schedule.samples_per_draw)
            if schedule.max_error is not None and is_due and first + count >= MIN_SAMPLES_TO_STOP:
                if covered is None:
                    covered = read_texture(context.inputs["z_vs"])[..., 0] > 0.0
                if _largest_error(sums, outputs, covered) <= schedule.max_error:
                    return "max_error"
    except KeyboardInterrupt:
        return "interrupt"
    return "spp"


def _is_power_of_two(number: int) -> bool:
    return number > 0 and number & (number - 1) == 0


def _add(gl: moderngl.Context, program: Program, target: moderngl.Framebuffer, tile: Tile) -> None:
    gl.enable_only(moderngl.BLEND)
    gl.blend_func = moderngl.ONE, moderngl.ONE
    target.use()
    target.viewport = (0, 0, target.width, target.height)
    target.scissor = tile
    program.check_complete()
    program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
    target.scissor = target.viewport
    gl.enable_only(moderngl.NOTHING)


def _resolve(context: PassContext, sums: _Sums, outputs: Sequence[SumOutput]) -> None:
    """Write the mean of each tile into the pass' target."""
    assert context.target is not None
    program = context.shaders.fullscreen(
        "passes/accumulate_resolve.frag", {"OUTPUT_COUNT": len(outputs)}
    )
    textures = {
        f"t_sum_{name}_{i}": sums.textures[half][i]
        for half, name in enumerate("ab")
        for i in range(len(outputs))
    }
    for tile in sums.done[0]:
        count = sums.done[0][tile] + sums.done[1].get(tile, 0)
        context.target.scissor = tile
        uniforms = {"u_inverse_count": 1.0 / count}
        draw_fullscreen(context.gl, program, context.target, uniforms, textures)
    context.target.scissor = (0, 0, *context.target.size)


def _standard_error(
    sums: _Sums, index: int, channels: int, covered: NDArray[np.bool_]
) -> tuple[float, float] | None:
    """Return the standard error of the mean, absolute and relative, or None if unknown."""
    counts = [np.zeros(covered.shape) for _ in range(2)]
    for count, done in zip(counts, sums.done, strict=True):
        for (x, y, width, height), samples in done.items():
            # Arrays have row 0 at the top, tiles count from the bottom.
            top = len(covered) - y - height
            count[top : top + height, x : x + width] = samples
    known = covered & (counts[0] > 0) & (counts[1] > 0)
    if not known.any():
        return None
    halves = [
        read_texture(sums.textures[half][index])[known][:, :channels].astype(np.float64)
        / counts[half][known][:, None]
        for half in range(2)
    ]
    # One pixel without a number would leave the whole image without an error, and a
    # limit on it without effect.
    finite = np.isfinite(halves).all(axis=(0, 2))
    if not finite.any():
        return None
    halves = [half[finite] for half in halves]
    error = float(np.sqrt(np.mean((halves[0] - halves[1]) ** 2)) / 2.0)
    mean = float(np.mean(halves[0] + halves[1]) / 2.0)
    return error, error / abs(mean) if mean else 0.0


def _largest_error(sums: _Sums, outputs: Sequence[SumOutput], covered: NDArray[np.bool_]) -> float:
    pairs = [_standard_error(sums, i, o.channels, covered) for i, o in enumerate(outputs)]
    return max((pair[1] for pair in pairs if pair is not None), default=0.0)
