"""Has fragment shaders read textures as images, which llvmpipe does faster. No OpenGL here.

To look up a texture takes Mesa's software rasterizer (22.3) a call for each eight pixels, to which
nothing stays in a register, and some twenty instructions for the level, the border and texture
coordinates. An image is read where it stands, by whole numbers.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

from ssdo_gl.gpu.shader_source import WORD, FlatSource

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
# Without a word boundary before them, plain text is looked for, which takes a tenth of the time.
_DECLARATION = re.compile(r"uniform\s+([iu]?)sampler2D\s+(\w+)\s*;", re.ASCII)
_READ = re.compile(r"(texelFetch|textureSize)(\s*\(\s*)(\w+)", re.ASCII)
_WORDS: Mapping[str, str] = {"texelFetch": "image_texel", "textureSize": "image_size"}
# Mesa reads by the format of what is bound; of the declaration it takes the type alone.
_FORMATS: Mapping[str, str] = {"": "rgba32f", "i": "rgba32i", "u": "rgba32ui"}


def with_image_reads(fragment: FlatSource) -> tuple[FlatSource, dict[str, int]]:
    """Return the shader with images for samplers, and their units by name.

    Chosen are those of which texels are asked for by their place, and nothing else: no images can
    be what is filtered, nor what holds sRGB or three channels.
    """
    code = fragment.code
    words = Counter(WORD.findall(code))
    reads = Counter(name for _, _, name in _READ.findall(code))
    names = [name for _, name in _DECLARATION.findall(code) if 0 < reads[name] == words[name] - 1]
    units = {name: unit for unit, name in enumerate(names[:MOST_IMAGES])}
    if not units:
        return fragment, units

    def read(found: re.Match[str]) -> str:
        word, between, name = found.groups()
        return f"{_WORDS[word]}{between}{name}" if name in units else found[0]

    def declared(found: re.Match[str]) -> str:
        kind, name = found.groups()
        if name not in units:
            return found[0]
        layout = f"layout({_FORMATS[kind]}, binding = {units[name]})"
        return f"{layout} readonly uniform {kind}image2D {name};"

    code = _DECLARATION.sub(declared, _READ.sub(read, code))
    code = code.replace(_VERSION, _VERSION + "\n".join(_HEAD) + "\n", 1)
    places = [(f"<{__name__}>", 1)] * len(_HEAD)
    positions = (fragment.positions[0], *places, *fragment.positions[1:])
    return replace(fragment, text=code, code=code, positions=positions), units
