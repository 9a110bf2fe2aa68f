"""Arrows and rings over the picture that move and turn a light."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imguizmo

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.light_edits import moved_lights
from ssdo_gl.scene.lights import Light
from ssdo_gl.window.viewer import Viewer

_gizmo = imguizmo.im_guizmo
# Length of an arrow, window coordinates at the scale of text 1; and as a part of the width
# of a small window.
ARM_PX, LARGEST_ARM = 80.0, 0.15
# Depths that the handle is drawn between, relative to the light's: nothing else is.
_NEAR, _FAR = 1e-3, 10.0


def can_turn(light: Light) -> bool:
    """Return whether it matters which way a light faces."""
    return bool(light.turned_fields)


class LightHandle:
    """What is dragged to move or turn one light of a viewer.

    Attributes
    ----------
    light : int or None
        Which one; None: there is no handle.
    turns : bool
        Whether the handle turns the light instead of moving it.
    is_hot, is_dragged : bool
        Whether the cursor is over it, and whether it is being dragged.
    """

    def __init__(self, viewer: Viewer) -> None:
        self.light: int | None = None
        self.turns = False
        self.is_hot = self.is_dragged = False
        self._viewer = viewer

    def toggle(self, light: int, *, turns: bool) -> None:
        """Show the handle that moves, or turns, a light; hide it if it is shown."""
        is_shown = (self.light, self.turns) == (light, turns)
        self.light, self.turns = None if is_shown else light, turns

    def hide(self) -> None:
        """Show no handle."""
        self.light, self.is_hot, self.is_dragged = None, False, False

    def draw(self, window_size: tuple[int, int], scale: float) -> None:
        """Draw the handle; move or turn the light as it has been dragged."""
        viewer = self._viewer
        if self.light is None or self.light >= len(viewer.lights):
            self.hide()
            return
        rest = viewer.lights[self.light]
        light = rest.at(viewer.clock.seconds)
        offset = self._dragged(light, window_size, scale)
        self.is_hot = _gizmo.is_over() or _gizmo.is_using()
        self.is_dragged = _gizmo.is_using()
        if offset is None:
            return
        if rest.motion is not None:
            stands = rest.motion.world_from_rest(viewer.clock.seconds)
            offset = np.linalg.inv(stands) @ offset @ stands
        viewer.lights[:] = moved_lights(viewer.original, viewer.lights, self.light, offset)
        viewer.apply_lights()

    def _dragged(
        self, light: Light, window_size: tuple[int, int], scale: float
    ) -> FloatArray | None:
        """Issue the handle; return the rigid (4, 4) matrix of its last step, if there was one."""
        camera = self._viewer.camera
        # What has no place is turned in the middle of the picture.
        anchor = np.asarray(light.place or camera.target, np.float64)
        depth = max(float(np.linalg.norm(anchor - camera.position)), 1e-3 * camera.distance)
        # float32 tells places apart that are near the middle of the scene.
        middle = 0.5 * (self._viewer.bounds[0] + self._viewer.bounds[1])
        view, model = np.eye(4), math3d.translation(anchor - middle)
        view[:3, :3] = camera.view_from_world_rotation()
        view[:3, 3] = view[:3, :3] @ (middle - camera.position)
        is_parallel = camera.height is not None
        near = -_FAR * depth if is_parallel else _NEAR * depth
        clip = camera.projection(window_size, near, _FAR * depth)
        _gizmo.begin_frame()
        _gizmo.set_rect(0.0, 0.0, *map(float, window_size))
        _gizmo.set_orthographic(is_parallel)
        _gizmo.set_gizmo_size_clip_space(min(2.0 * ARM_PX * scale / window_size[0], LARGEST_ARM))
        kind = _gizmo.OPERATION.rotate if self.turns else _gizmo.OPERATION.translate
        matrix = _for_gizmo(model)
        before = _from_gizmo(matrix)
        world = _gizmo.MODE.world
        if not _gizmo.manipulate(_for_gizmo(view), _for_gizmo(clip), kind, world, matrix):
            return None
        after = _from_gizmo(matrix)
        if not self.turns:
            return math3d.translation(after[:3, 3] - before[:3, 3])
        # Rounded to float32 it is no rotation: edges would grow with every step.
        u, _, vt = np.linalg.svd(after[:3, :3])
        turn = np.eye(4)
        turn[:3, :3] = u @ vt
        return np.asarray(math3d.translation(anchor) @ turn @ math3d.translation(-anchor))


def _for_gizmo(matrix: FloatArray) -> imguizmo.im_guizmo.Matrix16:
    return _gizmo.Matrix16([float(value) for value in matrix.T.ravel()])


def _from_gizmo(matrix: imguizmo.im_guizmo.Matrix16) -> FloatArray:
    return np.asarray(matrix.values, np.float64).reshape(4, 4).T
