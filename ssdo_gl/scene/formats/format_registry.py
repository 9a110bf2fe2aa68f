"""Which file formats there are: one row each, found by suffix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ssdo_gl.scene.files import check_file
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.scene import Scene, SceneError
from ssdo_gl.settings.loading import USUAL, LoadOptions

ModelReader = Callable[[Path, str], Model]
SceneReader = Callable[[Path, str, LoadOptions], Scene]


@dataclass(frozen=True)
class SceneFormat:
    """A kind of file that shows something.

    Attributes
    ----------
    title : str
        What errors and texts call it.
    suffixes : tuple of str
        With the dot, in lower case.
    read_model, read_scene : callable or None
        Exactly one of them. Given the path and what errors call the file, it returns
        its contents, which scenes may place; or, if the format describes whole scenes,
        that scene, completed by the options. It raises SceneError for what cannot be read.
    scan_up : "y", "z" or None
        Of formats of scans, smooth unless files have normals: the axis that usually points
        up. None: the format says +y.
    """

    title: str
    suffixes: tuple[str, ...]
    read_model: ModelReader | None = None
    read_scene: SceneReader | None = None
    scan_up: str | None = None


def _lazily(folder: str, function: str) -> Callable[..., Any]:
    """Return a reader of this package; its parsers are imported when it is first called."""

    def read(*arguments: Any, **named: Any) -> Any:
        module = import_module(f"ssdo_gl.scene.formats.{folder}")
        return getattr(module, function)(*arguments, **named)

    return read


FORMATS: list[SceneFormat] = [
    SceneFormat("TOML scene", (".toml",), read_scene=_lazily("toml", "read_file")),
    SceneFormat("glTF 2.0", (".glb", ".gltf"), _lazily("gltf", "read_gltf")),
    SceneFormat("Wavefront OBJ", (".obj",), _lazily("obj", "read_obj")),
    SceneFormat("PLY", (".ply",), _lazily("polygons", "read_ply"), scan_up="y"),
    SceneFormat("STL", (".stl",), _lazily("polygons", "read_stl"), scan_up="z"),
    SceneFormat("OFF", (".off",), _lazily("polygons", "read_off"), scan_up="y"),
]

# What the built-in scenes are written in, from text that need not be in a file.
read_description: Callable[..., Scene] = _lazily("toml", "read_description")


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
        raise SceneError(f"{where}: {path.name!r} holds no triangle with an area{more}")
    model.shade(normals or ("scan" if kind.scan_up else "file"), crease_angle)
    return model
