"""Importer of glTF 2.0 (.gltf and .glb): nodes, meshes, cameras, lights.

Read here rather than by trimesh, which rounds colour factors and vertex colours to
eight bits, invents normals, and decodes images of any size.
Specification: Khronos glTF 2.0; extensions are named where they are read.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, number, numbers, shown
from ssdo_gl.scene.formats.gltf.geometry import Shape, read_shape
from ssdo_gl.scene.formats.gltf.gltf_materials import MaterialReader
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.lights import kind_of_gltf
from ssdo_gl.scene.mesh import MAX_INSTANCES, Mesh, SceneObject
from ssdo_gl.scene.numbers import LARGEST_COORDINATE, LARGEST_NUMBER
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
    "KHR_node_visibility",
}
_UNDRAWN = {
    0: "points are not drawn",
    1: "lines are not drawn",
    2: "lines are not drawn",
    3: "lines are not drawn",
}
# Ratio of a matrix's scales below which float64 rounding decides; and the thickness, in
# its stead, that is too thin to see.
_FLAT, _THICKNESS = 1e-12, 1e-4
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
        # Numbers that overflow on the way are refused or dropped where they end up.
        with np.errstate(all="ignore"):
            document = Document.load(path, where)
            _check_extensions(document)
            return _Reader(document).read()
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
            raise GltfError(f"requires the extension {shown(name)}, which is not supported")


class _Reader:
    """Walks the nodes of one document and fills a Model."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.model = Model()
        self.materials = MaterialReader(document, self.model)
        # (mesh, primitive, skin, morph weights) -> mesh and material of the model,
        # None if unusable.
        self._placed: dict[tuple[int, int, int, bytes], tuple[int, int] | None] = {}
        # mesh and material of the model -> name, and matrices of the instances
        self._instances: dict[tuple[int, int], tuple[str, list[FloatArray]]] = {}
        self._world: dict[int, FloatArray] = {}
        self._camera: tuple[Json, FloatArray] | None = None

    def read(self) -> Model:
        order = self._walk()
        for node in order:
            self._read_node(node)
        self.model.objects = [
            SceneObject(*placed, np.concatenate(matrices), name=name)
            for placed, (name, matrices) in self._instances.items()
        ]
        if self.document.json.get("animations"):
            self.model.note("animations are not played: drawn at rest")
        self.model.camera = self._read_camera()
        return self.model

    def _walk(self) -> list[int]:
        """Fill in world matrices; return the visible nodes of the scene, depth first."""
        json = self.document.json
        nodes = json.get("nodes", [])
        if "scenes" in json:
            roots = self.document.entry("scenes", json.get("scene", 0)).get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [index for index in range(len(nodes)) if index not in children]
        order: list[int] = []
        pending = [(root, np.eye(4), True) for root in reversed(roots)]
        while pending:
            index, parent, shown = pending.pop()
            node = self.document.entry("nodes", index)
            if index in self._world:
                raise GltfError(f"node {index} has two parents")
            world = parent @ _local_matrix(node, f"node {index}")
            if not np.all(np.abs(world) <= LARGEST_COORDINATE):
                raise GltfError(f"node {index} lies or reaches beyond {LARGEST_COORDINATE:g}")
            self._world[index] = world
            visibility = node.get("extensions", {}).get("KHR_node_visibility", {})
            shown = shown and visibility.get("visible", True) is not False
            if shown:
                order.append(index)
            pending += [(child, world, shown) for child in reversed(node.get("children", []))]
        return order

    def _read_node(self, index: int) -> None:
        node, world = self.document.json["nodes"][index], self._world[index]
        if "mesh" in node:
            self._read_mesh(node, world, f"node {index}")
        if "camera" in node and self._camera is None:
            self._camera = self.document.entry("cameras", node["camera"]), world
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light is not None:
            self._read_light(light["light"], world)

    def _read_mesh(self, node: Json, world: FloatArray, where: str) -> None:
        mesh_index = node["mesh"]
        mesh = self.document.entry("meshes", mesh_index)
        skin = node.get("skin", -1)
        matrices = world[None] @ self._gpu_instances(node, where)
        if "skin" in node:
            # A skinned mesh stands where its joints are; its own node does not count.
            matrices = np.eye(4)[None]
        usable = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
        size = _sizes(np.where(usable[:, None, None], matrices, 0.0))
        # Flattened along one axis a thing still shows; along two it is a line.
        usable &= size[:, 1] > _FLAT * size[:, 0]
        if not usable.all():
            self.model.note("instances scaled to zero size dropped")
            matrices = matrices[usable]
            if not len(matrices):
                return
        owner = node if "weights" in node else mesh
        count = len(owner.get("weights", []))
        weights = numbers(owner, "weights", [0.0] * count, where)
        name = str(node.get("name") or mesh.get("name") or "")
        for row, primitive in enumerate(mesh["primitives"]):
            key = (mesh_index, row, skin, weights.tobytes())
            if key not in self._placed:
                self._placed[key] = self._add_primitive(primitive, weights.tolist(), skin, name)
            placed = self._placed[key]
            if placed is not None:
                matrices = _thickened(matrices, self.model.meshes[placed[0]])
                self._instances.setdefault(placed, (name, []))[1].append(matrices)

    def _gpu_instances(self, node: Json, where: str) -> FloatArray:
        """Return (N, 4, 4) of EXT_mesh_gpu_instancing, or one identity."""
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if extension is None:
            return np.eye(4)[None]
        columns = {}
        for name, width in (("TRANSLATION", 3), ("ROTATION", 4), ("SCALE", 3)):
            if name in extension["attributes"]:
                index = extension["attributes"][name]
                count = self.document.entry("accessors", index)["count"]
                if not 0 <= count <= MAX_INSTANCES:
                    raise GltfError(f"{where}: {count} instances: at most {MAX_INSTANCES}")
                columns[name] = self.document.accessor(index, (width,))
        count = min((len(column) for column in columns.values()), default=0)
        if not count:
            return np.eye(4)[None]
        matrices = _matrices(
            columns.get("TRANSLATION", np.zeros((count, 3)))[:count],
            columns.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))[:count],
            columns.get("SCALE", np.ones((count, 3)))[:count],
        )
        # Without data a kilobyte could ask for a million copies, all in one place.
        moves = np.any(matrices[1:] != matrices[:-1], axis=(1, 2))
        return np.asarray(matrices[np.concatenate([[True], moves])])

    def _add_primitive(
        self, primitive: Json, weights: list[float], skin: int, name: str
    ) -> tuple[int, int] | None:
        material = self.materials.read(primitive.get("material"))
        glow = material.emission_uvs
        sets = material.uvs.uv_set, None if glow is None else glow.uv_set
        shape = read_shape(self.document, primitive, weights, sets)
        if shape is None:
            mode = primitive.get("mode", 4)
            self.model.drop("primitives of " + _UNDRAWN.get(mode, "no vertices"))
            return None
        if shape.morphed:
            self.model.note("morph targets are drawn with the weights of the file")
        positions, normals = shape.positions, shape.normals
        if skin != -1 and shape.joints is not None:
            positions, normals = self._skinned(shape, self.document.entry("skins", skin))
        try:
            index = self.model.add_mesh(
                positions,
                shape.triangles,
                normals,
                None if shape.uvs is None else material.uvs.transformed(shape.uvs),
                shape.colors,
                name,
                # Without coordinates of their own, those of the base colour have to do.
                glow.transformed(shape.emission_uvs)
                if glow and shape.uvs is not None and shape.emission_uvs is not None
                else None,
            )
        except ValueError as error:
            raise GltfError(f"mesh {name!r}: {error}") from None
        return None if index is None else (index, material.index)

    def _skinned(self, shape: Shape, skin: Json) -> tuple[FloatArray, FloatArray | None]:
        """Return positions and normals in world space, in the pose of the joints."""
        joints = [int(joint) for joint in skin["joints"]]
        matrices = np.stack([self._world.get(joint, np.eye(4)) for joint in joints])
        if "inverseBindMatrices" in skin:
            inverse = self.document.accessor(skin["inverseBindMatrices"], (16,))
            matrices = matrices @ inverse.reshape(-1, 4, 4)[: len(joints)].transpose(0, 2, 1)
        assert shape.joints is not None and shape.weights is not None
        if int(shape.joints.max(initial=0)) >= len(matrices):
            raise GltfError(f"a vertex refers to joint {shape.joints.max()} of {len(matrices)}")
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
        if not isinstance(index, int) or not 0 <= index < len(lights):
            raise GltfError(f"refers to light {index}, but there are {len(lights)}")
        light, where = lights[index], f"light {index}"
        strength = number(light, "intensity", 1.0, where)
        color = numbers(light, "color", (1.0, 1.0, 1.0), where) * strength
        if not all(0.0 <= c <= LARGEST_NUMBER for c in color):
            raise GltfError(
                f"{where}: colour times intensity is {_listed(color)}: expected 0 to "
                f"{LARGEST_NUMBER:g}"
            )
        name = str(light.get("name", ""))
        kind = kind_of_gltf(light["type"])
        if kind is None:
            raise GltfError(f"light {index}: unknown type {shown(light['type'])}")
        # The node's scale does not count: one axis may even vanish.
        backward = world[:3, 2] if world[:3, 2].any() else np.cross(world[:3, 0], world[:3, 1])
        if kind.direction_fields and not backward.any():
            self.model.note(f"light {name or index} dropped: its node is scaled to zero")
            return
        forward = -math3d.normalized(backward) if backward.any() else np.array([0.0, 0.0, -1.0])
        try:
            made = kind.from_gltf(
                light, _triple(world[:3, 3]), _triple(forward), _triple(color), name
            )
        except ValueError as error:
            raise GltfError(f"light {index}: {error}") from None
        self.model.lights.append(made)

    def _read_camera(self) -> Camera | None:
        """Return the first camera of the scene, if it is a perspective one."""
        if self._camera is None:
            return None
        camera, world = self._camera
        if camera.get("type") != "perspective":
            self.model.note("orthographic camera not used: the whole scene is framed")
            return None
        fov_y = float(np.degrees(number(camera["perspective"], "yfov", np.nan, "camera")))
        if not 0.0 < fov_y < 180.0:
            raise GltfError(f"camera: yfov = {fov_y:g} degrees: expected 0 to 180")
        position, forward = world[:3, 3], _axis(-world[:3, 2], "camera")
        target = position + forward * self._distance_ahead(position, forward)
        up = _axis(world[:3, 1], "camera")
        return Camera(_triple(position), _triple(target), _triple(up), fov_y)

    def _distance_ahead(self, position: FloatArray, forward: FloatArray) -> float:
        """Return how far ahead the middle of the scene lies: a natural pivot."""
        middles = [
            o.world_from_object[:, :3, :3] @ np.mean(self.model.meshes[o.mesh].bounds(), axis=0)
            + o.world_from_object[:, :3, 3]
            for o in self.model.objects
        ]
        if not middles:
            return 1.0
        offset = np.mean(np.concatenate(middles), axis=0) - position
        ahead = float(offset @ forward)
        return ahead if ahead > 0.0 else max(float(np.linalg.norm(offset)), 1e-6)


