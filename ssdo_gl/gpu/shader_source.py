"""Flattens shader sources: includes, defines and a line table. No OpenGL here.

Drivers disagree about ``#include`` and ``#line``, and take an undefined name in ``#if``
for 0 without a word. So the project resolves includes itself, keeps its own table from
flattened lines to files, and refuses what a driver would let pass.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from ssdo_gl.wording import suggestion

ReadText = Callable[[str], str]

_VERSION_LINE = "#version 330 core"
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_INCLUDE = re.compile(r'^\s*#\s*include\b\s*(?:"([^"]*)"|<(\w+)>)?\s*$')
_DIRECTIVE = re.compile(r"^\s*#\s*(\w+)\s*(.*)$")
_DEFINED = re.compile(r"\bdefined\s*(?:\(\s*(\w+)\s*\)|(\w+))")
WORD = re.compile(r"\b[A-Za-z_]\w*", re.ASCII)
_UNIFORM = re.compile(r"uniform\s+(?:(?:lowp|mediump|highp)\s+)?(\w+)\s+([^;{]+);")
_DECLARATOR = re.compile(r"^\s*(\w+)\s*(\[[^\]]*\])?\s*(=.*)?$", re.DOTALL)
_VARYING = re.compile(
    r"^\s*(?:(?:flat|smooth|noperspective|centroid)\s+)*(in|out)\s+"
    r"(?:(?:lowp|mediump|highp)\s+)?(\w+)\s+(\w+)\s*(?:\[[^\]]*\])?\s*;",
    re.MULTILINE,
)
_PREDEFINED = frozenset({"__LINE__", "__FILE__", "__VERSION__", "GL_core_profile"})
# How the drivers write a position: Mesa `0:12(3):`, NVIDIA `0(12) :`, AMD, Apple, Intel
# and glslang `ERROR: 0:12:`. The leading number is the source string, always 0 here.
_LOG_POSITIONS = (
    re.compile(r"^\s*\d+:(\d+)\(\d+\)\s*:\s*(.*)$"),
    re.compile(r"^\s*\d+\((\d+)\)\s*:\s*(.*)$"),
    re.compile(r"^\s*((?:ERROR|WARNING)):\s*\d+:(\d+):\s*(.*)$"),
)


class ShaderError(RuntimeError):
    """A shader that does not load, naming the file and the line."""


@dataclass(frozen=True)
class UniformDeclaration:
    """What the source says of one uniform: its GLSL type, whether an array or preset."""

    type: str
    is_array: bool
    has_initializer: bool

    @property
    def is_sampler(self) -> bool:
        """Whether it takes a texture rather than a value."""
        return "sampler" in self.type


@dataclass(frozen=True)
class FlatSource:
    """One shader stage with every include in place.

    Attributes
    ----------
    name : str
        The file that was asked for.
    text : str
        What the driver compiles.
    code : str
        `text` with comments blanked, line for line.
    positions : tuple of (str, int)
        File and line that each line of `text` came from.
    """

    name: str
    text: str
    code: str
    positions: tuple[tuple[str, int], ...]

    def locate(self, line: int) -> str:
        """Return ``file:line`` of a line of `text`, counted from 1."""
        if not 1 <= line <= len(self.positions):
            return f"{self.name}:?"
        file, number = self.positions[line - 1]
        return f"{file}:{number}"

    def translate_log(self, log: str) -> str:
        """Return a driver's messages with our files and lines, one per line."""
        return "\n".join(self._translate(line) for line in log.splitlines() if line.strip())

    def _translate(self, line: str) -> str:
        for pattern in _LOG_POSITIONS:
            match = pattern.match(line)
            if match:
                *kind, number, message = match.groups()
                return ": ".join([self.locate(int(number)), *(k.lower() for k in kind), message])
        return line.strip()

    def uniforms(self) -> dict[str, UniformDeclaration]:
        """Return the declared uniforms by name, used or not."""
        found: dict[str, UniformDeclaration] = {}
        for kind, declarators in _UNIFORM.findall(self.code):
            for declarator in _split_declarators(declarators):
                match = _DECLARATOR.match(declarator)
                if match:
                    name, array, initializer = match.groups()
                    found[name] = UniformDeclaration(kind, bool(array), bool(initializer))
        return found


