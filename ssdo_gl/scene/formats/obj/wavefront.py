"""Importer of Wavefront .obj files with their .mtl materials.

Read here rather than by trimesh, which counts negative indices from the end of the
file (they count from the line they stand on), skips vertices whose line uses tabs,
and rounds material colours to eight bits.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.emissive_meshes import turned_to_scene
from ssdo_gl.scene.formats.colors import linear_colors
from ssdo_gl.scene.formats.model import Model, some_names
from ssdo_gl.scene.formats.obj.mtl import MtlMaterial, material_called, read_libraries
from ssdo_gl.scene.formats.obj.obj_text import logical_lines, remainder
from ssdo_gl.scene.formats.triangulate import triangulated
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.wording import comma_hint, counted

# Elements that are not drawn; two-cornered faces are lines.
_NOT_DRAWN = {"l": "line", "curv": "curve", "surf": "surface"}
# Numbers that are none, as old Microsoft runtimes print them: no comment begins at their "#".
_NOT_FINITE = re.compile(r"[+-]?\d\.#(IND|INF|QNAN|SNAN)\d*")


@dataclass
class _MaterialFaces:
    """Faces of one material.

    `corner_of_text` numbers the distinct corners, of which `corners` lists those of all
    faces in turn, `counts` of them a face.
    """

    corner_of_text: dict[str, int] = field(default_factory=dict)
    corners: list[int] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)


@dataclass
class _Contents:
    """Raw vertex data in file order, and faces by material name."""

    positions: list[list[str]] = field(default_factory=list)
    uvs: list[list[str]] = field(default_factory=list)
    normals: list[list[str]] = field(default_factory=list)
    groups: dict[str, _MaterialFaces] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)
    points: list[str] = field(default_factory=list)
    not_drawn: dict[str, int] = field(default_factory=dict)


def read_obj(path: Path, where: str) -> Model:
    """Return meshes, one for each material, in order of first use.

    Raises
    ------
    SceneError
        If a line does not parse, a face names a vertex that does not exist, or nothing
        but lines is there.
    """
    contents = _parse(path, where)
    model = Model()
    known = read_libraries(path, contents.libraries, model, where)
    vertices = _VertexRows(
        _numbers(contents.positions, 3, "v", where),
        _numbers(contents.uvs, 2, "vt", where),
        _numbers(contents.normals, 3, "vn", where),
        *_colors(contents.positions, where),
    )
    missing = []
    for name, group in contents.groups.items():
        entry = material_called(known, name)
        mesh = _add_mesh(model, name, group, vertices, entry, where)
        if mesh is None:
            continue
        if entry is None:
            if name:
                missing.append(repr(name))
            plain = model.meshes[mesh].colors is None
            albedo = (0.8, 0.8, 0.8) if plain else (1.0, 1.0, 1.0)
            model.materials.append(Material(name=name or "default", albedo=albedo))
        else:
            model.materials.append(entry.material)
        model.objects.append(SceneObject(mesh, len(model.materials) - 1, name=name))
    if missing:
        model.note(f"no material library defines {some_names(missing)}: drawn grey")
    _add_points(model, contents, vertices, where)
    if contents.not_drawn:
        listed = ", ".join(counted(count, what) for what, count in contents.not_drawn.items())
        if not model.objects:
            raise SceneError(f"{where}: holds no triangle with an area, only {listed}")
        model.note(f"not drawn: {listed}")
    for index, turned, note in turned_to_scene(
        Surfaces(model.meshes, model.objects, model.materials)
    ):
        model.meshes[index] = turned
        model.note(note)
    return model


def _add_points(model: Model, contents: _Contents, vertices: _VertexRows, where: str) -> None:
    """Add the points of ``p`` elements, or all vertices where there is nothing else."""
    is_bare = not (contents.groups or contents.points or contents.not_drawn)
    rows = np.arange(len(vertices.positions) if is_bare else 0)
    if contents.points:
        try:
            rows = np.array(contents.points, dtype=np.int64) - 1
        except (ValueError, OverflowError):
            raise SceneError(f"{where}: a point is not the number of a vertex") from None
        if rows.min() < 0 or rows.max() >= len(vertices.positions):
            raise SceneError(f"{where}: a point refers to a v that does not exist")
    colors = vertices.colors[rows] if np.any(vertices.colored[rows]) else None
    mesh = model.add_points(vertices.positions[rows], colors) if len(rows) else None
    if mesh is not None:
        grey = 0.8 if colors is None else 1.0
        model.materials.append(Material(name="points", albedo=(grey, grey, grey)))
        model.objects.append(SceneObject(mesh, len(model.materials) - 1, name="points"))


@dataclass(frozen=True)
class _VertexRows:
    """What faces refer to; `colored` says which vertices the file gives a colour."""

    positions: FloatArray
    uvs: FloatArray
    normals: FloatArray
    colors: FloatArray
    colored: NDArray[np.bool_]


def _add_mesh(
    model: Model,
    name: str,
    group: _MaterialFaces,
    vertices: _VertexRows,
    entry: MtlMaterial | None,
    where: str,
) -> int | None:
    """Add the faces of one material; return the mesh's index, or None if nothing is left."""
    counts = (len(vertices.positions), len(vertices.uvs), len(vertices.normals))
    corners = _corners(group, counts, model, where)
    flat = np.array(group.corners, dtype=np.int64)
    order, _ = triangulated(vertices.positions[corners[:, 0]], flat, np.array(group.counts))
    corners, triangles, normals = _with_normals(corners, flat[order], vertices)
    vertex, uv, _ = corners.T
    uvs = second_uvs = None
    if np.any(uv >= 0):
        # Corners without coordinates show the image's origin.
        own = np.where(uv[:, None] >= 0, vertices.uvs[uv], 0.0)
        uvs = _downward(own if entry is None else entry.placement.placed(own))
        if entry is not None and entry.second_placement is not None:
            second_uvs = _downward(entry.second_placement.placed(own))
    colors = vertices.colors[vertex] if np.any(vertices.colored[vertex]) else None
    points = vertices.positions[vertex]
    return model.add_mesh(
        Mesh(points, triangles, normals, uvs, colors, name=name, second_uvs=second_uvs)
    )


