"""Importer of single meshes without scene structure: .ply .stl .off, through trimesh."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh.exchange.off import load_off
from trimesh.exchange.ply import load_ply
from trimesh.exchange.stl import load_stl
from trimesh.geometry import triangulate_quads

from ssdo_gl.images.color import linear_from_srgb
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import SceneError

# trimesh's parsers return what the file holds; its Trimesh class would invent the
# vertex normals that the file has not.
_PARSERS = {".ply": load_ply, ".stl": load_stl, ".off": load_off}


def read_polygons(path: Path, where: str) -> Model:
    """Return the one mesh (or, for ASCII .stl, the solids) of the file.

    Raises
    ------
    SceneError
        If it cannot be read or parsed.
    """
    suffix = path.suffix.lower()
    try:
        data = path.read_bytes()
        with warnings.catch_warnings():
            # NumPy warns about text that does not parse; a short array follows, which
            # the checks below report.
            warnings.simplefilter("ignore")
            parsed = _PARSERS[suffix](io.BytesIO(data))
    except MemoryError:
        raise SceneError(f"{where}: its header asks for more memory than there is") from None
    except Exception as error:  # the parsers raise whatever the damage leads to
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise SceneError(f"{where}: not a readable {suffix[1:].upper()} file: {reason}") from None
    model = Model()
    solids = parsed.get("geometry") if "vertices" not in parsed else {path.stem: parsed}
    for name, solid in (solids or {}).items():
        try:
            _add_solid(model, solid, str(name))
        except (ValueError, TypeError, KeyError, IndexError) as error:
            reason = " ".join(str(error).split())[:120]
            raise SceneError(f"{where}: damaged {suffix[1:].upper()} file: {reason}") from None
    return model


def _add_solid(model: Model, solid: dict[str, Any], name: str) -> None:
    if solid.get("faces") is None:
        return  # a point cloud
    positions = np.asarray(solid["vertices"], dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(triangulate_quads(solid["faces"]), dtype=np.int64).reshape(-1, 3)
    normals = solid.get("vertex_normals")
    uvs = getattr(solid.get("visual"), "uv", None)
    colors = _linear_colors(solid.get("vertex_colors"), len(positions))
    if colors is None:
        face_colors = _linear_colors(solid.get("face_colors"), len(solid["faces"]))
        if face_colors is not None and len(face_colors) == len(faces):
            # Colours that belong to faces need a vertex of their own at each corner.
            positions = positions[faces.reshape(-1)]
            normals = None if normals is None else np.asarray(normals)[faces.reshape(-1)]
            uvs = None
            colors = np.repeat(face_colors, 3, axis=0)
            faces = np.arange(3 * len(faces)).reshape(-1, 3)
    mesh = model.add_mesh(
        positions,
        faces,
        None if normals is None else np.asarray(normals, dtype=np.float64),
        # Image rows count downward from the top, these formats' v upward.
        None if uvs is None else np.asarray(uvs, dtype=np.float64) * [1.0, -1.0] + [0.0, 1.0],
        colors,
        name,
    )
    if mesh is None:
        return
    white = (1.0, 1.0, 1.0) if colors is not None else (0.8, 0.8, 0.8)
    model.materials.append(Material(name="default", albedo=white))
    model.objects.append(SceneObject(mesh, len(model.materials) - 1, name=name))


def _linear_colors(colors: NDArray[Any] | None, count: int) -> FloatArray | None:
    """Return (count, 4) linear colour and alpha from sRGB bytes or 0..1 floats."""
    if colors is None or np.ndim(colors) != 2 or len(colors) != count:
        return None
    array = np.asarray(colors)
    scale = float(np.iinfo(array.dtype).max) if np.issubdtype(array.dtype, np.integer) else 1.0
    values = array.astype(np.float64) / scale
    alpha = values[:, 3:4] if values.shape[1] > 3 else np.ones((count, 1))
    return np.concatenate([linear_from_srgb(values[:, :3]), alpha], axis=1)