_NO_CHOICES: Mapping[str, str] = {}


def flatten(
    name: str,
    read: ReadText,
    defines: Mapping[str, int] | None = None,
    choices: Mapping[str, str] = _NO_CHOICES,
    macros: Mapping[str, str] = _NO_CHOICES,
) -> FlatSource:
    """Return the shader `name` with its includes in place, each once, and `defines` set.

    Parameters
    ----------
    name : str
        As `read` knows it, e.g. ``"passes/gbuffer.frag"``.
    read : callable
        Returns the text of a file; raises FileNotFoundError.
    defines : mapping of str to int
        Written right after ``#version``.
    choices : mapping of str to str
        The file behind each ``#include <name>``: one of several that define the same.
    macros : mapping of str to str
        Written behind the defines, whether or not the shader mentions them: what is replaced
        by what.

    Raises
    ------
    ShaderError
        A file that is missing, an include that nobody chose a file for, a
        ``#version 330 core`` that is missing or in the wrong place, an
        include inside a conditional, or an undefined name in ``#if``.
    """
    lines = [_VERSION_LINE]
    positions = [(name, 1)]
    for key, value in sorted((defines or {}).items()):
        lines.append(_define_line(key, value))
        positions.append((f"<define {key}>", 1))
    for key, body in macros.items():
        lines.append(f"#define {key} {body}")
        positions.append((f"<define {key}>", 1))
    code = [*lines]
    _Flattener(read, choices, lines, code, positions).append(name, None)
    text, bare = ("\n".join(part) + "\n" for part in (lines, code))
    flat = FlatSource(name, text, bare, tuple(positions))
    _check_conditions(flat)
    return flat


def check_mentioned(defines: Iterable[str], stages: Iterable[FlatSource]) -> None:
    """Raise ShaderError if a define appears in none of the `stages`.

    A driver ignores it without a word: a renamed switch would lose its effect.
    """
    stages = tuple(stages)
    words: set[str] = set()
    for stage in stages:
        # What was given stands right behind the version.
        rest = enumerate(file for file, _ in stage.positions[1:])
        given = next(i for i, file in rest if not file.startswith("<define "))
        words.update(WORD.findall(stage.code.split("\n", 1 + given)[-1]))
    for name in defines:
        if name not in words:
            files = " and ".join(stage.name for stage in stages)
            hint = suggestion(name, filter(str.isupper, words), lists=False)
            raise ShaderError(f"{files}: the define {name} is never mentioned{hint}")


def check_varyings(vertex: FlatSource, fragment: FlatSource) -> None:
    """Raise ShaderError if `fragment` reads what `vertex` does not write, or as another type.

    Mesa links an input without a writer and leaves its value undefined.
    """
    written = {name: kind for way, kind, name in _VARYING.findall(vertex.code) if way == "out"}
    for match in _VARYING.finditer(fragment.code):
        way, kind, name = match.groups()
        if way == "in" and written.get(name) != kind:
            line = fragment.code.count("\n", 0, match.start(1)) + 1
            fault = f"writes it as {written[name]}" if name in written else "does not write it"
            raise ShaderError(f"{fragment.locate(line)}: in {kind} {name}: {vertex.name} {fault}")


def strip_comments(text: str) -> str:
    """Return `text` with comments blanked and every line break kept."""
    return _COMMENT.sub(lambda m: " " + "\n" * m.group().count("\n"), text)


@lru_cache(maxsize=256)
def _lines_of(text: str) -> tuple[tuple[str, str], ...]:
    """Return each line of a file, and what is left of it without comments."""
    bare = strip_comments(text).split("\n")
    return tuple(
        (line.rstrip("\r"), code.rstrip("\r"))
        for line, code in zip(text.split("\n"), bare, strict=True)
    )


def _define_line(name: str, value: int) -> str:
    if not re.fullmatch(r"[A-Z][A-Z0-9_]*", name):
        raise ShaderError(f"the define {name!r} is not a name in capitals")
    try:
        number = operator.index(value)
    except TypeError:
        raise ShaderError(f"the define {name} = {value!r} is not an integer") from None
    # Parentheses keep `2 -N` from reading as a decrement once N is negative.
    return f"#define {name} {number}" if number >= 0 else f"#define {name} ({number})"


