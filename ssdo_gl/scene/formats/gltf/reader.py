"""Importer of glTF 2.0 (.gltf and .glb): nodes, meshes, cameras, lights.

Read here rather than by trimesh, which rounds colour factors and vertex colours to
eight bits, invents normals, and decodes images of any size.
Specification: Khronos glTF 2.0; extensions are named where they are read.
"""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.file_camera import FileCamera
from ssdo_gl.scene.formats.gltf.allowed import check_extensions, misplaced
from ssdo_gl.scene.formats.gltf.animation import read_channels
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, numbers
from ssdo_gl.scene.formats.gltf.draco import unpack
from ssdo_gl.scene.formats.gltf.geometry import read_points, read_shape
from ssdo_gl.scene.formats.gltf.gltf_materials import MaterialReader
from ssdo_gl.scene.formats.gltf.nodes import NodeTree, matrices_of
from ssdo_gl.scene.formats.gltf.poses import Poses
from ssdo_gl.scene.formats.gltf.ranges import Ranges
from ssdo_gl.scene.formats.gltf.rig import FrameMotion, NodeMotion, Rig, Skin
from ssdo_gl.scene.formats.gltf.viewpoints import read_camera, read_light
from ssdo_gl.scene.formats.model import Model, some_names
from ssdo_gl.scene.geometry import MAX_INSTANCES, Mesh, SceneObject, thickened, with_area
from ssdo_gl.scene.scene_error import SceneError

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
        document = Document.load(path, where)
        # Numbers that overflow on the way are refused or dropped where they end up.
        with np.errstate(all="ignore"):
            check_extensions(document)
            return _Reader(document).read()
    except SceneError:
        raise
    except GltfError as error:
        raise SceneError(f"{where}: {error}") from None
    except _STRUCTURE_ERRORS as error:
        raise SceneError(f"{where}: not valid glTF: {_reason(error, document.json)}") from None


def _reason(error: Exception, document: Json) -> str:
    """Return what is wrong with a document that could not be walked."""
    if isinstance(error, RecursionError):
        return "nested too deeply"
    found = misplaced(document)
    if found is not None:
        return found
    reason = " ".join(str(error).split())[:120]
    if isinstance(error, KeyError):
        return f"{reason} is missing"
    return f"{type(error).__name__.removesuffix('Error')} {reason}"


