"""Model files of others: .glb .gltf .obj .ply .stl .off -> Model."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.scene import SceneError

SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off")


def read_model(path: Path, where: str) -> Model:
    """Return the contents of a model file.

    Parameters
    ----------
    path : Path
    where : str
        What to call the file in errors.

    Raises
    ------
    SceneError
        If it has another suffix, cannot be read or parsed, or holds no triangle.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SceneError(f"{where}: {path.name!r}: expected one of {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise SceneError(f"{where}: no such file: {str(path)!r}")
    # Each importer brings its parser; only the one that is needed is imported.
    if suffix in (".glb", ".gltf"):
        from ssdo_gl.scene.formats.gltf import read_gltf as read
    elif suffix == ".obj":
        from ssdo_gl.scene.formats.wavefront import read_obj as read
    else:
        from ssdo_gl.scene.formats.polygons import read_polygons as read
    model = read(path, where)
    if not model.objects:
        raise SceneError(f"{where}: {path.name!r} holds no triangle with an area")
    return model
