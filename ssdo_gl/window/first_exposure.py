"""Exposes a scene for its first picture before a flight through it begins."""

from __future__ import annotations

import dataclasses

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


def exposed(
    scene: Scene, settings: Settings, camera: Camera | None, device: Device, shaders: ShaderLibrary
) -> Scene:
    """Return the scene with the exposure that what `camera` sees asks for, noted.

    As it is, if its camera's exposure holds.
    """
    if scene.metering_slack is None or scene.is_metered:
        return scene
    settings = dataclasses.replace(settings, exposure=None, is_resolved=False)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        notes = renderer.expose(camera)
        return dataclasses.replace(renderer.scene, notes=(*scene.notes, *notes))
