"""The nodes of a glTF document: who hangs on whom, where, and whether it shows."""

from __future__ import annotations

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, numbers
from ssdo_gl.scene.formats.gltf.ranges import Ranges
from ssdo_gl.settings.settings import LONGEST

_REST = {
    "translation": (0.0, 0.0, 0.0),
    "rotation": (0.0, 0.0, 0.0, 1.0),
    "scale": (1.0, 1.0, 1.0),
}


class NodeTree:
    """The nodes of a document's scene as the file places them.

    Attributes
    ----------
    visible : list of int
        Nodes that show, depth first.
    parents : dict of int to (int or None)
        Of every node of the scene, parents before their children.
    world : dict of int to ndarray, shape (4, 4)
    """

    def __init__(self, document: Document, ranges: Ranges) -> None:
        self.visible: list[int] = []
        self.parents: dict[int, int | None] = {}
        self.local: dict[int, FloatArray] = {}
        self.world: dict[int, FloatArray] = {}
        pending: list[tuple[int, int | None, bool]] = [
            (root, None, True) for root in reversed(_roots(document))
        ]
        while pending:
            index, parent, shown = pending.pop()
            node = document.entry("nodes", index)
            if index in self.parents:
                raise GltfError(
                    f"node {index} has two parents, or is within itself:"
                    " in glTF each node hangs on one other at most"
                )
            local = local_matrix(node, f"node {index}")
            if "matrix" not in node and not any(node.get("rotation", [1.0])):
                ranges.replaced("rotation [0, 0, 0, 0] as none", f"node {index}")
            world = local if parent is None else self.world[parent] @ local
            if not np.all(np.abs(world) <= LONGEST):
                raise GltfError(f"node {index} lies or reaches beyond {LONGEST:g}")
            self.parents[index], self.local[index], self.world[index] = parent, local, world
            visibility = node.get("extensions", {}).get("KHR_node_visibility", {})
            shown = shown and visibility.get("visible", True) is not False
            if shown:
                self.visible.append(index)
            pending += [(child, index, shown) for child in reversed(node.get("children", []))]


def _roots(document: Document) -> list[int]:
    json = document.json
    if "scenes" in json:
        roots: list[int] = document.entry("scenes", json.get("scene", 0)).get("nodes", [])
        return roots
    nodes = json.get("nodes", [])
    children = {child for node in nodes for child in node.get("children", [])}
    return [index for index in range(len(nodes)) if index not in children]


def placement(node: Json, where: str) -> dict[str, FloatArray]:
    """Return translation, rotation (x, y, z, w) and scale of a node."""
    found = {name: numbers(node, name, rest, where) for name, rest in _REST.items()}
    if not found["rotation"].any():
        found["rotation"] = np.array(_REST["rotation"])
    return found


def local_matrix(node: Json, where: str) -> FloatArray:
    """Return parent_from_node of a node: its matrix, or translation, rotation, scale."""
    if "matrix" in node:
        return np.ascontiguousarray(numbers(node, "matrix", [0.0] * 16, where).reshape(4, 4).T)
    return matrix_of(placement(node, where))


def matrix_of(place: dict[str, FloatArray]) -> FloatArray:
    """Return the (4, 4) matrix of a `placement`."""
    rows = (place[name][None] for name in ("translation", "rotation", "scale"))
    return np.asarray(matrices_of(*rows)[0])


def matrices_of(translation: FloatArray, rotation: FloatArray, scale: FloatArray) -> FloatArray:
    """Return matrices (N, 4, 4) from translations, quaternions (x, y, z, w) and scales.

    A quaternion of zero length or infinite parts gives a matrix of NaN.
    """
    matrices = np.zeros((len(translation), 4, 4))
    x, y, z, w = (rotation / np.linalg.norm(rotation, axis=1, keepdims=True)).T
    matrices[:, 0, :3] = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1
    )
    matrices[:, 1, :3] = np.stack(
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1
    )
    matrices[:, 2, :3] = np.stack(
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1
    )
    matrices[:, :3, :3] *= scale[:, None, :]
    matrices[:, :3, 3] = translation
    matrices[:, 3, 3] = 1.0
    return matrices
