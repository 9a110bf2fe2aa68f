"""Cameras and lights of glTF nodes."""

from __future__ import annotations

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, vector
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, number, numbers
from ssdo_gl.scene.formats.gltf.ranges import Ranges
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.lights import Light, kind_of_gltf
from ssdo_gl.scene.numbers import LARGEST_NUMBER
from ssdo_gl.settings.fields import shown
from ssdo_gl.settings.settings import LONGEST, SHORTEST


def read_light(
    document: Document, index: int, world: FloatArray, model: Model, ranges: Ranges
) -> Light | None:
    """Return a light of KHR_lights_punctual; it shines along the node's -z.

    None, with a note, if its node gives it no direction.
    """
    lights = document.json["extensions"]["KHR_lights_punctual"]["lights"]
    if not isinstance(index, int) or not 0 <= index < len(lights):
        raise GltfError(f"refers to light {index}, but there are {len(lights)}")
    light, where = lights[index], f"light {index}"
    strength = number(light, "intensity", 1.0, where)
    color = numbers(light, "color", (1.0, 1.0, 1.0), where) * strength
    color = ranges.nearest(color, 0.0, LARGEST_NUMBER, "colour times intensity", where)
    spot = light.get("spot", {})
    for key in ("outerConeAngle", "innerConeAngle"):
        ranges.number(spot, key, 0.0, where, high=0.5 * np.pi)
    name = str(light.get("name", ""))
    kind = kind_of_gltf(light["type"])
    if kind is None:
        raise GltfError(f"light {index}: unknown type {shown(light['type'])}")
    # The node's scale does not count: one axis may even vanish.
    backward = world[:3, 2] if world[:3, 2].any() else np.cross(world[:3, 0], world[:3, 1])
    if kind.direction_fields and not backward.any():
        model.note(f"light {name or index} dropped: its node is scaled to zero")
        return None
    forward = -math3d.normalized(backward) if backward.any() else np.array([0.0, 0.0, -1.0])
    try:
        return kind.from_gltf(light, vector(world[:3, 3]), vector(forward), vector(color), name)
    except ValueError as error:
        raise GltfError(f"light {index}: {error}") from None


def read_camera(camera: Json, world: FloatArray, model: Model, name: str) -> Camera | None:
    """Return the camera of a node, turned to the middle of the model.

    None, with a note, if it sees nothing.
    """
    height, fov_y, fault = None, 40.0, ""
    if camera.get("type") == "orthographic":
        half = number(camera["orthographic"], "ymag", np.nan, "camera")
        # Negative ones are out of use; they mean the same.
        height = 2.0 * abs(half)
        if not SHORTEST <= height <= LONGEST:
            fault = f"ymag = {half:g}: expected {SHORTEST:g} to {LONGEST:g}"
    else:
        fov_y = float(np.degrees(number(camera["perspective"], "yfov", np.nan, "camera")))
        if not 0.0 < fov_y < 180.0:
            fault = f"yfov = {fov_y:g} degrees: expected 0 to 180"
    position, backward, up = world[:3, 3], world[:3, 2], world[:3, 1]
    if not (backward.any() and up.any()):
        fault = "its node is scaled to zero"
    if fault:
        model.note(f"camera {name or 'without a name'} dropped: {fault}")
        return None
    forward = -math3d.normalized(backward)
    target = position + forward * _distance_ahead(model, position, forward)
    up = math3d.normalized(up)
    return Camera(vector(position), vector(target), vector(up), fov_y, height=height)


def _distance_ahead(model: Model, position: FloatArray, forward: FloatArray) -> float:
    """Return how far ahead the middle of the scene lies: a natural pivot."""
    middles = [
        o.world_from_object[:, :3, :3] @ np.mean(model.meshes[o.mesh].bounds(), axis=0)
        + o.world_from_object[:, :3, 3]
        for o in model.objects
    ]
    if not middles:
        return 1.0
    offset = np.mean(np.concatenate(middles), axis=0) - position
    ahead = float(offset @ forward)
    return ahead if ahead > 0.0 else max(float(np.linalg.norm(offset)), 1e-6)
