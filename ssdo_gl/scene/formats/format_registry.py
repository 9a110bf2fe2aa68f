"""Which file formats there are: those that modules and folders beside this one define."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.package_members import modules_in
from ssdo_gl.scene.files import check_file
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.scene_format import SceneFormat
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.loading import USUAL


def found_formats() -> list[SceneFormat]:
    """Return what modules and folders of `ssdo_gl.scene.formats` define as a `SceneFormat`."""
    modules = modules_in("ssdo_gl.scene.formats")
    values = (value for module in modules for value in vars(module).values())
    return [value for value in values if isinstance(value, SceneFormat)]


FORMATS = found_formats()


def format_of(path: Path) -> SceneFormat | None:
    """Return the format that a file's suffix names, in small letters or capitals."""
    suffix = path.suffix.lower()
    return next((kind for kind in FORMATS if suffix in kind.suffixes), None)


def scene_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that describe a whole scene."""
    return tuple(suffix for kind in FORMATS if kind.read_scene for suffix in kind.suffixes)


def model_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that a scene may place."""
    return tuple(suffix for kind in FORMATS if kind.read_model for suffix in kind.suffixes)


def read_model(
    path: Path, where: str, normals: str | None = "file", crease_angle: float = USUAL.crease_angle
) -> Model:
    """Return the contents of a model file.

    Parameters
    ----------
    where : str
        What to call the file in errors.
    normals : "smooth", "flat", "file" or None
        How it is shaded; None: smooth, if it is a scan without normals, else as the file.
    crease_angle : float
        Degrees, [0, 180].

    Raises
    ------
    SceneError
        If it has another suffix, cannot be read or parsed, or holds no triangle.
    """
    kind = format_of(path)
    if kind is None or kind.read_model is None:
        raise SceneError(f"{where}: {path.name!r}: expected one of {', '.join(model_suffixes())}")
    check_file(path, where)
    model = kind.read_model(path, where)
    if not model.objects:
        found = "; ".join(model.all_notes())
        more = f" ({found})" if found else ""
        named = "" if where.endswith(path.name) else f"{path.name!r} "
        raise SceneError(f"{where}: {named}holds no triangle with an area{more}")
    model.shade(normals or ("scan" if kind.scan_up else "file"), crease_angle)
    return model
