"""Importer of glTF 2.0 (.gltf and .glb): nodes, meshes, cameras, lights.

Read here rather than by trimesh, which rounds colour factors and vertex colours to
eight bits, invents normals, and decodes images of any size.
Specification: Khronos glTF 2.0; extensions are named where they are read.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json
from ssdo_gl.scene.formats.gltf.geometry import Shape, read_shape
from ssdo_gl.scene.formats.gltf.materials import MaterialReader
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.lights import kind_of_gltf
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import SceneError

# Extensions that a file may declare as required; all others that a file requires
# change its geometry in ways not read here.
_UNDERSTOOD = {
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_texture_basisu",
}
FLOAT32_MAX = float(np.finfo(np.float32).max)
# Damage to the document's structure surfaces as one of these while it is walked.
_STRUCTURE_ERRORS = (
    KeyError,
    IndexError,
    TypeError,
    ValueError,
    AttributeError,
    OverflowError,
    RecursionError,
    np.linalg.LinAlgError,
)


def read_gltf(path: Path, where: str) -> Model:
    """Return the default scene of the file.

    Raises
    ------
    SceneError
        If it is damaged, or requires an extension that is not supported.
    """
    try:
        document = Document.load(path)
        _check_extensions(document)
        return _Reader(document, where).read()
    except SceneError:
        raise
    except GltfError as error:
        raise SceneError(f"{where}: {error}") from None
    except _STRUCTURE_ERRORS as error:
        reason = " ".join(str(error).split())[:120]
        raise SceneError(
            f"{where}: not valid glTF: {type(error).__name__.removesuffix('Error')} {reason}"
        ) from None


def _check_extensions(document: Document) -> None:
    for name in document.json.get("extensionsRequired", []):
        if name not in _UNDERSTOOD and not name.startswith("KHR_materials_"):
            raise GltfError(f"requires the extension {name!r}, which is not supported")


class _Reader:
    """Walks the nodes of one document and fills a Model."""

    def __init__(self, document: Document, where: str) -> None:
        self.document = document
        self.model = Model()
        self.materials = MaterialReader(document, self.model, where)
        # (mesh, primitive) -> mesh and material of the model, None if unusable.
        self._placed: dict[tuple[int, int, int], tuple[int, int] | None] = {}
        self._object_of: dict[tuple[int, int], int] = {}
        self._world: dict[int, FloatArray] = {}
        self._camera: tuple[int, FloatArray] | None = None

    def read(self) -> Model:
        order = self._walk()
        for node in order:
            self._read_node(node)
        if self.document.json.get("animations"):
            self.model.note("animations are not played: drawn at rest")
        self.model.camera = self._read_camera()
        return self.model

    def _walk(self) -> list[int]:
        """Fill in world matrices; return the nodes of the scene in depth-first order."""
        json = self.document.json
        nodes = json.get("nodes", [])
        if "scenes" in json:
            roots = json["scenes"][json.get("scene", 0)].get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [index for index in range(len(nodes)) if index not in children]
        order: list[int] = []
        pending = [(root, np.eye(4)) for root in reversed(roots)]
        while pending:
            index, parent = pending.pop()
            if index in self._world or not 0 <= index < len(nodes):
                raise GltfError(f"node {index} has two parents or does not exist")
            world = parent @ _local_matrix(nodes[index])
            self._world[index] = world
            order.append(index)
            pending += [(child, world) for child in reversed(nodes[index].get("children", []))]
        return order

    def _read_node(self, index: int) -> None:
        node, world = self.document.json["nodes"][index], self._world[index]
        if "mesh" in node:
            self._read_mesh(node, world)
        if "camera" in node and self._camera is None:
            self._camera = (int(node["camera"]), world)
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light is not None:
            self._read_light(int(light["light"]), world)

    def _read_mesh(self, node: Json, world: FloatArray) -> None:
        mesh_index = int(node["mesh"])
        mesh = self.document.json["meshes"][mesh_index]
        skin = int(node["skin"]) if "skin" in node else -1
        matrices = world[None] @ self._gpu_instances(node)
        if skin >= 0:
            # A skinned mesh stands where its joints are; its own node does not count.
            matrices = np.eye(4)[None]
        usable = np.abs(np.linalg.det(matrices[:, :3, :3])) > 0.0
        usable &= np.isfinite(matrices).all(axis=(1, 2))
        if not usable.all():
            self.model.note("instances scaled to zero size dropped")
            matrices = matrices[usable]
            if not len(matrices):
                return
        for number, primitive in enumerate(mesh["primitives"]):
            key = (mesh_index, number, skin)
            if key not in self._placed:
                name = str(node.get("name") or mesh.get("name") or "")
                self._placed[key] = self._add_primitive(primitive, mesh, skin, name)
            placed = self._placed[key]
            if placed is None:
                continue
            if placed in self._object_of:
                row = self._object_of[placed]
                item = self.model.objects[row]
                joined = np.concatenate([item.world_from_object, matrices])
                self.model.objects[row] = dataclasses.replace(item, world_from_object=joined)
            else:
                self._object_of[placed] = len(self.model.objects)
                name = str(node.get("name") or mesh.get("name") or "")
                self.model.objects.append(SceneObject(*placed, matrices, name=name))

    def _gpu_instances(self, node: Json) -> FloatArray:
        """Return (N, 4, 4) of EXT_mesh_gpu_instancing, or one identity."""
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if extension is None:
            return np.eye(4)[None]
        columns = {
            name: self.document.accessor(int(index))
            for name, index in extension["attributes"].items()
            if name in ("TRANSLATION", "ROTATION", "SCALE")
        }
        count = min((len(column) for column in columns.values()), default=0)
        matrices = [
            _local_matrix({name.lower(): column[row] for name, column in columns.items()})
            for row in range(count)
        ]
        return np.stack(matrices) if matrices else np.eye(4)[None]

    def _add_primitive(
        self, primitive: Json, mesh: Json, skin: int, name: str
    ) -> tuple[int, int] | None:
        material = self.materials.read(primitive.get("material"))
        shape = read_shape(self.document, primitive, mesh, material.uv_set)
        if shape is None:
            self.model.note("points and lines are not drawn")
            return None
        if shape.morphed:
            self.model.note("morph targets are drawn with their default weights")
        positions, normals = shape.positions, shape.normals
        if skin >= 0 and shape.joints is not None:
            positions, normals = self._skinned(shape, self.document.json["skins"][skin])
        try:
            index = self.model.add_mesh(
                positions,
                shape.triangles,
                normals,
                None if shape.uvs is None else material.transformed(shape.uvs),
                shape.colors,
                name,
            )
        except ValueError as error:
            raise GltfError(f"mesh {name!r}: {error}") from None
        return None if index is None else (index, material.index)

    def _skinned(self, shape: Shape, skin: Json) -> tuple[FloatArray, FloatArray | None]:
        """Return positions and normals in world space, in the pose of the joints."""
        joints = [int(joint) for joint in skin["joints"]]
        matrices = np.stack([self._world.get(joint, np.eye(4)) for joint in joints])
        if "inverseBindMatrices" in skin:
            inverse = self.document.accessor(int(skin["inverseBindMatrices"]))
            matrices = matrices @ inverse.reshape(-1, 4, 4)[: len(joints)].transpose(0, 2, 1)
        assert shape.joints is not None and shape.weights is not None
        blended = np.einsum("vj,vjab->vab", shape.weights, matrices[shape.joints])
        ones = np.ones((len(shape.positions), 1))
        positions = np.einsum(
            "vab,vb->va", blended, np.concatenate([shape.positions, ones], axis=1)
        )[:, :3]
        if shape.normals is None:
            return positions, None
        return positions, np.einsum("vab,vb->va", blended[:, :3, :3], shape.normals)

    def _read_light(self, index: int, world: FloatArray) -> None:
        """Add a light of KHR_lights_punctual; it shines along the node's -z."""
        lights = self.document.json["extensions"]["KHR_lights_punctual"]["lights"]
        light = lights[index]
        red, green, blue = (float(c) for c in light.get("color", (1.0, 1.0, 1.0)))
        strength = float(light.get("intensity", 1.0))
        color: Color = (red * strength, green * strength, blue * strength)
        if not all(0.0 <= c <= FLOAT32_MAX for c in color):
            raise GltfError(f"light {index}: colour and intensity must be finite and >= 0")
        name = str(light.get("name", ""))
        kind = kind_of_gltf(light["type"])
        if kind is None:
            raise GltfError(f"light {index}: unknown type {light['type']!r}")
        # The node's scale does not count: one axis may even vanish.
        backward = world[:3, 2] if world[:3, 2].any() else np.cross(world[:3, 0], world[:3, 1])
        if kind.direction_fields and not backward.any():
            self.model.note(f"light {name or index} dropped: its node is scaled to zero")
            return
        forward = -math3d.normalized(backward) if backward.any() else np.array([0.0, 0.0, -1.0])
        try:
            made = kind.from_gltf(light, _triple(world[:3, 3]), _triple(forward), color, name)
        except ValueError as error:
            raise GltfError(f"light {index}: {error}") from None
        self.model.lights.append(made)

    def _read_camera(self) -> Camera | None:
        """Return the first camera of the scene, if it is a perspective one."""
        if self._camera is None:
            return None
        index, world = self._camera
        camera = self.document.json["cameras"][index]
        if camera.get("type") != "perspective":
            self.model.note("orthographic camera not used: the whole scene is framed")
            return None
        fov_y = float(np.degrees(camera["perspective"]["yfov"]))
        if not 0.0 < fov_y < 180.0:
            raise GltfError(f"camera {index}: yfov = {fov_y:g} degrees: expected 0 to 180")
        position, forward = world[:3, 3], math3d.normalized(-world[:3, 2])
        target = position + forward * self._distance_ahead(position, forward)
        up = math3d.normalized(world[:3, 1])
        return Camera(_triple(position), _triple(target), _triple(up), fov_y)

    def _distance_ahead(self, position: FloatArray, forward: FloatArray) -> float:
        """Return how far ahead the middle of the scene lies: a natural pivot."""
        middles = [
            math3d.transform_points(matrix, np.mean(self.model.meshes[o.mesh].bounds(), axis=0))
            for o in self.model.objects
            for matrix in o.world_from_object
        ]
        if not middles:
            return 1.0
        offset = np.mean(middles, axis=0) - position
        ahead = float(offset @ forward)
        return ahead if ahead > 0.0 else max(float(np.linalg.norm(offset)), 1e-6)


def _local_matrix(node: Json | dict[str, NDArray[Any]]) -> FloatArray:
    """Return parent_from_node of a node: its matrix, or translation, rotation, scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    matrix[:3, :3] = _rotation(np.asarray(node.get("rotation", (0.0, 0.0, 0.0, 1.0))))
    matrix[:3, :3] *= np.asarray(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    return matrix


def _rotation(quaternion: NDArray[Any]) -> FloatArray:
    """Return the (3, 3) rotation of a quaternion (x, y, z, w)."""
    x, y, z, w = math3d.normalized(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _triple(array: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in array)
    return x, y, z
