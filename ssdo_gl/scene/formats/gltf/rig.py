"""The nodes of a glTF scene in time, and what they carry with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.animation import Channels
from ssdo_gl.scene.formats.gltf.document import Document, GltfError
from ssdo_gl.scene.formats.gltf.nodes import NodeTree, matrix_of, placement
from ssdo_gl.scene.geometry import with_area
from ssdo_gl.settings.settings import LONGEST

# Times at which something that has no size at first is looked at, so that it can grow.
_LOOKS = 16


class Rig:
    """Where every node is at a time.

    Parameters
    ----------
    channels : dict
        Of the animations that are played.
    """

    def __init__(self, document: Document, tree: NodeTree, channels: Channels) -> None:
        self._tree, self._channels = tree, channels
        nodes = {node for node, path in channels if path != "weights" and node in tree.parents}
        self._placements = {
            node: placement(document.entry("nodes", node), f"node {node}") for node in nodes
        }
        self._moving: dict[int, int | None] = {}
        for node, parent in tree.parents.items():
            if node in nodes or parent in self._moving:
                self._moving[node] = parent
        period = max((channel.period for channel in channels.values()), default=0.0)
        self.looks = [period * look / _LOOKS for look in range(_LOOKS if period else 1)]
        self._known: tuple[float, dict[int, FloatArray]] | None = None
        self._rest: dict[int, FloatArray] | None = None

    def moves(self, node: int) -> bool:
        """Return whether a node is ever anywhere else."""
        return node in self._moving

    def world_at(self, node: int, seconds: float) -> FloatArray:
        """Return world_from_node (4, 4): all zeros while that has no usable size."""
        if node not in self._moving:
            return self._tree.world.get(node, np.eye(4))
        if self._known is None or self._known[0] != seconds:
            self._known = seconds, self._worlds(seconds)
        return self._known[1][node]

    def _worlds(self, seconds: float) -> dict[int, FloatArray]:
        worlds: dict[int, FloatArray] = {}
        with np.errstate(all="ignore"):
            for node, parent in self._moving.items():
                local = self._tree.local[node]
                if node in self._placements:
                    place = dict(self._placements[node])
                    for path in place:
                        if (node, path) in self._channels:
                            place[path] = self._channels[node, path].at(seconds)
                    if not np.any(place["rotation"]):
                        place["rotation"] = np.array([0.0, 0.0, 0.0, 1.0])
                    local = matrix_of(place)
                if parent is not None:
                    local = worlds.get(parent, self._tree.world[parent]) @ local
                usable = np.all(np.abs(local) <= LONGEST)
                worlds[node] = local if usable else np.diag([0.0, 0.0, 0.0, 1.0])
        return worlds

    def rest(self, node: int) -> FloatArray:
        """Return world_from_node at time 0, or when it first has a size."""
        if node not in self._moving:
            return self._tree.world[node]
        if self._rest is None:
            self._rest = self._worlds(0.0)
            small = [n for n, world in self._rest.items() if not len(with_area(world[None]))]
            for look in self.looks[1:] if small else ():
                later = self._worlds(look)
                grown = [n for n in small if len(with_area(later[n][None]))]
                self._rest |= {n: later[n] for n in grown}
                small = [n for n in small if n not in grown]
        return self._rest[node]

    def has_weights(self, node: int) -> bool:
        """Return whether the morph targets of a node's mesh are animated."""
        return (node, "weights") in self._channels

    def weights_at(self, node: int, seconds: float) -> FloatArray:
        """Return the weights of the morph targets, shape (T,)."""
        return self._channels[node, "weights"].at(seconds)


@dataclass(frozen=True, eq=False)
class NodeMotion:
    """The motion of what hangs on a node, its size included.

    Attributes
    ----------
    rest : ndarray, shape (4, 4)
        world_from_node where it rests; has an inverse.
    """

    rig: Rig
    node: int
    rest: FloatArray
    is_rigid: bool = False

    def world_from_rest(self, seconds: float) -> FloatArray:
        """Return the (4, 4) matrix that moves the resting object to `seconds`."""
        world = self.rig.world_at(self.node, seconds)
        # At rest nothing is rounded.
        is_at_rest = np.array_equal(world, self.rest)
        return np.eye(4) if is_at_rest else np.asarray(world @ np.linalg.inv(self.rest))


@dataclass(frozen=True, eq=False)
class FrameMotion:
    """The motion of a light or camera on a node, whose scale does not count."""

    rig: Rig
    node: int
    is_rigid: bool = True

    def world_from_rest(self, seconds: float) -> FloatArray:
        """Return the (4, 4) rigid matrix that moves the resting light to `seconds`."""
        rest = np.linalg.inv(_frame(self.rig.world_at(self.node, 0.0)))
        return np.asarray(_frame(self.rig.world_at(self.node, seconds)) @ rest)


def _frame(world: FloatArray) -> FloatArray:
    """Return the rigid part (4, 4) of a node's matrix: its place, its z and nearly its y axis."""
    result = np.eye(4)
    result[:3, 3] = world[:3, 3]
    z, y = world[:3, 2], world[:3, 1]
    if np.any(np.cross(y, z)):
        z = math3d.normalized(z)
        x = math3d.normalized(np.cross(math3d.normalized(y), z))
        result[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    elif np.any(z):
        result[:3, :3] = math3d.frame_from_z(math3d.normalized(z))
    return result


@dataclass(frozen=True, eq=False)
class Skin:
    """Joints, and where the mesh was bound to them.

    Attributes
    ----------
    joints : sequence of int
        Nodes.
    inverse_bind : ndarray, shape (J, 4, 4), or None
    """

    rig: Rig
    joints: Sequence[int]
    inverse_bind: FloatArray | None

    @classmethod
    def read(cls, document: Document, rig: Rig, index: int) -> Skin:
        """Return a skin of the document."""
        entry = document.entry("skins", index)
        joints = [int(joint) for joint in entry["joints"]]
        for joint in joints:
            document.entry("nodes", joint)
        inverse = None
        if "inverseBindMatrices" in entry:
            rows = document.accessor(entry["inverseBindMatrices"], (16,))
            if len(rows) < len(joints):
                raise GltfError(f"skin {index} has {len(rows)} matrices for {len(joints)} joints")
            inverse = rows.reshape(-1, 4, 4)[: len(joints)].transpose(0, 2, 1)
        return cls(rig, joints, inverse)

    @property
    def moves(self) -> bool:
        """Whether any joint does."""
        return any(self.rig.moves(joint) for joint in self.joints)

    def matrices_at(self, seconds: float) -> FloatArray:
        """Return (J, 4, 4) matrices from the mesh to the world."""
        world = np.stack([self.rig.world_at(joint, seconds) for joint in self.joints])
        return world if self.inverse_bind is None else np.asarray(world @ self.inverse_bind)