def _local_matrix(node: Json, where: str) -> FloatArray:
    """Return parent_from_node of a node: its matrix, or translation, rotation, scale."""
    if "matrix" in node:
        return np.ascontiguousarray(numbers(node, "matrix", [0.0] * 16, where).reshape(4, 4).T)
    rotation = numbers(node, "rotation", (0.0, 0.0, 0.0, 1.0), where)
    if not rotation.any():
        raise GltfError(f"{where}: rotation = [0, 0, 0, 0] is no rotation")
    translation = numbers(node, "translation", (0.0, 0.0, 0.0), where)
    scale = numbers(node, "scale", (1.0, 1.0, 1.0), where)
    return np.asarray(_matrices(translation[None], rotation[None], scale[None])[0])


def _matrices(translation: FloatArray, rotation: FloatArray, scale: FloatArray) -> FloatArray:
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


def _thickened(matrices: FloatArray, mesh: Mesh) -> FloatArray:
    """Return the matrices (N, 4, 4), with those that flatten given a little thickness.

    A matrix without inverse says nothing of which side is the front. As its determinant
    is not negative, the winding on screen stays, as the format has it.
    """
    size = _sizes(matrices)
    flat = size[:, 2] <= _FLAT * size[:, 0]
    if not flat.any():
        return matrices
    left, size, right = np.linalg.svd(matrices[flat, :3, :3])
    turned = np.linalg.det(left) * np.linalg.det(right)
    thickness = _THICKNESS * size[:, 1] * turned
    added = thickness[:, None, None] * left[:, :, 2:] * right[:, 2:, :]
    result = matrices.copy()
    result[flat, :3, :3] += added
    result[flat, :3, 3] -= added @ np.mean(mesh.bounds(), axis=0)
    return result


def _sizes(matrices: FloatArray) -> FloatArray:
    """Return the three scales of matrices (N, 4, 4), largest first, (N, 3)."""
    return np.asarray(np.linalg.svd(matrices[:, :3, :3], compute_uv=False), dtype=np.float64)


def _axis(direction: FloatArray, where: str) -> FloatArray:
    if not direction.any():
        raise GltfError(f"{where}: its node is scaled to zero, so it looks nowhere")
    return math3d.normalized(direction)


def _listed(values: FloatArray) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


def _triple(array: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in array)
    return x, y, z
