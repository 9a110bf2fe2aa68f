"""What passes share that make their textures themselves and keep them from frame to frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

import moderngl

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import drawing_into
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.math3d import Region

Facts = TypeVar("Facts")


def textures_of(context: PassContext, reads: Iterable[str]) -> dict[str, moderngl.Texture]:
    """Return the textures of ``t_<name>``, to be bound with every draw.

    Between two draws, or two slices of one, a window may show its panel, which binds others.
    """
    return {f"t_{name}": context.inputs[name] for name in reads}


def facts_of(context: PassContext, name: str, kind: type[Facts]) -> Facts | None:
    """Return the facts of what a live pass made last time of `name`; None: nothing it knows."""
    facts = context.last[name].facts if name in context.last else None
    return facts if isinstance(facts, kind) else None


def fill(
    context: PassContext,
    made: Sequence[moderngl.Texture],
    shader: str,
    defines: Mapping[str, int],
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
    region: Region | None = None,
) -> None:
    """Draw into the textures `made`, or a region of them, by a fragment shader."""
    program = context.shaders.fullscreen(shader, defines)
    with drawing_into(context.gl, *made) as target:
        draw_fullscreen(context.gl, program, target, uniforms, textures, region=region)