def _downward(uvs: FloatArray) -> FloatArray:
    """Return texture coordinates as rows of images count: downward from the top."""
    return uvs * [1.0, -1.0] + [0.0, 1.0]


def _parse(path: Path, where: str) -> _Contents:
    contents = _Contents()
    group: _MaterialFaces | None = None
    material = ""
    rows = {"v": contents.positions, "vt": contents.uvs, "vn": contents.normals}
    for number, line in logical_lines(path, where):
        words = (_NOT_FINITE.sub("nan", line).split("#", 1)[0] if "#" in line else line).split()
        if not words:
            continue
        key = words[0]
        if key in rows:
            rows[key].append(words[1:])
        elif key in ("f", "fo"):
            if len(words) < 4:
                contents.not_drawn["line"] = contents.not_drawn.get("line", 0) + 1
                continue
            if group is None:
                group = contents.groups.setdefault(material, _MaterialFaces())
            _add_face(group, words[1:], contents, f"{where}: line {number}")
        elif key == "usemtl":
            # A name may hold "#", as those of 3ds Max do.
            material = remainder(line)
            group = contents.groups.setdefault(material, _MaterialFaces())
        elif key == "mtllib":
            contents.libraries.append(remainder(line))
        elif key == "p":
            place = f"{where}: line {number}"
            # Some write texture coordinates or normals behind, as in faces.
            corners = (
                _absolute(word, contents, place) if "-" in word else word for word in words[1:]
            )
            contents.points += [corner.split("/", 1)[0] for corner in corners]
        elif key in _NOT_DRAWN:
            what = _NOT_DRAWN[key]
            contents.not_drawn[what] = contents.not_drawn.get(what, 0) + 1
    contents.groups = {name: g for name, g in contents.groups.items() if g.counts}
    return contents


def _add_face(group: _MaterialFaces, words: list[str], contents: _Contents, where: str) -> None:
    index = group.corner_of_text
    words = [_absolute(word, contents, where) if "-" in word else word for word in words]
    group.corners += [index.setdefault(word, len(index)) for word in words]
    group.counts.append(len(words))


