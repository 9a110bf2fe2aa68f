"""Turns the two stages of a G-buffer into a compute shader that shades visible triangles.

Accelerators of data centres rasterize with few of their processors, and each byte of a target
takes its time there. So only numbers of triangles are rasterized, and this shader does the rest
where all processors work: for each pixel it runs the vertex shader at the corners of its triangle,
meets the triangle with the ray through the pixel, interpolates and runs the fragment shader. After
Burns and Hunt, "The Visibility Buffer" (JCGT 2013). No OpenGL here.
"""

from __future__ import annotations

import re

from ssdo_gl.gpu.compute.translation import (
    ENTRY,
    HEAD,
    ORIGIN,
    OUTPUT,
    OUTSIDE,
    image_lines,
    store_lines,
)
from ssdo_gl.gpu.instance_attributes import INSTANCE_ATTRIBUTES, INSTANCE_FLOATS
from ssdo_gl.gpu.shader_source import FlatSource, strip_comments

# Storage buffers: corners of triangles, instances, and one for each stream of a mesh.
INDICES, INSTANCES = 0, 1
STREAMS = {
    "a_position_os": 2,
    "a_normal_face_os": 3,
    "a_normal_os": 4,
    "a_tangent_os": 5,
    "a_uv": 6,
    "a_second_uv": 7,
    "a_color": 8,
}
# Made uniforms: the texture of numbers, their complements; the first of this draw, how many
# there are and how many to an instance; whether pixels without a triangle are this draw's to clear.
IDS, TRIANGLES, CLEARS = "compute_ids", "compute_triangles", "compute_clears"

_VARYING = re.compile(r"^\s*(flat\s+)?(in|out)\s+(\w+)\s+(\w+)\s*;")
# Which of a surface's coordinates an image takes: their steps to the next pixels have names, too.
_PLACE = re.compile(r"^\s*#define\s+(\w+_UV)\s+(v_\w+)\s*$")
_LOOKUP = re.compile(r"\btexture\s*\(\s*(\w+)\s*,\s*(\w+_UV)\s*\)")
_DERIVATIVE = re.compile(r"\bdFd([xy])\s*\(\s*(\w+)\s*\)")
_HEAD = f"""
layout(std430, binding = {INDICES}) readonly buffer compute_index_buffer {{
    uint compute_index[];
}};
layout(std430, binding = {INSTANCES}) readonly buffer compute_instance_buffer {{
    float compute_instance[];
}};
uniform usampler2D {IDS};
uniform uvec3 {TRIANGLES};
uniform int {CLEARS};
vec4 compute_clip;"""
# What is known of the triangle: its corners, twice its area as a vector, and the ray's start and
# direction by depth. Where the ray lies in its plane any point will do, between the corners.
_TAIL = """vec3 compute_corners[3];
vec3 compute_normal;
vec3 compute_met(vec2 uv)
{
    vec3 start = position_vs_at(uv, 0.0);
    vec3 ray = position_vs_at(uv, 1.0) - start;
    float slope = dot(compute_normal, ray);
    float depth = dot(compute_normal, compute_corners[0] - start) / slope;
    vec3 depths = -vec3(compute_corners[0].z, compute_corners[1].z, compute_corners[2].z);
    float low = min(depths.x, min(depths.y, depths.z));
    float high = max(depths.x, max(depths.y, depths.z));
    return start + ray * (slope != 0.0 ? clamp(depth, low, high) : 0.5 * (low + high));
}
vec3 compute_weights(vec3 p)
{
    vec3 e = compute_corners[1] - compute_corners[0];
    vec3 f = compute_corners[2] - compute_corners[0];
    vec3 q = p - compute_corners[0];
    vec3 n = compute_normal / max(dot(compute_normal, compute_normal), 1e-37);
    float v = dot(cross(q, f), n);
    float w = dot(cross(e, q), n);
    return vec3(1.0 - v - w, v, w);
}"""
# Pixels of an invocation along each side: most of them only find that others are theirs to draw.
PIXELS = 2
_MAIN = """void compute_shade(ivec2 pixel)
{{
    if ({outside}) return;
    uint key = texelFetch({ids}, pixel, 0).x;
    bool is_open = key == 0u && {clears} != 0;
{zeros}
    if (!is_open) {{
        uint local = ~key - {triangles}.x;
        if (key == 0u || local >= {triangles}.y) return;
        uint compute_row = local / {triangles}.z * {floats}u;
{instances}
        uint corner = 3u * (local % {triangles}.z);
        for (int k = 0; k < 3; ++k) {{
            uint vertex = compute_index[corner + uint(k)];
{streams}
            compute_vertex();
            compute_corners[k] = instance_position_vs();
{corners}
        }}
        compute_normal = cross(compute_corners[1] - compute_corners[0],
                               compute_corners[2] - compute_corners[0]);
        vec2 uv = (vec2(pixel) + 0.5) / u_frame_size_px;
        vec3 met = compute_met(uv);
        vec3 weights = compute_weights(met);
{steps}
{smooths}
        compute_coordinate = vec4(vec2(pixel) + 0.5, {depth}, -1.0 / met.z);
        compute_main();
    }}
{stores}
}}
void main()
{{
    ivec2 side = ivec2(gl_WorkGroupSize.xy);
    ivec2 corner = {origin} + {pixels} * ivec2(gl_WorkGroupID.xy) * side;
    for (int i = 0; i < {pixels} * {pixels}; ++i) {{
        ivec2 part = ivec2(i % {pixels}, i / {pixels});
        compute_shade(corner + part * side + ivec2(gl_LocalInvocationID.xy));
    }}
}}"""
_STEPS = """        compute_step_x = compute_met(uv + vec2(1.0 / u_frame_size_px.x, 0.0));
        compute_step_y = compute_met(uv + vec2(0.0, 1.0 / u_frame_size_px.y));
        vec3 weights_x = compute_weights(compute_step_x) - weights;
        vec3 weights_y = compute_weights(compute_step_y) - weights;
        compute_step_x -= met;
        compute_step_y -= met;"""


