"""Measures whether a device runs compute shaders much faster than fragment shaders.

No name tells: accelerators of data centres have few processors that draw (an NVIDIA H100
takes 31 times as long for the same arithmetic), graphics cards have no others.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import Any

import moderngl

# Enough to fill a device and to be measured: a millisecond on the slow half of an H100.
_SIDE, _STEPS = 1024, 64
_RUNS = 5
# Graphics cards lie near 1; what is to be found, above 20.
_FACTOR = 3.0
_VERTEX = """#version 430 core
void main()
{
    vec2 corner = vec2(float((gl_VertexID & 1) << 1), float(gl_VertexID & 2));
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}"""
_WORK = f"""
float work(vec2 p)
{{
    for (int i = 0; i < {_STEPS}; ++i) p = fract(p.yx * 1.7 + sin(p) + 0.1);
    return p.x + p.y;
}}"""
_FRAGMENT = f"""#version 430 core
layout(location = 0) out float o_value;{_WORK}
void main() {{ o_value = work(gl_FragCoord.xy); }}"""
_COMPUTE = f"""#version 430 core
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) writeonly uniform image2D o_value;{_WORK}
void main()
{{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(o_value, p, vec4(work(vec2(p) + 0.5)));
}}"""


def computes_faster(gl: moderngl.Context) -> bool:
    """Return whether full-screen work should run in compute shaders; takes milliseconds."""
    if gl.version_code < 450:
        return False
    texture = gl.texture((_SIDE, _SIDE), 1, dtype="f4")
    target = gl.framebuffer([texture])
    program = gl.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
    triangle = gl.vertex_array(program, [])
    compute = gl.compute_shader(_COMPUTE)
    gl.enable_only(moderngl.NOTHING)
    target.use()
    texture.bind_to_image(0, read=False, write=True)
    drawn = _milliseconds(gl, lambda: triangle.render(moderngl.TRIANGLES, vertices=3))
    computed = _milliseconds(gl, lambda: compute.run(_SIDE // 8, _SIDE // 8))
    gl.memory_barrier()
    gl.detect_framebuffer(0).use()
    for item in (triangle, program, compute, target, texture):
        item.release()
    return drawn > _FACTOR * computed


def _milliseconds(gl: moderngl.Context, work: Callable[[], object]) -> float:
    query: Any = gl.query(time=True)
    times: list[float] = []
    for _ in range(_RUNS):
        with query:
            work()
        times.append(query.elapsed * 1e-6)
    # The first runs hold the driver's own compiling, and the clock's rise from idle.
    return statistics.median(times[1:])
