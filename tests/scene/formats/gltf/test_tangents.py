"""Normal maps lie along the tangents of a glTF file, in pictures and for rays alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from glb_writer import GlbWriter
from image_bytes import png_uri
from numpy.typing import NDArray
from passes.ray_harness import Tracer
from program_of_text import fullscreen_source

import ssdo_gl
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays.ray_libraries import ray_defines, ray_uniforms
from ssdo_gl.passes.rays.ray_pass import RayPass
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.geometry.batching import MIN_OBJECTS, batched
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

SIZE = (32, 32)
CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "<f4")
UVS = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4")
TEXEL = np.array([200, 90, 220])
MAPPED = (TEXEL / 127.5 - 1.0) / np.linalg.norm(TEXEL / 127.5 - 1.0)
# By the coordinates the tangent were +x.
ANGLE = np.radians(40.0)
# Sixteen bits of octahedral directions, twice.
ROUNDING = 2e-4

SEEN_BY_RAYS = """#version 330 core
#include "lib/surface.glsl"
layout(location = 0) out vec4 o_seen;
void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_seen = vec4(0.0);
    if (gbuffer_z_vs(texel) > 0.0) {
        vec3 w = normalize(u_ns_from_vs * gbuffer_position_vs(texel));
        BvhHit hit = bvh_nearest(u_eye_ns, w, RAY_FAR);
        if (hit.record >= 0) {
            o_seen = vec4(surface_at_hit(hit, u_eye_ns, w).at.normal, 1.0);
        }
    }
}
"""


class SeenByRays(RayPass):
    """Writes the shading normals that rays through the pixels meet, world space."""

    name = "seen"
    surface = ("z_vs",)
    writes: ClassVar[dict[str, TextureSpec]] = {"seen": TextureSpec(4)}

    def schedule(self, context: PassContext) -> Any:
        raise AssertionError("the test runs the pass itself")

    def execute(self, context: PassContext) -> None:
        program = fullscreen_source(
            context.shaders, SEEN_BY_RAYS, ray_defines(context, self.features)
        )
        textures = {f"t_{name}": context.inputs[name] for name in self.reads}
        uniforms = ray_uniforms(context)
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            program,
            context.target,
            {name: value for name, value in uniforms.items() if name in program.gl},
            {name: texture for name, texture in textures.items() if name in program.gl},
        )


def tangents(angle: float = ANGLE, hand: float = 1.0) -> NDArray[Any]:
    return np.tile([np.cos(angle), np.sin(angle), 0.0, hand], (4, 1)).astype("<f4")


def square(glb: GlbWriter, tangent: NDArray[Any] | None = None, **more: Any) -> dict[str, Any]:
    """Return a primitive: a square that faces +z, with tangents."""
    normalized = {} if tangent is None or tangent.dtype.kind == "f" else {"normalized": True}
    along = tangents() if tangent is None else tangent
    glb.json["images"] = [{"uri": png_uri(np.tile([*TEXEL, 255], (2, 2, 1)).astype(np.uint8))}]
    glb.json["textures"] = [{"source": 0}]
    base = {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1]}
    normal = {"normalTexture": {"index": 0}}
    glb.json["materials"] = [{"pbrMetallicRoughness": base, "doubleSided": True, **normal}]
    attributes = {
        "POSITION": glb.accessor(CORNERS, "VEC3"),
        "NORMAL": glb.accessor(np.tile([0, 0, 1], (4, 1)).astype("<f4"), "VEC3"),
        "TEXCOORD_0": glb.accessor(UVS, "VEC2"),
        "TANGENT": glb.accessor(along, "VEC4", **normalized),
    }
    indices = glb.accessor(np.array([0, 1, 2, 0, 2, 3], "<u2"), "SCALAR")
    return {"attributes": attributes | more, "indices": indices, "material": 0}


def load(glb: GlbWriter, folder: Path, *nodes: dict[str, Any], z: float = 2.0) -> Scene:
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5}}]
    turn = [0, 0, 0, 1] if z > 0.0 else [0, 1, 0, 0]
    glb.json["nodes"] = [*nodes, {"camera": 0, "translation": [0, 0, z], "rotation": turn}]
    glb.json["scenes"] = [{"nodes": list(range(len(nodes) + 1))}]
    return load_scene(glb.save(folder / "a.glb"), ground="off")


def seen(scene: Scene, device: Any, shaders: Any) -> list[NDArray[np.float64]]:
    """Return shading normals in the world, (2, height, width, 3): drawn and met by rays."""
    drawn = ssdo_gl.render(scene, size=SIZE, aov="normal_ws")
    with Tracer(device, shaders, scene, SIZE) as tracer:
        met = tracer.run(SeenByRays(None, RayFeatures.of(scene)))["seen"]
    return [np.asarray(drawn, np.float64), np.asarray(met[..., :3], np.float64)]


def expected(
    matrix: NDArray[np.float64], hand: float = 1.0, angle: float = ANGLE
) -> NDArray[np.float64]:
    """Return what the map says on a square that `matrix` places."""
    side = np.sign(np.linalg.det(matrix))
    normal = np.linalg.inv(matrix).T @ [0.0, 0.0, 1.0]
    normal /= np.linalg.norm(normal)
    tangent = matrix @ [np.cos(angle), np.sin(angle), 0.0]
    tangent /= np.linalg.norm(tangent)
    top = side * hand * np.cross(normal, tangent)
    return np.asarray(MAPPED @ np.stack([tangent, top, normal]))


def as_node(matrix: NDArray[np.float64]) -> list[float]:
    full = np.eye(4)
    full[:3, :3] = matrix
    return [float(value) for value in full.T.reshape(-1)]


def turned(axis: str, degrees: float) -> NDArray[np.float64]:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    rows = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}
    return np.array(rows[axis], dtype=np.float64)


PLACES = {
    "as it is": np.eye(3),
    "turned": turned("x", 30) @ turned("z", 70),
    "stretched": np.diag([2.0, 0.7, 5.0]) @ turned("z", 20),
    "mirrored": np.diag([-1.0, 1.0, 1.0]),
    "mirrored and leaning": turned("x", -25) @ np.diag([1.0, -1.5, 1.0]),
}


@pytest.mark.parametrize("hand", [1.0, -1.0])
@pytest.mark.parametrize("place", PLACES)
def test_a_map_lies_along_the_tangents(
    place: str, hand: float, glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    glb.json["meshes"] = [{"primitives": [square(glb, tangents(hand=hand))]}]
    scene = load(glb, tmp_path, {"mesh": 0, "matrix": as_node(PLACES[place])})
    for found in seen(scene, device, shaders):
        right = np.broadcast_to(expected(PLACES[place], hand), found[8:24, 8:24].shape)
        np.testing.assert_allclose(found[8:24, 8:24], right, atol=ROUNDING)


def test_from_behind_all_of_it_is_turned(
    glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    glb.json["meshes"] = [{"primitives": [square(glb)]}]
    scene = load(glb, tmp_path, {"mesh": 0}, z=-2.0)
    for found in seen(scene, device, shaders):
        right = np.broadcast_to(-expected(np.eye(3)), found[8:24, 8:24].shape)
        np.testing.assert_allclose(found[8:24, 8:24], right, atol=ROUNDING)


def test_tangents_of_integers_and_of_instances(
    glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    glb.json["extensionsUsed"] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"]
    bytes_of = np.rint(tangents() * 127.0).astype("|i1")
    glb.json["meshes"] = [{"primitives": [square(glb, bytes_of)]}]
    half = np.radians(35.0)
    columns = {
        "TRANSLATION": glb.accessor(np.array([[-1, 0, 0], [1, 0, 0]], "<f4"), "VEC3"),
        "ROTATION": glb.accessor(
            np.array([[0, 0, 0, 1], [0, 0, np.sin(half), np.cos(half)]], "<f4"), "VEC4"
        ),
    }
    extension = {"EXT_mesh_gpu_instancing": {"attributes": columns}}
    scene = load(glb, tmp_path, {"mesh": 0, "extensions": extension}, z=4.0)
    for found in seen(scene, device, shaders):
        # A byte's step is half a degree.
        np.testing.assert_allclose(found[16, 8], expected(np.eye(3)), atol=5e-3)
        np.testing.assert_allclose(found[16, 24], expected(turned("z", 70)), atol=5e-3)


@pytest.mark.parametrize("place", ["turned", "mirrored"])
def test_tangents_follow_joints(
    place: str, glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    joints = glb.accessor(np.zeros((4, 4), "|u1"), "VEC4")
    weights = glb.accessor(np.tile([1, 0, 0, 0], (4, 1)).astype("<f4"), "VEC4")
    primitive = square(glb, JOINTS_0=joints, WEIGHTS_0=weights)
    glb.json["meshes"] = [{"primitives": [primitive]}]
    glb.json["skins"] = [{"joints": [1]}]
    joint = {"matrix": as_node(PLACES[place])}
    scene = load(glb, tmp_path, {"mesh": 0, "skin": 0}, joint)
    for found in seen(scene, device, shaders):
        np.testing.assert_allclose(found[16, 12], expected(PLACES[place]), atol=ROUNDING)


def test_tangents_follow_morph_targets_in_time(
    glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    primitive = square(glb)
    change = (tangents(np.radians(100.0)) - tangents())[:, :3]
    primitive["targets"] = [{"TANGENT": glb.accessor(change, "VEC3")}]
    glb.json["meshes"] = [{"primitives": [primitive], "weights": [0]}]
    sampler = {
        "input": glb.accessor(np.array([0, 1], "<f4"), "SCALAR"),
        "output": glb.accessor(np.array([0, 1], "<f4"), "SCALAR"),
    }
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    glb.json["animations"] = [{"channels": [channel], "samplers": [sampler]}]
    scene = load(glb, tmp_path, {"mesh": 0})
    for seconds, angle in ((0.0, ANGLE), (0.5, np.radians(70.0))):
        for found in seen(scene_at(scene, seconds), device, shaders):
            right = expected(np.eye(3), angle=angle)
            np.testing.assert_allclose(found[16, 12], right, atol=ROUNDING)


def test_pictures_and_rays_agree_between_uneven_corners(
    glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    along = np.stack([tangents(angle)[0] for angle in (0.2, 1.4, 0.7, 1.1)])
    along[3] = np.nan  # has none: what the others say counts there
    normals = CORNERS * [0.4, 0.3, 0.0] + [0.0, 0.0, 1.0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normal = glb.accessor(normals.astype("<f4"), "VEC3")
    glb.json["meshes"] = [{"primitives": [square(glb, along, NORMAL=normal)]}]
    drawn, met = seen(load(glb, tmp_path, {"mesh": 0}), device, shaders)
    np.testing.assert_allclose(drawn, met, atol=5e-4)
    assert np.ptp(drawn[8:24, 8:24, 0]) > 0.1


@pytest.mark.parametrize("spoiled", ["NORMAL", "TANGENT"])
def test_without_normals_or_tangents_coordinates_decide(
    spoiled: str, glb: GlbWriter, tmp_path: Path, device: Any, shaders: Any
) -> None:
    primitive = square(glb)
    if spoiled == "NORMAL":
        del primitive["attributes"]["NORMAL"]
    else:
        nothing = glb.accessor(np.zeros((4, 4), "<f4"), "VEC4")
        primitive["attributes"]["TANGENT"] = nothing
    glb.json["meshes"] = [{"primitives": [primitive]}]
    for found in seen(load(glb, tmp_path, {"mesh": 0}), device, shaders):
        np.testing.assert_allclose(found[16, 12], MAPPED, atol=ROUNDING)


def test_many_small_meshes_keep_their_tangents_when_joined() -> None:
    corners, normals = CORNERS.astype(float), np.tile([0.0, 0.0, 1.0], (4, 1))
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = Mesh(corners, triangles, normals, UVS.astype(float), tangents=tangents(hand=-1.0))
    placed = np.eye(4)
    placed[:3, :3] = 3.0 * PLACES["turned"]
    objects = [SceneObject(0, 0, placed[None]) for _ in range(MIN_OBJECTS)]
    (joined,), _, _ = batched([mesh], [Material()], objects)
    assert joined.tangents is not None
    right = [*(PLACES["turned"] @ tangents()[0, :3]), -1.0]
    np.testing.assert_allclose(joined.tangents, np.tile(right, (4 * MIN_OBJECTS, 1)), atol=1e-6)