def visible_surface_source(vertex: FlatSource, fragment: FlatSource) -> FlatSource:
    """Return a compute shader that puts out what `fragment` does, from triangles' numbers.

    Covers the pixels of a region as `compute_source` does. `vertex` places its instance by
    ``lib/instance.glsl``, takes attributes of `STREAMS` and `INSTANCE_ATTRIBUTES`, and
    `fragment` includes ``lib/space.glsl``. Textures are looked up at places whose names end in
    ``_UV``. Values that are not `flat` are interpolated with perspective.
    """
    made = _Translated()
    for number, (text, code) in enumerate(_lines(vertex)):
        made.add(_of_vertex(text, code, made) if number else [], vertex, number)
    for number, (text, code) in enumerate(_lines(fragment)):
        made.add(_of_fragment(text, code, made) if number else [], fragment, number)
    is_parallel = "u_near_depth_vs" in fragment.code
    depth = "(-met.z - u_near_depth_vs.x) / u_near_depth_vs.y" if is_parallel else "0.5"
    main = _MAIN.format(
        origin=ORIGIN,
        outside=OUTSIDE,
        ids=IDS,
        triangles=TRIANGLES,
        clears=CLEARS,
        floats=INSTANCE_FLOATS,
        depth=depth,
        pixels=PIXELS,
        zeros="\n".join(_zero(n, kind) for n, kind in made.outputs.items()),
        instances="\n".join(_instance_loads()),
        streams="\n".join(_stream_load(n, count) for n, count in made.streams.items()),
        corners="\n".join(_when(n, f"compute_{n}[k] = {n};") for n in made.smooth),
        steps=_STEPS if made.smooth else "",
        smooths="\n".join(_interpolation(n) for n in made.smooth),
        stores="\n".join(store_lines(n, kind) for n, kind in made.outputs.items()),
    )
    whole = "\n".join([*made.texts, *_TAIL.split("\n"), *main.split("\n")]) + "\n"
    more = whole.count("\n") - len(made.positions)
    positions = (*made.positions, *[("<compute>", 1)] * more)
    return FlatSource(fragment.name, whole, strip_comments(whole), positions)


