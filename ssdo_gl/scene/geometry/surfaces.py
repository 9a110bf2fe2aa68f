"""All surfaces of a scene, as what looks for its camera, rooms and lamps takes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.topology import placed
from ssdo_gl.scene.material import Material


class Surfaces(NamedTuple):
    """Objects with the meshes and materials that they name by index.

    Without materials all of them have two sides.
    """

    meshes: Sequence[Mesh]
    objects: Sequence[SceneObject]
    materials: Sequence[Material] = ()

    def mesh(self, item: SceneObject) -> Mesh:
        return self.meshes[item.mesh]

    def material(self, item: SceneObject) -> Material:
        return self.materials[item.material]

    def is_single_sided(self, item: SceneObject) -> bool:
        return bool(self.materials) and self.material(item).single_sided

    def boxes(self) -> FloatArray:
        """Return the corners of every instance's box in world space, shape (N, 8, 3)."""
        boxes = [np.zeros((0, 8, 3))]
        for item in self.objects:
            low, high = self.mesh(item).bounds()
            corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, high, low)
            boxes.append(placed(corners, item.world_from_object))
        return np.concatenate(boxes)
