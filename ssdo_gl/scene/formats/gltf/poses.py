"""The shape of a glTF primitive under its morph targets and joints, at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import GltfError
from ssdo_gl.scene.formats.gltf.geometry import Shape
from ssdo_gl.scene.formats.gltf.rig import Rig, Skin
from ssdo_gl.scene.formats.model import Vertices


@dataclass(frozen=True, eq=False)
class Poses:
    """What shapes a mesh.

    Attributes
    ----------
    weights : ndarray, shape (T,)
        Of its morph targets, where they are not animated.
    weighing_node : int or None
        The node whose animation gives the weights.
    """

    rig: Rig
    weights: FloatArray
    weighing_node: int | None
    skin: Skin | None

    def is_morphed(self) -> list[bool]:
        """Return which morph targets ever have a weight."""
        if self.weighing_node is None:
            return [weight != 0.0 for weight in self.weights]
        return [True] * len(self.rig.weights_at(self.weighing_node, 0.0))

    def check(self, shape: Shape) -> None:
        """Raise GltfError if a vertex refers to a joint that the skin lacks."""
        if self.skin is not None and shape.joints is not None:
            last, count = int(shape.joints.max(initial=0)), len(self.skin.joints)
            if last >= count:
                raise GltfError(f"a vertex refers to joint {last} of {count}")

    def moves(self, shape: Shape) -> bool:
        """Return whether `shape` changes with time."""
        is_skinned = self.skin is not None and shape.joints is not None and self.skin.moves
        return is_skinned or (self.weighing_node is not None and bool(shape.targets))

    def of(self, shape: Shape, seconds: float) -> Vertices:
        """Return the vertices, in the world if there is a skin."""
        weights = self.weights
        if self.weighing_node is not None:
            weights = self.rig.weights_at(self.weighing_node, seconds)
        # Numbers that overflow on the way are dropped where they end up.
        with np.errstate(all="ignore"):
            vertices = shape.morphed(weights.tolist())
            if self.skin is None or shape.joints is None:
                return vertices
            return shape.skinned(vertices, self.skin.matrices_at(seconds))

    def rest(self, shape: Shape) -> Vertices:
        """Return `of` at time 0, or when the shape first has an area."""
        looks = self.rig.looks if self.moves(shape) else [0.0]
        for seconds in looks:
            vertices = self.of(shape, seconds)
            places = vertices.positions
            if len(places) and np.count_nonzero(np.ptp(places, axis=0)) > 1:
                return vertices
        return self.of(shape, 0.0)
