"""Runs a GLSL snippet on arrays, so that shader libraries can be tested like functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray
from program_of_text import fullscreen_source

from ssdo_gl.effects.tables.gloss_tables import TABLE_SIZE, reflectance_table
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture

# Row length of the textures that hold inputs and outputs: any size within the 1024 that
# OpenGL 3.3 guarantees would do.
_WIDTH = 256
_GLSL = {  # texture dtype -> sampler prefix, scalar type, vector prefix, NumPy type
    "f4": ("", "float", "vec", np.float32),
    "i4": ("i", "int", "ivec", np.int32),
    "u4": ("u", "uint", "uvec", np.uint32),
}


def unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (..., N) of length 1."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def evaluate(
    gl: moderngl.Context,
    shaders: ShaderLibrary,
    includes: Sequence[str],
    body: str,
    inputs: Mapping[str, Any],
    output_components: int = 1,
    *,
    functions: str = "",
    output_dtype: str = "f4",
    uniforms: Mapping[str, object] | None = None,
    textures: Mapping[str, moderngl.Texture] | None = None,
    defines: Mapping[str, int] | None = None,
) -> NDArray[Any]:
    """Return what `body` gives for each of n inputs, as an (n, output_components) array.

    Parameters
    ----------
    includes : sequence of str
        Shader libraries, e.g. ``["lib/sampling.glsl"]``.
    body : str
        A GLSL expression in the names of `inputs`, or statements that ``return`` it.
    inputs : mapping of str to array_like, shape (n,) or (n, 1..4)
        Each becomes a variable: float32 -> float/vec2.., int32 -> int.., uint32 -> uint...
        Float64 is rounded to float32, int64 to int32.
    output_components : int
        1 to 4.
    functions : str
        GLSL at file scope, after the includes: helpers, uniform declarations.
    output_dtype : str
        ``f4``, ``i4`` or ``u4``.
    """
    arrays = {name: _as_rows(name, value) for name, value in inputs.items()}
    counts = {len(array) for array in arrays.values()}
    if len(counts) != 1:
        raise ValueError(f"inputs of different or no length: {sorted(counts)}")
    count = counts.pop()
    height = max(1, -(-count // _WIDTH))

    _, scalar, vector, numpy_type = _GLSL[output_dtype]
    result_type = scalar if output_components == 1 else f"{vector}{output_components}"
    parameters, declarations, arguments, bound = [], [], [], {}
    for name, array in arrays.items():
        dtype = {"f": "f4", "i": "i4", "u": "u4"}[array.dtype.kind]
        in_prefix, in_scalar, in_vector, _ = _GLSL[dtype]
        width = array.shape[1]
        parameters.append(f"{in_scalar if width == 1 else f'{in_vector}{width}'} {name}")
        declarations.append(f"uniform {in_prefix}sampler2D t_input_{name};")
        arguments.append(f"texelFetch(t_input_{name}, ivec2(gl_FragCoord.xy), 0).{'xyzw'[:width]}")
        # Three channels cannot be read as an image.
        channels = 4 if width == 3 else width
        padded = np.zeros((height * _WIDTH, channels), array.dtype)
        padded[:count, :width] = array
        # Texels past the end repeat the last input: a body need not bear made-up zeros.
        padded[count:, :width] = array[-1:]
        bound[f"t_input_{name}"] = make_texture(gl, (_WIDTH, height), channels, dtype, padded)

    statements = body if "return" in body else f"return {body};"
    source = "\n".join(
        [
            "#version 330 core",
            *(f'#include "{path}"' for path in includes),
            functions,
            *declarations,
            f"layout(location = 0) out {result_type} o_result;",
            f"{result_type} evaluate({', '.join(parameters)})",
            "{",
            statements,
            "}",
            f"void main() {{ o_result = evaluate({', '.join(arguments)}); }}",
        ]
    )
    program = fullscreen_source(shaders, source, defines or {}, name="<snippet>")
    # Three channels cannot be drawn to everywhere; OpenGL 3.3 promises 1, 2 and 4.
    channels = 4 if output_components == 3 else output_components
    output = make_texture(gl, (_WIDTH, height), channels, output_dtype)
    target = make_framebuffer(gl, [output])
    draw_fullscreen(gl, program, target, uniforms or {}, {**bound, **(textures or {})})
    raw = np.frombuffer(output.read(alignment=1), dtype=numpy_type)
    return raw.reshape(-1, channels)[:count, :output_components].copy()


def _as_rows(name: str, value: Any) -> NDArray[Any]:
    array = np.asarray(value)
    array = array[:, None] if array.ndim == 1 else array
    if array.ndim != 2 or not 1 <= array.shape[1] <= 4 or len(array) == 0:
        raise ValueError(f"input {name!r} has shape {np.shape(value)}, not (n,) or (n, 1..4)")
    kinds = {"f": np.float32, "i": np.int32, "b": np.int32, "u": np.uint32}
    return array.astype(kinds[array.dtype.kind])


_table = cache(reflectance_table)


def reflectance_texture(gl: moderngl.Context) -> dict[str, moderngl.Texture]:
    """Return the table that surfaces with GLOSSY look up, by its sampler."""
    size = (TABLE_SIZE, TABLE_SIZE)
    texture = make_texture(gl, size, 3, "f4", _table())
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return {"t_reflectance": texture}
