"""Importer of Wavefront .obj files with their .mtl materials.

Read here rather than by trimesh, which counts negative indices from the end of the
file (they count from the line they stand on), skips vertices whose line uses tabs,
and rounds material colours to eight bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.color import linear_from_srgb
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.emissive_meshes import turned_to_scene
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.obj.mtl import read_mtl
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import SceneError


@dataclass
class _Group:
    """Faces of one material: distinct corners, and triangles that refer to them."""

    corner_of_text: dict[str, int] = field(default_factory=dict)
    triangles: list[tuple[int, int, int]] = field(default_factory=list)


@dataclass
class _Contents:
    """Raw vertex data in file order, and faces by material name."""

    positions: list[list[str]] = field(default_factory=list)
    uvs: list[list[str]] = field(default_factory=list)
    normals: list[list[str]] = field(default_factory=list)
    groups: dict[str, _Group] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)


def read_obj(path: Path, where: str) -> Model:
    """Return meshes, one for each material, in order of first use.

    Raises
    ------
    SceneError
        If a line does not parse or a face names a vertex that does not exist.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SceneError(f"{where}: cannot be read: {error.strerror}") from None
    contents = _parse(text, where)
    model = Model()
    known: dict[str, Material] = {}
    for library in contents.libraries:
        known.update(read_mtl(path, library, model, where))
    positions, colors = _vertices(contents.positions, where)
    uvs = _numbers(contents.uvs, 2, "vt", where)
    normals = _numbers(contents.normals, 3, "vn", where)
    for name, group in contents.groups.items():
        corners = _corners(group, (len(positions), len(uvs), len(normals)), where)
        mesh = model.add_mesh(
            positions[corners[:, 0]],
            np.array(group.triangles, dtype=np.int64),
            # Normals or coordinates that only some corners have cannot be used.
            normals[corners[:, 2]] if np.all(corners[:, 2] >= 0) else None,
            uvs[corners[:, 1]] * [1.0, -1.0] + [0.0, 1.0] if np.all(corners[:, 1] >= 0) else None,
            None if colors is None else colors[corners[:, 0]],
            name,
        )
        if mesh is None:
            continue
        white = (1.0, 1.0, 1.0) if colors is not None else (0.8, 0.8, 0.8)
        model.materials.append(known.get(name, Material(name=name or "default", albedo=white)))
        if name and name not in known:
            model.note(f"material {name!r} is not in the file's material library: drawn grey")
        model.objects.append(SceneObject(mesh, len(model.materials) - 1, name=name))
    for index, turned, note in turned_to_scene(model.meshes, model.materials, model.objects):
        model.meshes[index] = turned
        model.note(note)
    return model


def _logical_lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and words, with continued lines joined and comments removed."""
    pending: list[str] = []
    for number, line in enumerate(text.split("\n"), 1):
        words = (line.split("#", 1)[0] if "#" in line else line).split()
        if words and words[-1][-1] == "\\":
            pending += [*words[:-1], words[-1][:-1]] if words[-1] != "\\" else words[:-1]
            continue
        if pending:
            words, pending = pending + words, []
        if words:
            yield number, words


def _parse(text: str, where: str) -> _Contents:
    contents = _Contents()
    group: _Group | None = None
    material = ""
    for number, words in _logical_lines(text):
        key = words[0]
        if key == "v":
            contents.positions.append(words[1:])
        elif key == "vt":
            contents.uvs.append(words[1:])
        elif key == "vn":
            contents.normals.append(words[1:])
        elif key == "f":
            if group is None:
                group = contents.groups.setdefault(material, _Group())
            _add_face(group, words[1:], contents, where, number)
        elif key == "usemtl":
            material = " ".join(words[1:])
            group = contents.groups.setdefault(material, _Group())
        elif key == "mtllib":
            contents.libraries.append(" ".join(words[1:]))
    contents.groups = {name: g for name, g in contents.groups.items() if g.triangles}
    return contents


def _add_face(group: _Group, words: list[str], contents: _Contents, where: str, line: int) -> None:
    if len(words) < 3:
        raise SceneError(
            f"{where}: line {line}: a face needs at least three corners, found {len(words)}"
        )
    index = group.corner_of_text
    if any("-" in word for word in words):
        words = [
            _absolute(word, contents, f"{where}: line {line}") if "-" in word else word
            for word in words
        ]
    corners = [index.setdefault(word, len(index)) for word in words]
    first = corners[0]
    group.triangles += [(first, corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]


def _absolute(word: str, contents: _Contents, where: str) -> str:
    """Replace indices that count backwards from the current line by positive ones."""
    counts = (len(contents.positions), len(contents.uvs), len(contents.normals))
    parts = word.split("/")
    try:
        numbers = [int(part) if part else 0 for part in parts]
    except ValueError:
        raise SceneError(f"{where}: {word!r} is not a face corner such as 1/2/3") from None
    return "/".join(
        str(count + 1 + n) if n < 0 else part
        for n, part, count in zip(numbers, parts, counts, strict=False)
    )


def _corners(group: _Group, counts: tuple[int, int, int], where: str) -> NDArray[np.int64]:
    """Return (C, 3) zero-based indices of position, uv and normal; -1 where absent."""
    result = np.full((len(group.corner_of_text), 3), -1, dtype=np.int64)
    for row, text in enumerate(group.corner_of_text):
        parts = text.split("/")
        try:
            numbers = [int(part) if part else 0 for part in parts]
        except ValueError:
            numbers = []
        if not 1 <= len(numbers) <= 3:
            raise SceneError(f"{where}: {text!r} is not a face corner such as 1/2/3")
        for column, number in enumerate(numbers):
            if number < 0 or number > counts[column] or (number == 0 and parts[column]):
                what = ("v", "vt", "vn")[column]
                raise SceneError(
                    f"{where}: a face refers to {what} {number}, but there are {counts[column]}"
                )
            result[row, column] = number - 1
        if result[row, 0] < 0:
            raise SceneError(f"{where}: face corner {text!r} names no vertex")
    return result


def _vertices(rows: list[list[str]], where: str) -> tuple[FloatArray, FloatArray | None]:
    """Return positions (V, 3), and linear colours (V, 4) if every vertex has one."""
    positions = _numbers(rows, 3, "v", where)
    if not rows or min(len(row) for row in rows) < 6:
        return positions, None
    encoded = np.clip(_numbers(rows, 6, "v", where)[:, 3:], 0.0, 1.0)
    return positions, np.concatenate(
        [linear_from_srgb(encoded), np.ones((len(encoded), 1))], axis=1
    )


def _numbers(rows: list[list[str]], count: int, key: str, where: str) -> FloatArray:
    """Return the first `count` numbers of each row, missing ones of vt as zero."""
    if key == "vt":
        rows = [[*row, "0", "0"][:2] for row in rows]
    try:
        array = np.array([row[:count] for row in rows], dtype=np.float64)
    except ValueError:
        bad = next((row for row in rows if not _are_numbers(row[:count], count)), [])
        text = " ".join([key, *bad])[:60]
        raise SceneError(f"{where}: {text!r}: expected {count} numbers after {key!r}") from None
    if rows and array.shape[1] != count:
        text = " ".join([key, *rows[0]])[:60]
        raise SceneError(f"{where}: {text!r}: expected {count} numbers after {key!r}")
    return array.reshape(-1, count)


def _are_numbers(words: list[str], count: int) -> bool:
    try:
        return len([float(word) for word in words]) == count
    except ValueError:
        return False
