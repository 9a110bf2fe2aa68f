"""Reader of .mtl material libraries of Wavefront .obj files."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.color import RGB_FROM_XYZ
from ssdo_gl.scene.files import contained_file
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.obj.gloss import gloss_fields, gloss_maps
from ssdo_gl.scene.formats.obj.maps import (
    Map,
    Placement,
    finite_number,
    is_cut_out,
    masked,
    read_map,
)
from ssdo_gl.scene.formats.obj.obj_text import logical_lines, remainder, without_comment
from ssdo_gl.scene.material import Color, Material
from ssdo_gl.scene.numbers import LARGEST_NUMBER
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.wording import comma_hint

# Cut-out masks of .mtl files carry no threshold of their own.
CUTOFF = 0.5


@dataclass(frozen=True)
class MtlMaterial:
    """A material, and where its images lie.

    Attributes
    ----------
    second_placement : Placement or None
        Of the images of `Material.second_uvs`, if any.
    """

    material: Material
    placement: Placement
    second_placement: Placement | None


def read_libraries(
    owner: Path, statements: list[str], model: Model, where: str
) -> dict[str, MtlMaterial]:
    """Return the materials of the libraries that an .obj file names, by their names.

    A library or texture that is missing or damaged is noted in `model`, not an error:
    models are often passed on without them.

    Parameters
    ----------
    statements : list of str
        What follows each ``mtllib``: one file name with or without blanks, or several.

    Raises
    ------
    SceneError
        If a material has a colour that is none.
    """
    known: dict[str, MtlMaterial] = {}
    for statement in dict.fromkeys(statements):
        for name in _library_names(owner, statement):
            try:
                path = _found(owner, name, f"{where}: mtllib")
                known.update(_read_library(path, model, f"{where}: {path.name}"))
            except _MissingError as error:
                model.note(f"materials not read: {error}")
    return known


def material_called(known: dict[str, MtlMaterial], name: str) -> MtlMaterial | None:
    """Return a material; a comment may follow its name where it is used or defined."""
    if name in known or not name:
        return known.get(name)
    short = without_comment(name)
    if short in known or not short:
        return known.get(short)
    return next((m for title, m in known.items() if without_comment(title) == short), None)


class _MissingError(ValueError):
    """A file that is not there or cannot be read, as one line."""


def _found(owner: Path, name: str, where: str) -> Path:
    """Return the file of this name, with or without quotes or a comment behind it."""
    first: SceneError | None = None
    for candidate in dict.fromkeys((name, name.strip('"'), without_comment(name).strip('"'))):
        try:
            return contained_file(owner, candidate, where)
        except SceneError as error:
            first = first or error
    raise _MissingError(str(first)) from None


def _library_names(owner: Path, statement: str) -> list[str]:
    """Return the one file that a statement names, or else each that ends in .mtl."""
    try:
        _found(owner, statement, "")
        return [statement]
    except _MissingError:
        return re.split(r"(?<=\.mtl)\s+", without_comment(statement), flags=re.IGNORECASE)


def _read_library(path: Path, model: Model, where: str) -> dict[str, MtlMaterial]:
    blocks: dict[str, dict[str, str]] = {}
    current: dict[str, str] = {}
    try:
        lines = list(logical_lines(path, where))
    except SceneError as error:
        raise _MissingError(str(error)) from None
    for _, line in lines:
        key = (line.split(None, 1) or ["#"])[0].lower()
        if key == "newmtl":
            current = blocks.setdefault(remainder(line), {})
        elif not key.startswith("#"):
            current[key] = remainder(line)
    return {title: _material(title, block, path, model, where) for title, block in blocks.items()}


def _words(block: dict[str, str], key: str) -> list[str]:
    return without_comment(block.get(key, "")).split()


def _material(
    name: str, block: dict[str, str], owner: Path, model: Model, where: str
) -> MtlMaterial:
    def found(file: str) -> Path:
        return _found(owner, file, f"{where}: texture")

    colors, mask, glow = (
        read_map(block.get(key), found, model, where) for key in ("map_kd", "map_d", "map_ke")
    )
    albedo = _color(block, "kd", (0.8, 0.8, 0.8), name, model, where)
    if colors is not None and not any(albedo):
        albedo = (1.0, 1.0, 1.0)
        model.note(f"material {name!r}: Kd 0 would hide its texture: taken as 1")
    if max(albedo) > 1.0:
        albedo = math3d.vector(np.minimum(albedo, 1.0))
        model.note(f"material {name!r}: Kd above 1 taken as 1")
    cut_out = mask is not None or (colors is not None and is_cut_out(colors.texture, CUTOFF))
    if mask is not None:
        if colors is not None and colors.placement != mask.placement:
            model.note(f"material {name!r}: its map_d lies where its map_Kd does")
        colors = masked(colors, mask, model)
    emission = _color(
        block, "ke", (0.0, 0.0, 0.0) if glow is None else (1.0, 1.0, 1.0), name, model, where
    )
    maps = gloss_maps(block, found, model, where)
    maps |= {"albedo": colors} if colors is not None else {}
    maps |= {"emission": glow} if glow is not None else {}
    first, second = _places(maps, name, model)
    opacity = _opacity(block)
    if "disp" in block:
        model.asks_for("displacement", name)
    fields: dict[str, Any] = {"albedo": albedo, **_gloss(name, block, albedo, maps, model, where)}
    fields |= {f"{image}_texture": entry.texture for image, entry in maps.items()}
    material = Material(
        name=name,
        emission=emission,
        alpha_cutoff=CUTOFF if cut_out else None,
        alpha=1.0 if cut_out else opacity,
        blends=opacity < 1.0 and not cut_out,
        second_uvs=frozenset(image for image in maps if maps[image].placement == second),
        **fields,
    )
    return MtlMaterial(material, first, second)


def _gloss(
    name: str,
    block: dict[str, str],
    albedo: Color,
    maps: dict[str, Map],
    model: Model,
    where: str,
) -> dict[str, Any]:
    numbers: dict[str, float] = {
        key: _last_number(block, key) for key in ("ns", "pr", "pm", "illum") if key in block
    }
    # A number that is not said beside its image counts in full.
    for key in ("pr", "pm"):
        if f"map_{key}" in block:
            numbers.setdefault(key, 1.0)
    specular = _color(block, "ks", (0.0, 0.0, 0.0), name, model, where) if "ks" in block else None
    return gloss_fields(numbers, albedo, specular, maps)


def _places(maps: dict[str, Map], name: str, model: Model) -> tuple[Placement, Placement | None]:
    """Return where the images lie, that of the albedo first, and the other place if any."""
    order = ("albedo", "emission", *maps)
    places = list(dict.fromkeys(maps[image].placement for image in order if image in maps))
    if len(places) > 2:
        model.note(f"material {name!r}: a third placement of its images (-o, -s) is not drawn")
    return places[0] if places else Placement(), places[1] if len(places) > 1 else None


def _opacity(block: dict[str, str]) -> float:
    """Return what `d` or `Tr` says; 0, which would hide the surface, is taken as 1."""
    found = [_last_number(block, "d")] if "d" in block else []
    found += [1.0 - _last_number(block, "tr")] if "tr" in block else []
    return min([value for value in found if value > 0.0] + [1.0])


def _last_number(block: dict[str, str], key: str) -> float:
    """Return the number of a statement, whose options stand before it; 0 if it is none."""
    return finite_number((_words(block, key) or ["0"])[-1]) or 0.0


def _color(
    block: dict[str, str], key: str, default: Color, name: str, model: Model, where: str
) -> Color:
    """Return a colour statement's value: one number or three, or three of CIE XYZ."""
    if key not in block:
        return default
    words = _words(block, key)
    if words[:1] == ["spectral"]:
        model.note(f"material {name!r}: spectral {key.capitalize()} is not read")
        return default
    xyz = words[:1] == ["xyz"]
    try:
        numbers = [float(word) for word in words[xyz : 3 + xyz]]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        numbers *= 3
    if len(numbers) != 3 or not all(0.0 <= n <= LARGEST_NUMBER for n in numbers):
        shown = " ".join([key.capitalize(), *words])[:80]
        raise SceneError(
            f"{where}: {shown!r}: expected three finite numbers >= 0{comma_hint(shown)}"
        )
    if xyz:
        numbers = np.maximum(RGB_FROM_XYZ @ numbers, 0.0).tolist()
    return numbers[0], numbers[1], numbers[2]
