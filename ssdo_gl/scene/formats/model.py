"""What an importer returns, and how it joins a scene."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.file_camera import FileCamera
from ssdo_gl.scene.files import MAX_MODEL_TEXELS, read_texture
from ssdo_gl.scene.formats.point_bodies import point_bodies
from ssdo_gl.scene.geometry import Mesh, SceneObject, cleaned_mesh, smoothed
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material, Texture, Wrap

# Of all meshes of a model file. What scans reach; in memory some 5 GiB.
MAX_TRIANGLES = 1 << 25


class Vertices(NamedTuple):
    """Positions (V, 3), normals (V, 3) and tangents (V, 4) of a mesh, as `Mesh` has them."""

    positions: FloatArray
    normals: FloatArray | None = None
    tangents: FloatArray | None = None


@dataclass
class Model:
    """The contents of a model file; indices refer to its own lists."""

    meshes: list[Mesh] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    objects: list[SceneObject] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    cameras: list[FileCamera] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    triangle_count: int = 0
    _texel_count: int = 0
    _textures: dict[tuple[Path, Wrap], Texture] = field(default_factory=dict)
    _derived: dict[Hashable, Texture] = field(default_factory=dict)
    _bodies: set[int] = field(default_factory=set)
    _dropped: dict[str, int] = field(default_factory=dict)
    _beyond: dict[str, list[str]] = field(default_factory=dict)

    def add_mesh(
        self, raw: Mesh, vertices_at: Callable[[float], Vertices] | None = None
    ) -> int | None:
        """Clean and add a mesh; return its index, or None if nothing was left.

        Parameters
        ----------
        raw : Mesh
            What `cleaned_mesh` takes.
        vertices_at : callable or None
            Of a mesh that changes its shape: what it is at a time.

        Raises
        ------
        ValueError
            If a triangle names a vertex that does not exist, or there are too many.
        """
        self.triangle_count += len(raw.triangles)
        if self.triangle_count > MAX_TRIANGLES:
            raise ValueError(f"{self.triangle_count} triangles: at most {MAX_TRIANGLES} in a file")
        cleaned = cleaned_mesh(raw)
        for what, count in (
            ("triangles with NaN or infinite corners dropped", cleaned.not_finite),
            ("triangles without area dropped", cleaned.zero_area),
            ("unusable vertex normals replaced by face normals", cleaned.bad_normals),
        ):
            self.drop(what, count)
        if cleaned.mesh is None:
            return None
        mesh = cleaned.mesh
        if vertices_at is not None:

            def pose(seconds: float) -> Mesh | None:
                moved = dataclasses.replace(raw, **vertices_at(seconds)._asdict())
                return cleaned_mesh(moved, mesh.closed).mesh

            mesh = dataclasses.replace(mesh, pose=pose)
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def add_points(
        self, positions: FloatArray, colors: FloatArray | None = None, name: str = ""
    ) -> int | None:
        """Add points as small bodies; return their mesh's index, or None if there are none.

        Raises
        ------
        ValueError
            As `add_mesh` does.
        """
        vertices, triangles, colored, note = point_bodies(positions, colors)
        index = self.add_mesh(Mesh(vertices, triangles, colors=colored, name=name))
        if index is not None:
            self.note(note)
            self._bodies.add(index)
        return index

    def shade(self, normals: str, crease_angle: float) -> None:
        """Make the normals of the meshes smooth, flat or those of the file.

        Parameters
        ----------
        normals : "smooth", "flat", "file" or "scan"
            Of a scan, smooth where the file has none.
        crease_angle : float
            Degrees, [0, 180].
        """
        for index, mesh in enumerate(self.meshes):
            # Those that change their shape have new ones at any time, from their file.
            if normals == "flat" and mesh.pose is None:
                self.meshes[index] = dataclasses.replace(mesh, normals=None, tangents=None)
            is_bare = mesh.normals is None and index not in self._bodies
            is_wanted = normals == "smooth" or (normals == "scan" and is_bare)
            if is_wanted and mesh.pose is None:
                self.meshes[index] = smoothed(mesh, crease_angle)

    def texture(
        self, source: Path | bytes, where: str, name: str = "", wrap: Wrap = "repeat"
    ) -> Texture:
        """Read an image; the same file once. Errors are SceneError, as `read_texture`'s."""
        if isinstance(source, Path) and (source, wrap) in self._textures:
            return self._textures[source, wrap]
        left = MAX_MODEL_TEXELS - self._texel_count
        texture = read_texture(source, where, name, (wrap, wrap), left)
        self._texel_count += texture.pixels.shape[0] * texture.pixels.shape[1]
        if isinstance(source, Path):
            self._textures[source, wrap] = texture
        return texture

    def derived(self, key: Hashable, make: Callable[[], Texture]) -> Texture:
        """Return a texture that is made of others, named by `key`; the same ones once."""
        if key not in self._derived:
            self._derived[key] = make()
        return self._derived[key]

    def drop(self, what: str, count: int = 1) -> None:
        """Count what is left out, for a note such as "3 lines are not drawn"."""
        if count:
            self._dropped[what] = self._dropped.get(what, 0) + count

    def asks_for(self, feature: str, material: str) -> None:
        """Remember that `material` wants something that is not drawn."""
        users = self._beyond.setdefault(feature, [])
        if material not in users:
            users.append(material)

    def note(self, text: str) -> None:
        """Tell the user something, once."""
        if text not in self.notes:
            self.notes.append(text)

    def all_notes(self) -> list[str]:
        """Return every note, with counted and listed ones summed up in one line each."""
        result = list(self.notes)
        result += [f"{count} {what}" for what, count in self._dropped.items()]
        if self._beyond:
            listed = "; ".join(
                f"{feature} ({some_names(users)})" for feature, users in self._beyond.items()
            )
            result.append(f"drawn as the material beneath, without: {listed}")
        return result

    def add_to(self, builder: SceneBuilder, material: int | None = None) -> list[SceneObject]:
        """Append meshes and materials to a builder; return objects that refer to them.

        Parameters
        ----------
        material : int or None
            A material of the builder to use in place of the model's own.
        """
        first_mesh, first_material = len(builder.meshes), len(builder.materials)
        if material is None:
            builder.meshes += self.meshes
            is_shut = not builder.options.two_sided
            builder.materials += [
                dataclasses.replace(m, single_sided=m.single_sided and is_shut)
                for m in self.materials
            ]
        else:  # whose images all use the same coordinates, maybe not those of the tangents
            builder.meshes += [
                mesh.changed(lambda m: dataclasses.replace(m, second_uvs=None, tangents=None))
                for mesh in self.meshes
            ]
        for note in self.all_notes():
            builder.note(note)
        return [
            dataclasses.replace(
                item,
                mesh=item.mesh + first_mesh,
                material=item.material + first_material if material is None else material,
            )
            for item in self.objects
        ]


def some_names(names: list[str]) -> str:
    """Return the first names of a list, and how many more there are."""
    shown = ", ".join(name or "unnamed" for name in names[:3])
    return shown if len(names) <= 3 else f"{shown} and {len(names) - 3} more"
