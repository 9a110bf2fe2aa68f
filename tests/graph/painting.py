"""Passes that paint one value and count their runs, and frames to run them in."""

from __future__ import annotations

import numpy as np

from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene


class Paint(RenderPass):
    """Clears its target to a value and counts how often it ran."""

    def __init__(self, name, value=1.0, reads=(), depends_on=(), own=False, transient=False):
        self.name = name
        self.value = value
        self.reads = tuple(reads)
        self.writes = {name: TextureSpec(1, own=own, transient=transient)}
        self.depends_on = tuple(depends_on)
        self.runs = 0

    def settings_key(self):
        return self.value

    def execute(self, context):
        self.runs += 1
        if self.writes[self.name].own:
            texture = context.gl.texture((1, 1), 1, np.float32(self.value).tobytes(), dtype="f4")
            return {self.name: texture}
        context.target.clear(self.value)
        return None


def triangle_scene():
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    return Scene((mesh,), (Material(),), (SceneObject(0, 0),), Camera((0, 0, 3), (0, 0, 0)))


def frame(size=(4, 3), **versions):
    view = FrameView(size, np.zeros(3), np.eye(3), (1.0, 0.75), 0.1, 10.0)
    return Frame(view, triangle_scene(), versions=versions)


def chain():
    """A raw image and its filter, twice: the second raw image may reuse the first's texture."""
    return [
        Paint("raw_1", transient=True),
        Paint("smooth_1", reads=["raw_1"]),
        Paint("raw_2", reads=["smooth_1"], transient=True),
        Paint("smooth_2", reads=["raw_2"]),
    ]
