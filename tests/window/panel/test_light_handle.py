"""Arrows and rings that move and turn a light, dragged by a cursor without a window."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import glfw
import numpy as np
import pytest
from window.overlay.drawn_overlay import SIZE, DrawnOverlay

from ssdo_gl import math3d
from ssdo_gl.scene.light_edits import new_light
from ssdo_gl.scene.lights import KINDS, DirectionalLight, RectangleLight, SpotLight
from ssdo_gl.scene.motion import Motion

MIDDLE = SIZE[0] // 2, SIZE[1] // 2
DRAG_PX = 12


@pytest.fixture
def drawn(device, shaders, tmp_path) -> Iterator[DrawnOverlay]:
    drawn = DrawnOverlay(device, shaders, "cornell_meso", tmp_path)
    drawn.frames(2)
    yield drawn
    drawn.release()


def reach(drawn: DrawnOverlay) -> int:
    """Put the cursor on the handle, right of its middle; return how far."""
    for way in range(DRAG_PX, 120, 2):
        drawn.overlay.cursor(MIDDLE[0] + way, MIDDLE[1])
        drawn.frames(1)
        if drawn.overlay.wants_mouse:
            return way
    raise AssertionError("there is no handle")


def drag(drawn: DrawnOverlay, start: tuple[int, int], step: tuple[int, int]) -> None:
    """Drag from `start`, in three steps."""
    assert not drawn.overlay.is_busy
    drawn.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS)
    drawn.frames(2)
    for number in range(1, 4):
        drawn.overlay.cursor(start[0] + number * step[0], start[1] + number * step[1])
        drawn.frames(1)
        assert drawn.overlay.is_busy
    drawn.overlay.button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE)
    drawn.frames(2)
    assert not drawn.overlay.is_busy


@pytest.mark.parametrize("kind", ["point", "spot", "area"])
def test_an_arrow_moves_a_light_along_its_axis(gl, drawn: DrawnOverlay, kind: str) -> None:
    viewer = drawn.viewer
    distance = 0.3 * viewer.diagonal
    viewer.add_light(new_light(KINDS[kind], viewer.camera, distance))
    drawn.overlay.light_handle.toggle(2, turns=False)
    drawn.frames(2)
    before = viewer.lights[2]
    way = reach(drawn)
    drag(drawn, (MIDDLE[0] + way, MIDDLE[1]), (DRAG_PX, 0))
    offset = np.subtract(viewer.lights[2].place, before.place)
    # As far as the cursor has gone, in the plane of the light.
    pixel = 2.0 * distance * np.tan(np.radians(viewer.camera.fov_y / 2.0)) / SIZE[1]
    assert offset == pytest.approx((3 * DRAG_PX * pixel, 0.0, 0.0), rel=0.1, abs=1e-5)
    assert viewer.scene.lights[2] == viewer.lights[2]


@pytest.mark.parametrize("kind", ["spot", "directional", "area"])
def test_a_ring_turns_a_light_about_itself(gl, drawn: DrawnOverlay, kind: str) -> None:
    viewer = drawn.viewer
    light = new_light(KINDS[kind], viewer.camera, 0.3 * viewer.diagonal)
    # Aside: the ring turns about the axis that the camera looks along.
    aside = light.moved(math3d.transform_matrix(rotate=(0.0, 40.0, 0.0)))
    viewer.add_light(aside.moved_to(light.place) if light.place else aside)
    drawn.overlay.light_handle.toggle(2, turns=True)
    drawn.frames(2)
    before = viewer.lights[2]
    way = reach(drawn)
    drag(drawn, (MIDDLE[0] + way, MIDDLE[1]), (0, DRAG_PX))
    after = viewer.lights[2]
    assert after != before
    assert after.place == pytest.approx(before.place) if before.place else after.place is None
    if isinstance(after, RectangleLight) and isinstance(before, RectangleLight):
        edges = np.array([after.edge_u, after.edge_v])
        lengths = np.linalg.norm([before.edge_u, before.edge_v], axis=1)
        assert edges @ edges.T == pytest.approx(np.diag(lengths**2), abs=1e-9)
    else:
        assert isinstance(after, (SpotLight, DirectionalLight))
        assert np.linalg.norm(after.direction) == pytest.approx(1.0)


def test_a_moving_light_is_dragged_where_it_stands(gl, drawn: DrawnOverlay) -> None:
    viewer = drawn.viewer
    motion = Motion(orbit=(0.0, 90.0, 0.0))
    # So that it is in the middle of the picture by then.
    light = new_light(KINDS["point"], viewer.camera, 0.3 * viewer.diagonal)
    rest = light.moved(np.linalg.inv(motion.world_from_rest(1.0)))
    viewer.add_light(dataclasses.replace(rest, motion=motion))
    viewer.clock.seconds = 1.0
    drawn.overlay.light_handle.toggle(2, turns=False)
    drawn.frames(2)
    before = viewer.lights[2].at(1.0).place
    way = reach(drawn)
    drag(drawn, (MIDDLE[0] + way, MIDDLE[1]), (DRAG_PX, 0))
    offset = np.subtract(viewer.lights[2].at(1.0).place, before)
    assert offset[0] > 0.01
    assert offset[1:] == pytest.approx((0.0, 0.0), abs=1e-5)


def test_handles_go_with_their_light_and_with_the_panel(gl, drawn: DrawnOverlay) -> None:
    handle = drawn.overlay.light_handle
    handle.toggle(1, turns=False)
    drawn.frames(1)
    assert handle.light == 1
    drawn.viewer.remove_light(1)
    drawn.frames(1)
    assert handle.light is None
    handle.toggle(0, turns=True)
    drawn.overlay.shows_panel = False
    drawn.frames(1)
    assert handle.light is None
