"""Has the driver compile and link flattened shaders, and translates what it says of them."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl

from ssdo_gl.gpu.held_signals import held_signals
from ssdo_gl.gpu.shader_source import FlatSource, ShaderError


def link_stages(gl: moderngl.Context, vertex: FlatSource, fragment: FlatSource) -> moderngl.Program:
    """Return the program of two stages; raises ShaderError in our files and lines."""
    try:
        # It calls Python while it lists the uniforms, and takes an exception there, which
        # Ctrl-C is, for a result: a segmentation fault.
        with held_signals():
            return gl.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
    except moderngl.Error as error:
        stages = {"vertex_shader": vertex, "fragment_shader": fragment}
        raise _fault(str(error), stages) from None


def link_compute(gl: moderngl.Context, source: FlatSource) -> moderngl.ComputeShader:
    """Return a compute shader; raises ShaderError in our files and lines."""
    try:
        with held_signals():
            return gl.compute_shader(source.text)
    except moderngl.Error as error:
        raise _fault(str(error), {"compute_shader": source}) from None


def _fault(log: str, stages: Mapping[str, FlatSource]) -> ShaderError:
    """Return what a driver said of these stages, in our files and lines."""
    for stage, source in stages.items():
        head, found, body = log.partition(f"{stage}\n{'=' * len(stage)}\n")
        if found:
            return ShaderError(source.translate_log(body) or f"{source.name}: {head.strip()}")
    names = " + ".join(source.name for source in stages.values())
    return ShaderError(f"{names}: " + " ".join(log.split()))