def _absolute(word: str, contents: _Contents, where: str) -> str:
    """Replace indices that count backwards from the current line by positive ones."""
    counts = (len(contents.positions), len(contents.uvs), len(contents.normals))
    parts = word.split("/")
    try:
        numbers = [int(part) if part else 0 for part in parts]
    except ValueError:
        raise SceneError(f"{where}: {word[:40]!r} is not a face corner such as 1/2/3") from None
    return "/".join(
        str(count + 1 + n) if n < 0 else part
        for n, part, count in zip(numbers, parts, counts, strict=False)
    )


def _corners(
    group: _MaterialFaces, counts: tuple[int, int, int], model: Model, where: str
) -> NDArray[np.int64]:
    """Return (C, 3) zero-based indices of position, uv and normal; -1 where absent."""
    result = np.full((len(group.corner_of_text), 3), -1, dtype=np.int64)
    for row, text in enumerate(group.corner_of_text):
        parts = text.split("/")
        try:
            numbers = [int(part) if part else 0 for part in parts]
        except ValueError:
            numbers = []
        if not 1 <= len(numbers) <= 3:
            raise SceneError(f"{where}: {text[:40]!r} is not a face corner such as 1/2/3")
        if not 1 <= numbers[0] <= counts[0]:
            raise SceneError(f"{where}: a face refers to v {numbers[0]}, but there are {counts[0]}")
        for column, number in enumerate(numbers):
            if 1 <= number <= counts[column]:
                result[row, column] = number - 1
            elif parts[column]:
                what = ("", "texture coordinates", "normals")[column]
                model.note(f"faces refer to {what} that do not exist: drawn without")
    return result


def _with_normals(
    corners: NDArray[np.int64], triangles: NDArray[np.int64], vertices: _VertexRows
) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray | None]:
    """Return corners, triangles and corner normals; triangles that lack some are flat."""
    index = corners[:, 2]
    if np.all(index < 0):
        return corners, triangles, None
    normals = vertices.normals[index]
    flat = np.any(index[triangles] < 0, axis=1)
    if np.any(flat):
        # They get a vertex of their own at each corner.
        apart = triangles[flat]
        triangles = triangles.copy()
        triangles[flat] = len(corners) + np.arange(apart.size).reshape(-1, 3)
        a, b, c = (vertices.positions[corners[apart[:, i], 0]] for i in range(3))
        corners = np.concatenate([corners, corners[apart.reshape(-1)]])
        with np.errstate(invalid="ignore", over="ignore"):  # dropped or replaced later
            normals = np.concatenate([normals, np.repeat(np.cross(b - a, c - a), 3, axis=0)])
    return corners, triangles, normals


def _colors(rows: list[list[str]], where: str) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return linear vertex colours (V, 4), white where a line has none, and which have one."""
    colored = np.array([len(row) >= 6 for row in rows], dtype=bool)
    colors = np.ones((len(rows), 4))
    if np.any(colored):
        encoded = _numbers([row for row in rows if len(row) >= 6], 6, "v", where)[:, 3:]
        colors[colored] = linear_colors(encoded)
    return colors, colored


def _numbers(rows: list[list[str]], count: int, key: str, where: str) -> FloatArray:
    """Return the first `count` numbers of each row, missing ones of vt as zero."""
    if key == "vt":
        rows = [[*row, "0", "0"][:2] for row in rows]
    try:
        array = np.array([row[:count] for row in rows], dtype=np.float64)
    except ValueError:
        bad = next((row for row in rows if not _are_numbers(row[:count], count)), [])
        text = " ".join([key, *bad])[:60]
        raise SceneError(
            f"{where}: {text!r}: expected {count} numbers after {key!r}{comma_hint(text)}"
        ) from None
    if rows and array.shape[1] != count:
        text = " ".join([key, *rows[0]])[:60]
        raise SceneError(f"{where}: {text!r}: expected {count} numbers after {key!r}")
    return array.reshape(-1, count)


def _are_numbers(words: list[str], count: int) -> bool:
    try:
        return len([float(word) for word in words]) == count
    except ValueError:
        return False
