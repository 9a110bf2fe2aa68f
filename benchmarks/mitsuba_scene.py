"""Scenes of this project as scenes of Mitsuba 3, an independent renderer.

Only what the compared scenes use: flat or smooth triangles, plain albedo and gloss, rectangle
and directional lights, constant and gradient skies. Glossy surfaces need
`benchmarks.mitsuba_gltf`.
"""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.raytracing.triangles import SceneTriangles, scene_triangles
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, GradientEnvironment
from ssdo_gl.scene.lights import DirectionalLight, Light, RectangleLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# A gradient's map: rows of 0.18 degrees, so that interpolating it is exact to 1e-5.
SKY_ROWS = 1024
# Invisible lamps are unknown to Mitsuba: the one before the room's open side would hide
# the room, so this camera stands inside; and so low that the ceiling lamp is out of
# view, whose outline, 50 times as bright as the rest, would decide the mean by how many
# samples it happens to get.
CAMERAS = {"cornell_meso": Camera((0.0, -0.3, 1.9), (0.0, -0.55, 0.0), fov_y=52.0)}


def compared_scene(name: str) -> Scene:
    """Return a built-in scene as both renderers can draw it: flat, seen from a fit place."""
    scene = load_scene(name)
    meshes = tuple(dataclasses.replace(mesh, normals=None) for mesh in scene.meshes)
    return dataclasses.replace(scene, meshes=meshes, camera=CAMERAS.get(name, scene.camera))


def load_mitsuba(variant: str = "scalar_rgb") -> ModuleType:
    """Return mitsuba; the scalar variant needs no compiler at run time.

    Raises
    ------
    ImportError
        If mitsuba is not installed or the variant cannot be had.
    """
    module = importlib.import_module("mitsuba")
    module.set_variant(variant)
    return module


def rgb(color: Sequence[float]) -> dict[str, Any]:
    """Return a colour as Mitsuba writes it."""
    return {"type": "rgb", "value": [float(c) for c in color]}


def write_ply(path: Path, triangles: SceneTriangles, chosen: NDArray[np.bool_]) -> None:
    """Write the chosen triangles in world space, three vertices each."""
    positions = triangles.positions[chosen].astype(np.float64) * triangles.half_diagonal
    positions = (positions + triangles.centre).reshape(-1, 3).astype("<f4")
    faces = np.zeros(len(positions) // 3, dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = np.arange(len(positions)).reshape(-1, 3)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(positions)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + positions.tobytes() + faces.tobytes())


def mitsuba_scene(mi: ModuleType, scene: Scene, folder: Path) -> Any:
    """Return the scene, shaded flat, without sensor."""
    triangles = scene_triangles(scene)
    content: dict[str, Any] = {"type": "scene"}
    keys = np.stack([triangles.material, triangles.light], axis=1)
    for number, (material_index, light) in enumerate(np.unique(keys, axis=0)):
        path = folder / f"part{number}.ply"
        write_ply(path, triangles, np.all(keys == (material_index, light), axis=1))
        material = scene.materials[material_index]
        shape: dict[str, Any] = {
            "type": "ply",
            "filename": str(path),
            "face_normals": True,
            "bsdf": {"type": "twosided", "nested": _bsdf(mi, material)},
        }
        if material.emits:
            shape["emitter"] = {"type": "area", "radiance": rgb(material.emission)}
        content[f"part{number}"] = shape
    for number, lamp in enumerate(scene.lights):
        if type(lamp) not in LIGHTS:
            raise ValueError(f"{type(lamp).__name__} is not among the compared lights")
        if lamp.spread > 0.0:
            raise ValueError("directional lights with an angle are not compared")
        if lamp.body() is None:
            content[f"light{number}"] = LIGHTS[type(lamp)](mi, lamp)
    content.update(_sky(mi, scene))
    return mi.load_dict(content)


def _bsdf(mi: ModuleType, material: Material) -> dict[str, Any]:
    if not material.is_glossy:
        return {"type": "diffuse", "reflectance": rgb(material.albedo)}
    return {
        "type": "gltf",
        "base_color": mi.ScalarColor3f(material.albedo),
        "metallic": material.metallic,
        "roughness": material.roughness,
        "f0": material.dielectric_color[0],
    }


def _directional(mi: ModuleType, lamp: DirectionalLight) -> dict[str, Any]:
    return {
        "type": "directional",
        "direction": list(lamp.direction),
        "irradiance": rgb(lamp.irradiance),
    }


def _rectangle(mi: ModuleType, lamp: RectangleLight) -> dict[str, Any]:
    """Return a rectangle from -1 to 1 in x and y, front +z, moved to the lamp's place."""
    half_u, half_v = 0.5 * np.array(lamp.edge_u), 0.5 * np.array(lamp.edge_v)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1] = half_u, half_v
    matrix[:3, 2] = np.cross(half_u, half_v)
    matrix[:3, 3] = np.array(lamp.corner) + half_u + half_v
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(matrix),
        "bsdf": {"type": "diffuse", "reflectance": rgb((0.0, 0.0, 0.0))},
        "emitter": {"type": "area", "radiance": rgb(lamp.radiance)},
    }


# What makes a Mitsuba emitter of a light of each compared kind that has no body.
LIGHTS: dict[type[Light], Callable[[ModuleType, Any], dict[str, Any]]] = {
    DirectionalLight: _directional,
    RectangleLight: _rectangle,
}


def _sky(mi: ModuleType, scene: Scene) -> dict[str, Any]:
    sky = scene.environment
    if isinstance(sky, ConstantEnvironment):
        return {"sky": {"type": "constant", "radiance": rgb(sky.radiance)}}
    if isinstance(sky, GradientEnvironment):
        y = np.cos(np.pi * (np.arange(SKY_ROWS) + 0.5) / SKY_ROWS)
        up = np.stack([np.sqrt(1.0 - y * y), y, np.zeros_like(y)], axis=-1)
        image = np.repeat(sky.sample(up)[:, None], 8, axis=1).astype(np.float32)
        return {"sky": {"type": "envmap", "bitmap": mi.Bitmap(image)}}
    if sky is not None:
        raise ValueError("environment maps are not compared")
    return {}


def render(
    mi: ModuleType,
    loaded: Any,
    camera: Camera,
    size: tuple[int, int],
    max_depth: int,
    spp: int,
    seed: int,
) -> NDArray[np.float64]:
    """Return one image (height, width, 3), pixels averaged over their area.

    `max_depth` counts edges of a path: 2 = direct light, -1 = no limit.
    """
    sensor = mi.load_dict(
        {
            "type": "perspective",
            "fov": camera.fov_y,
            "fov_axis": "y",
            "near_clip": 1e-3,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=list(camera.position), target=list(camera.target), up=list(camera.up)
            ),
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent", "sample_count": spp},
        }
    )
    integrator = mi.load_dict({"type": "path", "max_depth": max_depth, "rr_depth": 5})
    image = mi.render(loaded, sensor=sensor, integrator=integrator, spp=spp, seed=seed)
    return np.array(image, dtype=np.float64)
