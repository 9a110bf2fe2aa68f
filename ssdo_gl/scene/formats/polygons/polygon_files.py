"""From the file to the model, whichever of the formats it has."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from ssdo_gl.scene.files import read_file
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.polygons.off import parse_off
from ssdo_gl.scene.formats.polygons.ply import parse_ply
from ssdo_gl.scene.formats.polygons.polygon_mesh import PolygonMesh
from ssdo_gl.scene.formats.polygons.stl import parse_stl
from ssdo_gl.scene.geometry import SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene_error import SceneError


def _read(title: str, parse: Callable[[bytes], list[PolygonMesh]], path: Path, where: str) -> Model:
    model = Model()
    points: list[PolygonMesh] = []
    try:
        # What is not finite is dropped and told later; NumPy need not warn as well.
        with np.errstate(invalid="ignore", over="ignore"):
            for mesh in parse(read_file(path, where)):
                mesh.add_to(model, path, where)
                model.notes += mesh.notes
                if not len(mesh.counts):
                    points.append(mesh)
            if not model.meshes:
                for mesh in points:
                    _add_points(mesh, model)
    except MemoryError:
        raise SceneError(f"{where}: larger than the memory there is") from None
    except ValueError as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{where}: not a readable {title} file: {error}") from None
    return model


def _add_points(mesh: PolygonMesh, model: Model) -> None:
    index = model.add_points(mesh.positions, mesh.colors, mesh.name)
    if index is not None:
        grey = 0.8 if mesh.colors is None else 1.0
        model.materials.append(Material(albedo=(grey, grey, grey)))
        model.objects.append(SceneObject(index, len(model.materials) - 1, name=mesh.name))


# The mesh of a file, or the solids of an STL; errors are SceneError.
read_ply = partial(_read, "PLY", parse_ply)
read_stl = partial(_read, "STL", parse_stl)
read_off = partial(_read, "OFF", parse_off)
