"""The lights of a scene: plain data in world space, one file for each kind.

A new kind is a module here, ``shaders/lights/<kind>.glsl`` with its functions (see
``shaders/lights/lights.glsl``), and a test.
"""

from __future__ import annotations

from ssdo_gl.package_members import classes_in
from ssdo_gl.scene.lights.base import BLACK, SHADOW_NUMBERS, BoundsOf, Form, Light, Shadow
from ssdo_gl.scene.lights.directional_light import DirectionalLight
from ssdo_gl.scene.lights.point_light import PointLight, PunctualLight
from ssdo_gl.scene.lights.rectangle_light import RectangleLight
from ssdo_gl.scene.lights.spot_light import SpotLight


def found_kinds() -> dict[str, type[Light]]:
    """Return the kinds that modules of this folder define, by the name in scene files."""
    kinds = (kind for kind in classes_in(__name__) if issubclass(kind, Light))
    return {kind.kind_in_files or kind.kind: kind for kind in kinds}


# Shaders number kinds in this order.
KINDS = found_kinds()


def kind_number(light: Light) -> int:
    """Return the number of the light's kind in shaders."""
    return list(KINDS.values()).index(type(light))


def kind_of_gltf(name: str) -> type[Light] | None:
    """Return the kind that glTF's KHR_lights_punctual calls `name`."""
    return next((kind for kind in KINDS.values() if kind.gltf_type == name), None)
