"""What an importer returns, and how it joins a scene."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.light import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import Mesh, SceneObject


@dataclass
class Model:
    """The contents of a model file; indices refer to its own lists.

    Attributes
    ----------
    one_sided : bool
        Whether the format defines which side of an emissive surface shines. Where
        it does not (OBJ), panels are turned toward what they can light.
    """

    meshes: list[Mesh] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    objects: list[SceneObject] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    notes: list[str] = field(default_factory=list)

    def add_to(self, builder: SceneBuilder, material: int | None = None) -> list[SceneObject]:
        """Append meshes and materials to a builder; return objects that refer to them.

        Parameters
        ----------
        material : int or None
            A material of the builder to use in place of the model's own.
        """
        first_mesh, first_material = len(builder.meshes), len(builder.materials)
        builder.meshes += self.meshes
        if material is None:
            builder.materials += self.materials
        for note in self.notes:
            builder.note(note)
        return [
            dataclasses.replace(
                item,
                mesh=item.mesh + first_mesh,
                material=item.material + first_material if material is None else material,
            )
            for item in self.objects
        ]
