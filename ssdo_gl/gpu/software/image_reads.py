"""Has fragment shaders read textures as images, which llvmpipe does faster. No OpenGL here.

To look up a texture takes Mesa's software rasterizer (22.3) a call for each eight pixels, to which
nothing stays in a register, and some twenty instructions for the level, the border and texture
coordinates. An image is read where it stands, by whole numbers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from ssdo_gl.gpu.shader_source import FlatSource

# What llvmpipe has for a stage.
MOST_IMAGES = 32
_VERSION = "#version 330 core\n"
_HEAD = (
    "#extension GL_ARB_shader_image_load_store : require",
    "#extension GL_ARB_shader_image_size : require",
    "#extension GL_ARB_shading_language_420pack : require",
    "#define image_texel(image, texel, level) imageLoad(image, texel)",
    "#define image_size(image, level) imageSize(image)",
)
_DECLARATION = re.compile(r"\buniform\s+([iu]?)sampler2D\s+(\w+)\s*;")
_READ = r"\b(texelFetch|textureSize)(\s*\(\s*{name}\b)"
_WORDS: Mapping[str, str] = {"texelFetch": "image_texel", "textureSize": "image_size"}
# Mesa reads by the format of what is bound; of the declaration it takes the type alone.
_FORMATS: Mapping[str, str] = {"": "rgba32f", "i": "rgba32i", "u": "rgba32ui"}


def with_image_reads(fragment: FlatSource) -> tuple[FlatSource, dict[str, int]]:
    """Return the shader with images for samplers, and their units by name.

    Chosen are those of which texels are asked for by their place, and nothing else: no images can
    be what is filtered, nor what holds sRGB or three channels.
    """
    code, units = fragment.code, dict[str, int]()
    for kind, name in _DECLARATION.findall(code):
        read = re.compile(_READ.format(name=name))
        changed, count = read.subn(lambda found: _WORDS[found[1]] + found[2], code)
        if not 0 < count == len(re.findall(rf"\b{name}\b", code)) - 1 or len(units) == MOST_IMAGES:
            continue
        layout = f"layout({_FORMATS[kind]}, binding = {len(units)})"
        image = f"{layout} readonly uniform {kind}image2D {name};"
        code = re.sub(rf"\buniform\s+{kind}sampler2D\s+{name}\s*;", image, changed)
        units[name] = len(units)
    if not units:
        return fragment, units
    code = code.replace(_VERSION, _VERSION + "\n".join(_HEAD) + "\n", 1)
    places = [(f"<{__name__}>", 1)] * len(_HEAD)
    positions = (fragment.positions[0], *places, *fragment.positions[1:])
    return replace(fragment, text=code, code=code, positions=positions), units
