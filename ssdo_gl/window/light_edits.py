"""Changes a light of a scene together with the body that is seen of it. Pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.scene.light import DirectionalLight, Light, RectangleLight
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import Scene
from ssdo_gl.window.camera.orientation import Vector, difference

BLACK: Color = (0.0, 0.0, 0.0)


def power_of(light: Light) -> Color:
    """Return how bright a light is: intensity, irradiance or radiance."""
    if isinstance(light, RectangleLight):
        return light.radiance
    return light.irradiance if isinstance(light, DirectionalLight) else light.intensity


def power_unit(light: Light) -> str:
    """Return the name and unit of `power_of`."""
    if isinstance(light, RectangleLight):
        return "radiance, W/sr/m²"
    return "irradiance, W/m²" if isinstance(light, DirectionalLight) else "intensity, W/sr"


def with_power(light: Light, power: Color) -> Light:
    """Return the light with another brightness."""
    if isinstance(light, RectangleLight):
        return dataclasses.replace(light, radiance=power)
    if isinstance(light, DirectionalLight):
        return dataclasses.replace(light, irradiance=power)
    return dataclasses.replace(light, intensity=power)


def place_of(light: Light) -> Vector | None:
    """Return where the light is (a rectangle's centre); None for a direction."""
    if isinstance(light, DirectionalLight):
        return None
    if isinstance(light, RectangleLight):
        x, y, z = (
            c + 0.5 * (u + v)
            for c, u, v in zip(light.corner, light.edge_u, light.edge_v, strict=True)
        )
        return x, y, z
    return light.position


def moved_to(light: Light, place: Vector) -> Light:
    """Return the light at another place; a directional one stays as it is."""
    if isinstance(light, RectangleLight):
        before = place_of(light) or place
        x, y, z = (c + d for c, d in zip(light.corner, difference(place, before), strict=True))
        return dataclasses.replace(light, corner=(x, y, z))
    if isinstance(light, DirectionalLight):
        return light
    return dataclasses.replace(light, position=place)


def with_lights(original: Scene, lights: Sequence[Light], on: Sequence[bool]) -> Scene:
    """Return `original` with its lights replaced by `lights`, dark where not `on`.

    The body that stands for a rectangle light in the picture follows it: it moves by
    as much, and its emission changes by the same factors.

    Parameters
    ----------
    original : Scene
        As it was loaded.
    lights : sequence of Light
        One for each light of `original`, of the same kind.
    on : sequence of bool
    """
    shining = tuple(
        light if is_on else with_power(light, BLACK)
        for light, is_on in zip(lights, on, strict=True)
    )
    materials = list(original.materials)
    objects = []
    for item in original.objects:
        if item.light is None or shining[item.light] == original.lights[item.light]:
            objects.append(item)
            continue
        before, after = original.lights[item.light], shining[item.light]
        material = original.materials[item.material]
        emission = [
            e * new / old if old > 0.0 else new
            for e, old, new in zip(
                material.emission, power_of(before), power_of(after), strict=True
            )
        ]
        materials.append(
            dataclasses.replace(material, emission=(emission[0], emission[1], emission[2]))
        )
        objects.append(_moved(item, before, after, len(materials) - 1))
    return dataclasses.replace(
        original, lights=shining, materials=tuple(materials), objects=tuple(objects)
    )


def _moved(item: SceneObject, before: Light, after: Light, material: int) -> SceneObject:
    start, end = place_of(before), place_of(after)
    matrices = item.world_from_object
    if start is not None and end is not None and start != end:
        offset = math3d.translation(np.subtract(end, start))
        matrices = np.asarray(offset @ matrices)
    return dataclasses.replace(item, world_from_object=matrices, material=material)