class _Reader:
    """Walks the nodes of one document and fills a Model."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.model = Model()
        self.ranges = Ranges()
        self.materials = MaterialReader(document, self.model, self.ranges)
        self.tree = NodeTree(document, self.ranges)
        channels = read_channels(document, self.model.note, self.ranges)
        self.rig = Rig(document, self.tree, channels)
        self._skins: dict[int, Skin] = {}
        # (mesh, primitive, skin, morph weights or the node that has them) -> mesh and
        # material of the model, None if unusable.
        self._placed: dict[tuple[int, int, int, bytes | int], tuple[int, int] | None] = {}
        # mesh and material of the model, and the node whose motion they share, if any
        # -> name, and matrices of the instances
        self._instances: dict[tuple[int, int, int], tuple[str, list[FloatArray]]] = {}
        self._cameras: list[int] = []  # nodes

    def read(self) -> Model:
        self._note_other_scenes()
        for node in self.tree.visible:
            self._read_node(node)
        self.model.objects = [
            SceneObject(
                mesh, material, np.concatenate(matrices), motion=self._motion(node), name=name
            )
            for (mesh, material, node), (name, matrices) in self._instances.items()
        ]
        # Their pivots are in the middle of what there is.
        for node in self._cameras:
            self._read_camera(node)
        if note := self.ranges.note():
            self.model.note(note)
        return self.model

    def _note_other_scenes(self) -> None:
        scenes, drawn = self.document.json.get("scenes", []), self.document.json.get("scene", 0)
        names = [
            str(scene.get("name") or index)
            for index, scene in enumerate(scenes)
            if index != drawn and scene.get("nodes")
        ]
        if names:
            name = scenes[drawn].get("name") or drawn
            self.model.note(f"drawn is the file's scene {name}, without: {some_names(names)}")

    def _read_camera(self, index: int) -> None:
        node = self.document.json["nodes"][index]
        entry = self.document.entry("cameras", node["camera"])
        name = str(node.get("name") or entry.get("name") or "")
        camera = read_camera(entry, self.rig.world_at(index, 0.0), self.model, name)
        if camera is not None:
            motion = FrameMotion(self.rig, index) if self.rig.moves(index) else None
            self.model.cameras.append(FileCamera(name, camera, motion))

    def _motion(self, node: int) -> NodeMotion | None:
        if node < 0:
            return None
        return NodeMotion(self.rig, node, self._rest(node))

    def _rest(self, node: int) -> FloatArray:
        """Return world_from_node of a node that moves, with an inverse."""
        return np.asarray(thickened(self.rig.rest(node)[None])[0])

    def _read_node(self, index: int) -> None:
        node = self.document.json["nodes"][index]
        if "mesh" in node:
            self._read_mesh(node, index)
        if "camera" in node:
            self._cameras.append(index)
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light is not None:
            made = read_light(
                self.document,
                light["light"],
                self.rig.world_at(index, 0.0),
                self.model,
                self.ranges,
            )
            if made is not None:
                motion = FrameMotion(self.rig, index) if self.rig.moves(index) else None
                self.model.lights.append(dataclasses.replace(made, motion=motion))

    def _read_mesh(self, node: Json, index: int) -> None:
        where = f"node {index}"
        mesh_index = node["mesh"]
        mesh = self.document.entry("meshes", mesh_index)
        skin = node.get("skin", -1)
        carrier = -1
        if "skin" in node:
            # A skinned mesh stands where its joints are; its own node does not count.
            matrices = np.eye(4)[None]
        else:
            world = self.tree.world[index]
            if self.rig.moves(index) and len(with_area(self.rig.rest(index)[None])):
                carrier, world = index, self._rest(index)
            elif self.rig.moves(index):
                world = self.rig.rest(index)
            matrices = world[None] @ self._gpu_instances(node, where)
        usable = with_area(matrices)
        if len(usable) < len(matrices):
            self.model.note("instances scaled to zero size dropped")
            if not len(usable):
                return
        owner = node if "weights" in node else mesh
        count = len(owner.get("weights", []))
        weights = numbers(owner, "weights", [0.0] * count, where)
        name = str(node.get("name") or mesh.get("name") or "")
        animated = self.rig.has_weights(index)
        for row, primitive in enumerate(mesh["primitives"]):
            key = (mesh_index, row, skin, index if animated else weights.tobytes())
            if key not in self._placed:
                poses = Poses(self.rig, weights, index if animated else None, self._skin(skin))
                self._placed[key] = self._add_primitive(primitive, poses, name)
            placed = self._placed[key]
            if placed is not None:
                shown = thickened(usable, self.model.meshes[placed[0]])
                if len(shown) < len(usable):
                    self.model.note("instances scaled to zero size dropped")
                if len(shown):
                    self._instances.setdefault((*placed, carrier), (name, []))[1].append(shown)

    def _skin(self, index: int) -> Skin | None:
        if index == -1:
            return None
        if index not in self._skins:
            self._skins[index] = Skin.read(self.document, self.rig, index)
        return self._skins[index]

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
        matrices = matrices_of(
            columns.get("TRANSLATION", np.zeros((count, 3)))[:count],
            columns.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))[:count],
            columns.get("SCALE", np.ones((count, 3)))[:count],
        )
        # Without data a kilobyte could ask for a million copies, all in one place.
        moves = np.any(matrices[1:] != matrices[:-1], axis=(1, 2))
        return np.asarray(matrices[np.concatenate([[True], moves])])

    def _add_primitive(self, primitive: Json, poses: Poses, name: str) -> tuple[int, int] | None:
        material = self.materials.read(primitive.get("material"))
        if primitive.get("mode") == 0 and "POSITION" in primitive["attributes"]:
            points = read_points(self.document, primitive["attributes"])
            index = self.model.add_points(*points, name)
            return None if index is None else (index, material.index)
        second = material.second_uvs
        sets = material.uvs.uv_set, None if second is None else second.uv_set
        unpack(self.document, primitive)
        is_bumped = self.model.materials[material.index].normal_texture is not None
        shape = read_shape(self.document, primitive, sets, poses.is_morphed(), is_bumped=is_bumped)
        if shape is None:
            are_lines = primitive.get("mode", 4) in (1, 2, 3)
            what = "lines are not drawn" if are_lines else "no vertices"
            self.model.drop(f"primitives of {what}")
            return None
        poses.check(shape)
        uvs = second_uvs = None
        if shape.uvs is not None:
            uvs = material.uvs.transformed(shape.uvs)
            # Without coordinates of their own, the first have to do.
            if second and shape.second_uvs is not None:
                second_uvs = second.transformed(shape.second_uvs)
        raw = Mesh(
            **poses.rest(shape)._asdict(),
            triangles=shape.triangles,
            uvs=uvs,
            second_uvs=second_uvs,
            colors=shape.colors,
            name=name,
        )
        moving = functools.partial(poses.of, shape) if poses.moves(shape) else None
        try:
            index = self.model.add_mesh(raw, moving)
        except ValueError as error:
            raise GltfError(f"mesh {name!r}: {error}") from None
        return None if index is None else (index, material.index)
