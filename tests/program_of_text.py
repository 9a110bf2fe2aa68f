"""Programs whose fragment shader is a text of a test, under the rules of a shader library."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from weakref import WeakKeyDictionary

from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.shader import ShaderLibrary

_known: WeakKeyDictionary[ShaderLibrary, dict[object, Program]] = WeakKeyDictionary()


def fullscreen_source(
    library: ShaderLibrary,
    text: str,
    defines: Mapping[str, int] | None = None,
    name: str = "<test>",
) -> Program:
    """Return the program, compiled once for each library."""
    known = _known.setdefault(library, {})
    key = name, text, tuple((defines or {}).items())
    if key not in known:
        own = copy.copy(library)
        own._read = lambda file: text if file == name else library._read(file)
        own._by_name, own._asked = {}, {}
        known[key] = own.fullscreen(name, defines or {})
    return known[key]
