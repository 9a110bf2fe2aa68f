"""Turns a full-screen fragment shader into a compute shader of the same result. No OpenGL here.

Accelerators of data centres run fragment shaders on a few of their processors only (NVIDIA
H100 architecture white paper: two of its 66 clusters of processors draw), compute shaders on
all. One source serves both: outputs become images that every invocation stores into.
"""

from __future__ import annotations

import re

from ssdo_gl.gpu.shader_source import FlatSource, strip_comments

# Invocations of a group, x and y: whole 2x2 quads, and two warps of 32.
GROUP_SIZE = (8, 8)
DERIVATIVES_EXTENSION = "GL_NV_compute_shader_derivatives"
# Names that the made lines add: `compute_` in front, so that no shader has them.
ORIGIN, REGION, SIZE, ADDS = "compute_origin", "compute_region", "compute_size", "compute_adds"

HEAD = f"""#version 450 core
layout(local_size_x = {GROUP_SIZE[0]}, local_size_y = {GROUP_SIZE[1]}) in;
uniform ivec2 {ORIGIN};
uniform ivec4 {REGION};
uniform vec2 {SIZE};
uniform int {ADDS};
vec4 compute_coordinate;
vec4 compute_value(float x) {{ return vec4(x, 0.0, 0.0, 0.0); }}
vec4 compute_value(vec2 x) {{ return vec4(x, 0.0, 0.0); }}
vec4 compute_value(vec3 x) {{ return vec4(x, 0.0); }}
vec4 compute_value(vec4 x) {{ return x; }}
uvec4 compute_value(uint x) {{ return uvec4(x, 0u, 0u, 0u); }}
uvec4 compute_value(uvec2 x) {{ return uvec4(x, 0u, 0u); }}
uvec4 compute_value(uvec3 x) {{ return uvec4(x, 0u); }}
uvec4 compute_value(uvec4 x) {{ return x; }}
ivec4 compute_value(int x) {{ return ivec4(x, 0, 0, 0); }}
ivec4 compute_value(ivec2 x) {{ return ivec4(x, 0, 0); }}
ivec4 compute_value(ivec3 x) {{ return ivec4(x, 0); }}
ivec4 compute_value(ivec4 x) {{ return x; }}"""
_EXTENSION = f"#extension {DERIVATIVES_EXTENSION} : require"
_QUADS = "layout(derivative_group_quadsNV) in;"
OUTSIDE = f"any(lessThan(pixel, {REGION}.xy)) || any(greaterThanEqual(pixel, {REGION}.zw))"
_MAIN = """void main()
{{
    ivec2 pixel = {origin} + ivec2(gl_GlobalInvocationID.xy);
    compute_coordinate = vec4(vec2(pixel) + 0.5, 0.5, 1.0);
    {uv}
    bool is_outside = {outside};
    {early}
    compute_main();
    if (is_outside) return;
{stores}
}}"""
_STORE = """#ifdef COMPUTE_OUTPUT_{n}
    {kind} value_{n} = compute_value(COMPUTE_OUTPUT_{n});
    {add}
    imageStore(compute_image_{n}, pixel, value_{n});
#endif"""
_ADD = "if ({adds} != 0) value_{n} += texelFetch(compute_target_{n}, pixel, 0);"
OUTPUT = re.compile(r"^\s*layout\s*\(\s*location\s*=\s*(\w+)\s*\)\s*out\s+(\w+)\s+(\w+)\s*;\s*$")
_COORDINATE = re.compile(r"^\s*in\s+vec2\s+(v_uv)\s*;\s*$")
ENTRY = re.compile(r"\bvoid\s+main\s*\(\s*(?:void)?\s*\)")
_DERIVATIVE = re.compile(r"\b(?:dFd[xy]|fwidth)(?:Fine|Coarse)?\b")
# What has no meaning without a rasterizer, and textures that choose a level by derivatives.
_RASTER_ONLY = re.compile(
    r"\bdiscard\b|\bgl_(?:Frag(?!Coord)|FrontFacing|Primitive|Point|Sample)\w*|"
    r"\btexture(?:Proj|Offset|QueryLod)?\s*\("
)
_VARYING = re.compile(r"^\s*(?:(?:flat|smooth|noperspective)\s+)*(?:in|out)\s+\w+\s+\w+\s*;")


def image_lines(n: str, kind: str, name: str) -> list[str]:
    """Return what stands for the output `name` at location `n`: a variable and an image."""
    return [
        f"{kind} {name};",
        f"layout(binding = {n}) writeonly uniform {_prefix(kind)}image2D compute_image_{n};",
        f"#define COMPUTE_OUTPUT_{n} {name}",
    ]


def store_lines(n: str, kind: str, add: str = "") -> str:
    """Return what stores the output at location `n`, if there is one, at ``pixel``."""
    return _STORE.format(n=n, kind=f"{_prefix(kind)}vec4", add=add)


def _prefix(kind: str) -> str:
    return kind[0] if kind[0] in "iu" else ""


def needs_derivatives(fragment: FlatSource) -> bool:
    """Whether the shader compares neighbouring pixels of a quad."""
    return _DERIVATIVE.search(fragment.code) is not None


def compute_source(fragment: FlatSource) -> FlatSource | None:
    """Return a compute shader that stores what `fragment` puts out, or None if none can.

    Its invocations cover the pixels of ``compute_region`` (low and high corner) from
    ``compute_origin`` on, of a picture of ``compute_size``; output n goes to
    ``compute_image_n``, image unit n, added to ``compute_target_n`` if ``compute_adds``.
    Error messages of the driver keep the lines of the files.
    """
    if _RASTER_ONLY.search(fragment.code):
        return None
    uses_quads = needs_derivatives(fragment)
    head = HEAD.split("\n")
    if uses_quads:
        # An extension comes before all other code, what it brings after the group's size.
        version, size, *rest = head
        head = [version, _EXTENSION, size, _QUADS, *rest]
    lines, positions = list(head), [("<compute>", 1)] * len(head)
    uv, kinds = "", dict[str, str]()
    codes = fragment.code.split("\n")
    texts = fragment.text.split("\n")
    for number, (text, code) in enumerate(zip(texts, codes, strict=True)):
        position = fragment.positions[min(number, len(fragment.positions) - 1)]
        made = [text]
        if number == 0:
            made = []  # The version stands in the head.
        elif output := OUTPUT.match(code):
            n, kind, name = output.groups()
            kinds[n] = kind
            made = [
                *image_lines(n, kind, name),
                f"uniform {_prefix(kind)}sampler2D compute_target_{n};",
            ]
        elif coordinate := _COORDINATE.match(code):
            uv = f"{coordinate[1]} = compute_coordinate.xy / {SIZE};"
            made = [f"vec2 {coordinate[1]};"]
        elif _VARYING.match(code):
            return None
        else:
            text = ENTRY.sub("void compute_main()", text)
            made = [text.replace("gl_FragCoord", "compute_coordinate")]
        lines += made
        positions += [position] * len(made)
    stores = "\n".join(
        store_lines(n, kind, _ADD.format(n=n, adds=ADDS)) for n, kind in sorted(kinds.items())
    )
    # With derivatives all of a quad must run, whether it is seen or not.
    early = "" if uses_quads else "if (is_outside) return;"
    main = _MAIN.format(origin=ORIGIN, uv=uv, outside=OUTSIDE, early=early, stores=stores)
    lines += main.split("\n")
    positions += [("<compute>", 1)] * (main.count("\n") + 1)
    whole = "\n".join(lines) + "\n"
    return FlatSource(fragment.name, whole, strip_comments(whole), tuple(positions))
