"""Interreflection between surfels: bounces are summed until nothing is missing."""

from __future__ import annotations

import math
from collections.abc import Iterator

import moderngl
import numpy as np

from ssdo_gl.gpu.texture import make_texture, read_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.surfels.surfel_textures import SURFELS_PER_ROW, drawn, surfel_rows

# Bounces whose growth tells how much light stays in the scene.
PROBED_BOUNCES = 4
# Of more, the last bounces are left out. 64 rays a surfel give a bounce eigenvalues up to
# 1 / 8 off the real axis, on which Chebyshev's iteration grows where more than .992 is kept.
MOST_KEPT = 0.99
# The light that is missing when the iteration ends, relative to all.
TOLERANCE = 1e-4
# A few surfels that see each other in a circle have eigenvalues far off the real axis, on which
# the iteration grows where so much is kept: then light is more than so often the brightest of
# what arrives directly, and in the last third of the iteration grows by more than this. Plain
# bounces never grow. So many leave out light of what is closed and all white alone.
CIRCLES_FROM, SUSPECT, GROWTH = 0.9, 2.0, 1.2
MOST_PLAIN = 100


class Bounces:
    """Adds one bounce to what surfels receive.

    Parameters
    ----------
    context : PassContext
        Of a pass that reads ``surfel_points``.
    hits : Texture
        What their rays meet.
    rays_per_side : int
        Root of the number of these rays.
    glossy : bool
        Whether what they meet may be.
    """

    def __init__(
        self, context: PassContext, hits: moderngl.Texture, rays_per_side: int, glossy: bool
    ) -> None:
        self.gl = context.gl
        self.rows = surfel_rows(context.facts["surfel_points"].count)
        self.program = context.shaders.fullscreen(
            "passes/surface_cache.frag",
            {"SURFEL_RAYS_PER_SIDE": rays_per_side, "GLOSSY": int(glossy)},
        )
        self.program.set({"u_surfel_rows": self.rows})
        self.hits = {"t_surfel_hits": hits}

    def texture(self, value: float) -> moderngl.Texture:
        """Return a texture with a number for each surfel."""
        data = np.full((self.rows, SURFELS_PER_ROW, 4), value, dtype=np.float32)
        return make_texture(self.gl, (SURFELS_PER_ROW, self.rows), 4, "f4", data)

    def share_kept(self) -> float:
        """Return a bound on the share of light that a bounce keeps, on average over bounces.

        One bounce of a light of 1 everywhere keeps no more than the largest albedo; the root
        of what several bounces keep bounds how light dies away, whatever the light.
        """
        last, black = self.texture(1.0), self.texture(0.0)
        for _ in range(PROBED_BOUNCES):
            last = self.step(black, last, black, 1.0)
        return float(min(_most(last) ** (1.0 / PROBED_BOUNCES), MOST_KEPT))

    def grow(self, kept: float, direct: moderngl.Texture, light: moderngl.Texture) -> bool:
        """Return whether Chebyshev's iteration, which made `light` of `direct`, has grown."""
        if kept < CIRCLES_FROM or _most(light) <= SUSPECT * _most(direct):
            return False
        last, last_but_one, black = light, self.texture(0.0), self.texture(0.0)
        factors = tuple(relaxation(kept))
        begun = 2 * len(factors) // 3
        for over in factors[:begun]:
            last_but_one, last = last, self.step(black, last, last_but_one, over)
        before = _most(last)
        for over in factors[begun:]:
            last_but_one, last = last, self.step(black, last, last_but_one, over)
        return not _most(last) <= GROWTH * before < math.inf

    def step(
        self,
        direct: moderngl.Texture,
        last: moderngl.Texture,
        last_but_one: moderngl.Texture,
        over: float,
    ) -> moderngl.Texture:
        """Return one more bounce than `last`, by a factor beyond it, as a new texture."""
        inputs = {"t_surfel_direct": direct, "t_last": last, "t_last_but_one": last_but_one}
        inputs |= self.hits
        return drawn(self.gl, self.rows, self.program, {"u_over": over}, inputs)


def _most(light: moderngl.Texture) -> float:
    return float(np.abs(read_texture(light)[..., :3]).max())


def relaxation(
    kept: float, tolerance: float = TOLERANCE, *, is_plain: bool = False
) -> Iterator[float]:
    """Yield the factor of each step of Chebyshev's iteration until it has converged.

    Parameters
    ----------
    kept : float
        Bound on the spectrum of one bounce, [0, 1).
    tolerance : float
        Of what was missing at first.
    is_plain : bool
        Whether to yield those of plain bounces instead, `MOST_PLAIN` at most.
    """
    if is_plain:
        yield from [1.0] * min(math.ceil(math.log(tolerance) / math.log(kept)), MOST_PLAIN)
        return
    # The error shrinks by `rate` with every step (Golub and Varga 1961), where plain
    # bounces, which shrink it by `kept`, take 900 steps for 0.99 instead of 70.
    rate = kept / (1.0 + math.sqrt(1.0 - kept**2))
    count = 1 if rate == 0.0 else math.ceil(math.log(tolerance / 2.0) / math.log(rate))
    over = 1.0
    for step in range(max(count, 1)):
        yield over
        over = 1.0 / (1.0 - kept**2 * over / (2.0 if step == 0 else 4.0))
    # A plain bounce of what has converged smooths what single surfels are off by.
    yield 1.0