@dataclass
class _Flattener:
    """Appends files to `lines`, and to `code` without comments, each once."""

    read: ReadText
    choices: Mapping[str, str]
    lines: list[str]
    code: list[str]
    positions: list[tuple[str, int]]
    seen: set[str] = field(default_factory=set)

    def append(self, name: str, includer: str | None) -> None:
        """Append the lines of the file `name`, and first those of what it includes."""
        self.seen.add(name)
        lines = _lines_of(self._text(name, includer))
        depth = 0
        has_version = False
        for number, (line, bare) in enumerate(lines, start=1):
            directive = _DIRECTIVE.match(bare) if "#" in bare else None
            word = directive.group(1) if directive else ""
            if word == "version":
                is_first = not any(code.strip() for _, code in lines[: number - 1])
                _check_version(f"{name}:{number}", bare, includer, is_first)
                has_version = True
                line = bare = ""  # It is already the first line of the flattened text.
            depth += {"if": 1, "ifdef": 1, "ifndef": 1, "endif": -1}.get(word, 0)
            if word == "include":
                file = self._included(f"{name}:{number}", bare, depth)
                if file not in self.seen:
                    self.append(file, f"{name}:{number}")
                line = bare = ""
            self.lines.append(line)
            self.code.append(bare)
            self.positions.append((name, number))
        if includer is None and not has_version:
            raise ShaderError(f"{name}:1: a shader starts with {_VERSION_LINE}")

    def _text(self, name: str, includer: str | None) -> str:
        try:
            return self.read(name)
        except (FileNotFoundError, IsADirectoryError):
            where = f"{includer}: cannot find the include" if includer else "cannot find the shader"
            raise ShaderError(f'{where} "{name}"') from None

    def _included(self, here: str, line: str, depth: int) -> str:
        """Return the file that an include names, or that was chosen for it."""
        match = _INCLUDE.match(line)
        if not match or not (match[1] or match[2]):
            raise ShaderError(f'{here}: write #include "lib/name.glsl"')
        if depth:
            # Flattening cannot know which branch the driver takes, and include-once
            # would then drop the file from the branch that needs it.
            raise ShaderError(f"{here}: an #include inside #if is not allowed")
        if match[2] and match[2] not in self.choices:
            raise ShaderError(f"{here}: no file was chosen for #include <{match[2]}>")
        return match[1] or self.choices[match[2]]


def _check_version(here: str, line: str, includer: str | None, is_first: bool) -> None:
    if includer is not None:
        raise ShaderError(f"{here}: #version inside a file that {includer} includes")
    if line.split() != _VERSION_LINE.split():
        raise ShaderError(f"{here}: write {_VERSION_LINE}, not {line.strip()!r}")
    if not is_first:
        raise ShaderError(f"{here}: {_VERSION_LINE} must come before any code")


def _check_conditions(flat: FlatSource) -> None:
    """Raise ShaderError for a name in #if or #elif that nothing defines before it."""
    known = set(_PREDEFINED)
    tested: list[set[str]] = []  # names whose existence each open conditional asks for
    for number, line in enumerate(flat.code.splitlines(), start=1):
        match = _DIRECTIVE.match(line) if "#" in line else None
        if not match:
            continue
        word, rest = match.groups()
        if word == "define" and (name := WORD.match(rest)):
            known.add(name.group())
        elif word in ("ifdef", "ifndef"):
            tested.append(set(WORD.findall(rest)))
        elif word in ("if", "elif"):
            asked = {a or b for a, b in _DEFINED.findall(rest)}
            if word == "if":
                tested.append(asked)
            elif tested:
                tested[-1] |= asked
            allowed = known.union(*tested)
            for name_used in WORD.findall(_DEFINED.sub(" ", rest)):
                if name_used not in allowed and not name_used.startswith("GL_"):
                    raise ShaderError(
                        f"{flat.locate(number)}: #{word} uses {name_used}, which is not defined"
                    )
        elif word == "endif" and tested:
            tested.pop()


def _split_declarators(text: str) -> list[str]:
    """Split `a, b[2], c = vec2(0, 1)` at the commas outside brackets."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts
