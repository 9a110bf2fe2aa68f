"""Progressive Monte Carlo: many short draws into float32 sums, with their own error.

The samples of a pixel are split into two halves with independent scrambling. Half the
difference of the halves' means estimates the standard error of the whole mean, without
assuming anything about how low-discrepancy points converge.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.rays.ray_libraries import stream_of
from ssdo_gl.settings.settings import MAX_SPP
from ssdo_gl.user_error import EarlyNote

# Rays in one draw. 2^24 take up to two seconds on two cores of llvmpipe, which has no
# watchdog, and a tenth of that on the slowest graphics processor: watchdogs fire after two
# seconds. With a quarter of it, path tracing drew one bin at a time: on a single core.
RAYS_PER_DRAW = 1 << 24
# Rays of one pixel in one draw. llvmpipe silently ends the loops of a shader after 65535
# turns, all of them counted together; a ray takes some 20 on average and seldom 150.
RAYS_PER_PIXEL = 400
# Tiles are multiples of llvmpipe's 64 x 64 bins, so that none is drawn twice.
TILE_STEP_PX = 64
# Side of the blocks that errors are summed over on the device, which divides a tile's.
# Reading the sums of both halves back instead took 160 ms of 1280 x 720 pixels.
ERROR_BLOCK_PX = 16
# Below this many samples in each half the error estimate itself is mostly noise.
MIN_SAMPLES_TO_STOP = 8
# Samples of each half that decide what neighbouring pixels share where nobody knows how
# many there will be: bits that are shared but not filled would show as a pattern.
USUAL_SAMPLES = 128

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

    @property
    def shared_bits_mask(self) -> int:
        """The mask of leading bits that neighbouring pixels scramble alike."""
        count = self.half_counts()[1]
        return shared_bits_mask(count if self.max_error is None else min(count, USUAL_SAMPLES))

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

    @property
    def round_count(self) -> int:
        """How many rounds there are."""
        return sum(-(-count // self.samples_per_draw) for count in self.half_counts())

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


class Sums:
    """The accumulating textures of both halves, how much each tile holds, and its error.

    Kept from frame to frame: to make and free them takes a tenth of what Python needs for
    a frame of traced shadows.
    """

    def __init__(self, gl: moderngl.Context, size: tuple[int, int], count: int) -> None:
        self.size = size
        self.is_hopeless = False
        self.textures = [[make_texture(gl, size, 4, "f4") for _ in range(count)] for _ in range(2)]
        self.targets = [make_framebuffer(gl, textures) for textures in self.textures]
        self.done: list[dict[Tile, int]] = [{}, {}]
        blocks = -(-size[0] // ERROR_BLOCK_PX), -(-size[1] // ERROR_BLOCK_PX)
        self.blocks = make_texture(gl, blocks, 4, "f4")
        self.block_target = make_framebuffer(gl, [self.blocks])

    def clear(self) -> None:
        """Begin anew."""
        self.done = [{}, {}]
        for target in self.targets:
            target.clear()


def accumulate(
    context: PassContext,
    program: Program,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
    sums: Sums,
    outputs: Sequence[SumOutput],
    schedule: Schedule,
    label: str,
) -> dict[str, Any]:
    """Add up samples in `sums` and write their mean into ``context.target``.

    `program` adds to ``layout(location = i) out vec4``, one for each of `outputs`, also
    for pixels that show no surface, and includes ``lib/random.glsl``. An interrupt
    (Ctrl-C) ends the accumulation early and, once there is a sample, is otherwise
    swallowed: what has converged is written, and the result says so.

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
    sums.clear()
    program.set(uniforms)
    stopped_by = _draw_all(context, program, textures, sums, outputs, schedule, label)
    _resolve(context, sums, outputs)
    tiles = schedule.tiles(sums.size)
    least = min(sum(half.get(tile, 0) for half in sums.done) for tile in tiles)
    errors = {
        output.resource: _standard_error(context, sums, i, output.channels)
        for i, output in enumerate(outputs)
    }
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
    textures: Mapping[str, moderngl.Texture],
    sums: Sums,
    outputs: Sequence[SumOutput],
    schedule: Schedule,
    label: str,
) -> str:
    """Run the rounds; return why they ended."""
    gl, tiles = context.gl, schedule.tiles(sums.size)
    most = total = schedule.round_count * len(tiles)
    step = 0
    try:
        for half, first, count in schedule.rounds():
            stream = {
                "u_stream": stream_of(context.frame.seed, half),
                "u_first_sample": first,
                "u_sample_count": count,
                "u_shared_bits": schedule.shared_bits_mask,
            }
            for tile in tiles:
                target = sums.targets[half]
                draw_fullscreen(gl, program, target, stream, textures, region=tile, adds=True)
                # One draw at a time: a queue of them could not be interrupted.
                gl.finish()
                sums.done[half][tile] = first + count
                step += 1
                if context.progress is not None:
                    context.progress(label, step, total)
            is_due = half == 1 and _is_power_of_two((first + count) // schedule.samples_per_draw)
            is_due &= first + count >= MIN_SAMPLES_TO_STOP
            if schedule.max_error is not None and is_due:
                excess = _largest_error(context, sums, outputs) / schedule.max_error
                if excess <= 1.0:
                    return "max_error"
                if not context.frame.is_live:
                    _say_if_hopeless(sums, schedule, label, 2 * (first + count), excess)
                # Errors fall with the square root of the work; looked at again after as much.
                total = math.ceil(min(most, step * max(2.0, excess**2)))
    except KeyboardInterrupt:
        if not sums.done[0]:
            raise
        return "interrupt"
    return "spp"


def _say_if_hopeless(sums: Sums, schedule: Schedule, label: str, spp: int, excess: float) -> None:
    """Say once that the bound is out of reach of all samples there may be.

    It is where even an error that fell with their number, not with its root, stayed above.
    """
    if sums.is_hopeless or schedule.spp < MAX_SPP or spp * excess <= schedule.spp:
        return
    sums.is_hopeless = True
    bound = 100.0 * (schedule.max_error or 0.0)
    text = (
        f"{label}: {spp} samples per pixel leave a relative standard error of "
        f"{bound * excess:.2g} %; {bound:.3g} % would take about {spp * excess**2:.0e}, "
        f"and it ends at {schedule.spp}"
    )
    warnings.warn(text, EarlyNote, stacklevel=2)


def _is_power_of_two(number: int) -> bool:
    return number > 0 and number & (number - 1) == 0


def _resolve(context: PassContext, sums: Sums, outputs: Sequence[SumOutput]) -> None:
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
        uniforms = {"u_inverse_count": 1.0 / count}
        draw_fullscreen(context.gl, program, context.target, uniforms, textures, region=tile)


def _standard_error(
    context: PassContext, sums: Sums, index: int, channels: int
) -> tuple[float, float] | None:
    """Return the standard error of the mean, absolute and relative, or None if unknown.

    Over all pixels that show a surface. One without a number would leave the whole image
    without an error, and a limit on it without effect: it does not count.
    """
    known = sums.done[0].keys() & sums.done[1].keys()
    if not known:
        return None
    program = context.shaders.fullscreen(
        "passes/accumulate_error.frag",
        {"BLOCK_SIZE": ERROR_BLOCK_PX, "CHANNEL_COUNT": channels},
    )
    textures = {
        "t_sum_a": sums.textures[0][index],
        "t_sum_b": sums.textures[1][index],
        "t_z_vs": context.inputs["z_vs"],
    }
    sums.block_target.clear()
    for tile in known:
        counts = [half[tile] for half in sums.done]
        x, y, width, height = (-(-n // ERROR_BLOCK_PX) for n in tile)
        uniforms = {"u_inverse_counts": [1.0 / count for count in counts]}
        region = x, y, width, height
        draw_fullscreen(context.gl, program, sums.block_target, uniforms, textures, region=region)
    blocks = read_texture(sums.blocks).astype(np.float64)
    largest, squares, means, pixels = np.moveaxis(blocks, -1, 0)
    count = pixels.sum()
    if count == 0:
        return None
    error = float(np.sqrt(np.sum(largest**2 * squares) / (count * channels)) / 2.0)
    mean = float(means.sum() / count)
    return error, error / abs(mean) if mean else 0.0


def _largest_error(context: PassContext, sums: Sums, outputs: Sequence[SumOutput]) -> float:
    pairs = [_standard_error(context, sums, i, o.channels) for i, o in enumerate(outputs)]
    return max((pair[1] for pair in pairs if pair is not None), default=0.0)
