"""Draws what a pass reads into its target."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.program import Program
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.math3d import Region


def draw_inputs(
    context: PassContext,
    program: Program,
    uniforms: Mapping[str, object],
    wiring: Mapping[str, str] | Sequence[str],
    region: Region | None = None,
) -> None:
    """Shade every pixel of the target, or of a region of it, from the inputs.

    Parameters
    ----------
    wiring : mapping or sequence
        The resource behind each sampler; names alone are behind ``t_NAME``.
    """
    assert context.target is not None
    wired = wiring if isinstance(wiring, Mapping) else {f"t_{name}": name for name in wiring}
    textures = {sampler: context.inputs[name] for sampler, name in wired.items()}
    draw_fullscreen(context.gl, program, context.target, uniforms, textures, region=region)
