"""What the polygon formats have in common: numbers of a text, a mesh on its way into a model."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.files import contained_file
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.triangulate import triangulated
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.wording import comma_hint


def numbers(text: bytes) -> NDArray[np.float64]:
    """Return all numbers of a text; line ends and blank lines count as spaces.

    Raises
    ------
    ValueError
        Naming the word that is no number.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=np.float64, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    # A slower look finds the word at fault, and forgives what C on Windows prints.
    words = text.split()
    result = np.empty(len(words))
    for index, word in enumerate(words):
        try:
            result[index] = float(word)
        except ValueError:
            if b"#" not in word:
                shown = word[:40].decode("latin-1")
                raise ValueError(
                    f"{shown!r} stands where a number is expected{comma_hint(shown)}"
                ) from None
            result[index] = np.nan
    return result


@dataclass
class PolygonMesh:
    """Polygons with what a file says of vertices, corners and faces.

    Attributes
    ----------
    positions, normals : ndarray, shape (V, 3)
    corners : ndarray, shape (C,)
        The vertex of each corner, polygon after polygon.
    counts : ndarray, shape (F,)
        Corners of each polygon; their sum is C.
    uvs : ndarray, shape (V, 2)
        Texture coordinates, v = 0 at the bottom row of the image, as files have it.
    corner_uvs : ndarray, shape (C, 2)
        The same for each corner; they win over `uvs`.
    colors : ndarray, shape (V, 4)
        Scene-linear colour and alpha.
    face_colors : ndarray, shape (F, 4)
        They count where there are no `colors`.
    textures : list of str
        Names of image files, relative to the mesh's.
    face_textures : ndarray, shape (F,)
        Which of them each face shows; None: all the first.
    notes : list of str
        What the user has to know of the file.
    """

    positions: FloatArray
    corners: NDArray[np.int64]
    counts: NDArray[np.int64]
    normals: FloatArray | None = None
    uvs: FloatArray | None = None
    corner_uvs: FloatArray | None = None
    colors: FloatArray | None = None
    face_colors: FloatArray | None = None
    textures: list[str] = field(default_factory=list)
    face_textures: NDArray[np.int64] | None = None
    name: str = ""
    notes: list[str] = field(default_factory=list)

    def add_to(self, model: Model, path: Path, where: str) -> None:
        """Append the triangles to a model, an object for each texture.

        Raises
        ------
        ValueError
            If a face names a vertex that does not exist.
        """
        triangles, polygons = triangulated(self.positions, self.corners, self.counts)
        shown = self.face_textures
        if shown is None or len(self.textures) < 2:
            self._add_part(model, triangles, polygons, self._texture(0, model, path, where), path)
            return
        shown = np.clip(shown, 0, len(self.textures) - 1)[polygons]
        for number in np.unique(shown):
            part = shown == number
            texture = self._texture(int(number), model, path, where)
            self._add_part(model, triangles[part], polygons[part], texture, path)

    def _texture(self, number: int, model: Model, path: Path, where: str) -> Texture | None:
        if number >= len(self.textures):
            return None
        # So MeshLab calls the model's own name.
        name = self.textures[number].replace("<this>", path.stem)
        try:
            file = contained_file(path, name, f"{where}: TextureFile")
            return model.texture(file, where)
        except SceneError as error:
            model.note(f"texture not used: {error}")
            return None

    def _add_part(
        self,
        model: Model,
        triangles: NDArray[np.int64],
        polygons: NDArray[np.int64],
        texture: Texture | None,
        path: Path,
    ) -> None:
        vertices = self.corners[triangles]
        face_colors = self.face_colors if self.colors is None else None
        positions, normals, uvs, colors = self.positions, self.normals, self.uvs, self.colors
        if face_colors is not None or self.corner_uvs is not None:
            # What belongs to faces or corners needs a vertex of its own at each corner.
            flat = vertices.reshape(-1)
            positions = positions[flat]
            normals = None if normals is None else normals[flat]
            uvs = None if uvs is None else uvs[flat]
            colors = None if colors is None else colors[flat]
            if face_colors is not None:
                colors = np.repeat(face_colors[polygons], 3, axis=0)
            if self.corner_uvs is not None:
                uvs = self.corner_uvs[triangles.reshape(-1)]
            vertices = np.arange(len(flat)).reshape(-1, 3)
        # Image rows count downward from the top.
        uvs = None if uvs is None else uvs * [1.0, -1.0] + [0.0, 1.0]
        name = self.name or path.stem
        mesh = model.add_mesh(Mesh(positions, vertices, normals, uvs, colors, name=name))
        if mesh is None:
            return
        plain = colors is None and texture is None
        albedo = (0.8, 0.8, 0.8) if plain else (1.0, 1.0, 1.0)
        model.materials.append(Material(name="default", albedo=albedo, albedo_texture=texture))
        model.objects.append(SceneObject(mesh, len(model.materials) - 1, name=name))