class _Translated:
    """Lines of the shader that is made, where they come from, and what they declare."""

    def __init__(self) -> None:
        self.texts = [*HEAD.split("\n"), *_HEAD.split("\n")]
        self.texts += ["vec3 compute_step_x, compute_step_y;"]
        self.positions = [("<compute>", 1)] * len(self.texts)
        # What is interpolated, components of what each vertex has, and types by location.
        self.smooth: list[str] = []
        self.streams: dict[str, int] = {}
        self.outputs: dict[str, str] = {}

    def add(self, texts: list[str], stage: FlatSource, number: int) -> None:
        self.texts += texts
        self.positions += [stage.positions[min(number, len(stage.positions) - 1)]] * len(texts)


def _lines(stage: FlatSource) -> list[tuple[str, str]]:
    return list(zip(stage.text.split("\n"), stage.code.split("\n"), strict=True))


def _of_vertex(text: str, code: str, made: _Translated) -> list[str]:
    """Return what stands for a line of the vertex shader."""
    varying = _VARYING.match(code)
    if varying is None:
        return [ENTRY.sub("void compute_vertex()", text).replace("gl_Position", "compute_clip")]
    is_flat, way, kind, name = varying.groups()
    lines = [f"{kind} {name};", f"#define COMPUTE_HAS_{name} 1"]
    if way == "in" and name in STREAMS:
        made.streams[name] = int(kind.removeprefix("vec"))
        lines += [
            f"layout(std430, binding = {STREAMS[name]}) readonly buffer compute_buffer_{name} {{",
            f"    float compute_stream_{name}[]; }};",
        ]
    elif way == "out" and not is_flat:
        made.smooth.append(name)
        lines.append(f"{kind} compute_{name}[3], {name}_dx, {name}_dy;")
    return lines


def _of_fragment(text: str, code: str, made: _Translated) -> list[str]:
    """Return what stands for a line of the fragment shader."""
    if output := OUTPUT.match(code):
        n, kind, name = output.groups()
        made.outputs[n] = kind
        return image_lines(n, kind, name)
    if _VARYING.match(code):
        return [""]
    if place := _PLACE.match(code):
        name, varying = place.groups()
        return [text, f"#define {name}_dx {varying}_dx", f"#define {name}_dy {varying}_dy"]
    text = ENTRY.sub("void compute_main()", text).replace("gl_FragCoord", "compute_coordinate")
    text = _LOOKUP.sub(r"textureGrad(\1, \2, \2_dx, \2_dy)", text)
    return [_DERIVATIVE.sub(_step, text)]


def _step(match: re.Match[str]) -> str:
    """Return what stands for a derivative: of the place, or of the coordinates of an image."""
    axis, name = match.groups()
    return f"{name}_d{axis}" if name.endswith("_UV") else f"compute_step_{axis}"


def _zero(n: str, kind: str) -> str:
    return f"#ifdef COMPUTE_OUTPUT_{n}\n    COMPUTE_OUTPUT_{n} = {kind}(0);\n#endif"


def _when(name: str, line: str) -> str:
    return f"#ifdef COMPUTE_HAS_{name}\n            {line}\n#endif"


def _instance_loads() -> list[str]:
    loads, offset = [], 0
    for name, count in INSTANCE_ATTRIBUTES:
        values = ", ".join(f"compute_instance[compute_row + {offset + k}u]" for k in range(count))
        loads.append(_when(name, f"{name} = vec{count}({values});"))
        offset += count
    return loads


def _stream_load(name: str, count: int) -> str:
    values = (f"compute_stream_{name}[vertex * {count}u + {k}u]" for k in range(count))
    return _when(name, f"{name} = vec{count}({', '.join(values)});")


def _interpolation(name: str) -> str:
    """Return what gives a varying its value at the pixel, and its steps to the next ones."""
    lines = []
    for target, weights in ((name, ""), (f"{name}_dx", "_x"), (f"{name}_dy", "_y")):
        terms = " + ".join(f"weights{weights}[{k}] * compute_{name}[{k}]" for k in range(3))
        lines.append(f"{target} = {terms};")
    return _when(name, " ".join(lines))
