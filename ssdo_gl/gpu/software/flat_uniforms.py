"""Passes uniforms to fragments as flat inputs, which llvmpipe reads faster. No OpenGL here.

To read a uniform in a fragment shader takes Mesa's software rasterizer (22.3) some 27 instructions
for each number, because it looks each pixel's value up, and anew in each round of a loop; a flat
input takes one. So the vertex shader, which runs three times, reads uniforms and passes them on.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from ssdo_gl.gpu.shader_source import WORD, FlatSource

# Numbers that fit beside a position and what shaders hand on themselves: of 32 vectors.
MOST_NUMBERS = 112
_COLUMNS = {"float": 1, "int": 1, "uint": 1}
_COLUMNS |= {f"{kind}vec{n}": n for kind in ("", "i", "u") for n in (2, 3, 4)}
_COLUMNS |= {f"mat{n}": n * n for n in (2, 3, 4)}
_DECLARATION = re.compile(
    r"uniform\s+(\w+)\s+(\w+)\s*(?:\[\s*(\w+)\s*\])?\s*;",
    re.ASCII,
)
_ATTRIBUTE = re.compile(r"^\s*(?:layout\s*\([^)]*\)\s*)?in\s+\w+", re.MULTILINE)
_FIXED = re.compile(r"\s*(?:\d+|[A-Z_][A-Z0-9_]*)\s*")
_MAIN = re.compile(r"void\s+main\s*\(\s*\)\s*\{")


class _Uniform(NamedTuple):
    kind: str
    name: str
    size: int | None  # of an array

    @property
    def numbers(self) -> int:
        return _COLUMNS[self.kind] * (self.size or 1)

    def declared(self, storage: str, prefix: str = "") -> str:
        array = "" if self.size is None else f"[{self.size}]"
        return f"{storage} {self.kind} {prefix}{self.name}{array};"


def with_flat_uniforms(
    vertex: FlatSource, fragment: FlatSource
) -> tuple[FlatSource, FlatSource] | None:
    """Return the two stages with the fragment's uniforms read by the vertex shader.

    Lines stay where they are, and names of uniforms as they were. None if vertices have
    attributes, of which there may be many, or nothing is left to do.
    """
    if _ATTRIBUTE.search(vertex.code):
        return None
    chosen = list(_chosen(fragment.code))
    if not chosen:
        return None
    known = vertex.uniforms()
    head = [u.declared("uniform") for u in chosen if u.name not in known]
    head += [u.declared("flat out", "flat_") for u in chosen]
    body = [f"flat_{u.name} = {u.name};" for u in chosen]
    handed = _MAIN.sub(lambda main: " ".join((*head, main.group(), *body)), vertex.code, count=1)
    names = {u.name for u in chosen}
    taken = _DECLARATION.sub(
        lambda found: (
            found.group().replace("uniform", "flat in", 1)
            if found.group(2) in names
            else found.group()
        ),
        fragment.code,
    )
    read = WORD.sub(lambda word: f"flat_{word[0]}" if word[0] in names else word[0], taken)
    return _with_code(vertex, handed), _with_code(fragment, read)


def _chosen(code: str) -> Iterator[_Uniform]:
    """Yield those that are read and can be handed on, as far as there is place for them."""
    left = MOST_NUMBERS
    declarations = _DECLARATION.findall(code)
    times = Counter(name for _, name, _ in declarations)
    words = Counter(WORD.findall(code))
    for kind, name, size in declarations:
        if kind not in _COLUMNS or times[name] > 1 or words[name] < 2:
            continue
        count = _number(size, code) if size else None
        if size and (count is None or not all(map(_FIXED.fullmatch, _indices(name, code)))):
            continue
        uniform = _Uniform(kind, name, count)
        if uniform.numbers <= left:
            left -= uniform.numbers
            yield uniform


def _indices(name: str, code: str) -> list[str]:
    """Return what stands in brackets behind an array, but for its declaration."""
    return re.findall(rf"\b{name}\s*\[([^\]]*)\]", code, re.ASCII)[1:]


def _number(text: str, code: str) -> int | None:
    """Return the size of an array, a number or the name of one."""
    if text.isdigit():
        return int(text)
    found = re.findall(rf"^\s*#\s*define\s+{text}\s+(\d+)\s*$", code, re.MULTILINE)
    return int(found[0]) if len(found) == 1 else None


def _with_code(source: FlatSource, code: str) -> FlatSource:
    return FlatSource(source.name, code, code, source.positions)
