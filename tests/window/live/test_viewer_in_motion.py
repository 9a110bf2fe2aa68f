"""What a viewer shows while it moves, within a budget and from the last picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from window.driven_viewer import FORWARD, FRAME_S, SETTINGS, SIZE, ask, settle

from ssdo_gl.scene.camera import Camera
from ssdo_gl.window.camera import Controls, jump_to
from ssdo_gl.window.input.bindings import Command
from ssdo_gl.window.viewer import Viewer

RED_AND_BLUE = (200, 10, 10), (10, 10, 200)


def test_budget_lowers_what_moves_and_rest_restores_it(gl, make_viewer) -> None:
    """With a budget nothing can hold, motion is coarse; at rest all of it is there."""
    viewer = make_viewer()
    viewer.budget_ms = 1e-3
    settle(viewer)
    still = viewer.presenter.pixels()
    for _ in range(60):
        viewer.frame(Controls(move=(0.0, 0.0, 1e-3)), FRAME_S, SIZE)
    assert viewer.left.governor.is_exhausted
    assert viewer.left.image.drawing.view.size[0] < SIZE[0]
    ask(viewer, Command.HOME)
    settle(viewer)
    assert viewer.left.image.drawing.view.size == SIZE
    assert np.array_equal(viewer.presenter.pixels(), still)


# Along a circle near things pass before far ones. Parallel rays that turn see walls that they
# were parallel to, and so does not all of the picture come from the last one; nor does, of a
# split view, what crosses its line.
@pytest.mark.parametrize(
    ("commands", "controls", "share"),
    [
        ((), Controls(orbit=(0.15, 0.05)), 0.4),
        ((Command.PROJECT,), Controls(turn=(0.05, 0.0)), 0.5),
        ((Command.SPLIT,), Controls(orbit=(0.15, 0.05)), 0.6),
    ],
)
def test_a_motion_begins_with_the_last_picture_as_the_camera_sees_it_now(
    gl, make_viewer, commands: tuple[Command, ...], controls: Controls, share: float
) -> None:
    settings = dataclasses.replace(SETTINGS, method="direct")
    size = 2 * SIZE[0], 2 * SIZE[1]

    def viewer_at(camera: Camera | None) -> Viewer:
        viewer = make_viewer(settings=settings)
        viewer.budget_ms, viewer.stretches = 1e-3, True
        # On its right there shall be another picture than on its left.
        viewer.view = dataclasses.replace(viewer.view, other_method="ssao")
        for command in commands:
            ask(viewer, command)
        if camera is not None:
            viewer.flight = jump_to(viewer.flight, camera)
        settle(viewer, size=size)
        return viewer

    viewer = viewer_at(None)
    before, drawing = viewer.presenter.pixels(), viewer.left.image.drawing
    viewer.frame(controls, FRAME_S, size)
    assert viewer.left.image.drawing is drawing
    followed = viewer.presenter.pixels()
    seen = viewer_at(viewer.camera)

    def error(pixels: np.ndarray) -> float:
        wanted = seen.presenter.pixels().reshape(SIZE[1], 2, SIZE[0], 2, 3).mean(axis=(1, 3))
        return float(np.abs(pixels.astype(float) - wanted).mean())

    assert followed.shape == (SIZE[1], SIZE[0], 3)
    least = error(before[::2, ::2])
    assert least > 5.0
    assert error(followed) < share * least
    viewer.frame(Controls(), FRAME_S, size)
    assert viewer.left.image.drawing is not drawing


def test_what_a_split_view_begins_to_move_with_stays_on_its_side(gl, make_viewer) -> None:
    viewer = make_viewer()
    viewer.stretches = True
    ask(viewer, Command.SPLIT)
    settle(viewer)
    presenter = viewer.presenter
    red, blue = (np.broadcast_to(np.uint8(c), (SIZE[1], SIZE[0] // 2, 3)) for c in RED_AND_BLUE)
    presenter.show(np.concatenate((red, blue), axis=1))
    turned = dataclasses.replace(viewer.camera, target=viewer.point_at((0.4, 0.5)))
    assert presenter.follow(turned, SIZE)
    pixels = presenter.pixels()
    middle = SIZE[0] // 2
    assert (pixels[:, : middle - 1] == RED_AND_BLUE[0]).all()
    assert (pixels[:, middle + 1 :] == RED_AND_BLUE[1]).all()
    assert (pixels[:, middle - 1 : middle + 1] == pixels[0, middle]).all()


def test_what_a_motion_begins_with_is_of_the_same_rays(gl, make_viewer) -> None:
    viewer = make_viewer()
    viewer.budget_ms, viewer.stretches = 1e-3, True
    settle(viewer)
    drawing = viewer.left.image.drawing
    ask(viewer, Command.PROJECT)
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert viewer.left.image.drawing is not drawing


def test_picture_that_rests_stays_whatever_its_last_frame_took(gl, viewer) -> None:
    settle(viewer)
    side = viewer.left
    side.governor.level = 0
    side._calibration_left = 24
    while side.governor.is_settled:
        side.governor.observe(2.0 * side.governor.budget_ms)
    before = viewer.presenter.pixels()
    assert not viewer.frame(Controls(), FRAME_S, SIZE)
    assert np.array_equal(viewer.presenter.pixels(), before)


def test_governor_that_cannot_decide_does_not_keep_the_picture_coarse(gl, make_viewer) -> None:
    """Times that are over the budget on the whole and under it of late, for ever."""
    viewer = make_viewer()
    settle(viewer)
    side = viewer.left
    side._restart_governor()
    side.governor.level = 3
    side.governor.observe = lambda frame_ms: 3
    viewer.touch()
    viewer.settings = dataclasses.replace(viewer.settings, seed=1)
    settle(viewer)
    assert viewer.left.image.drawing.view.size == SIZE
    assert viewer.left.is_done


def test_what_depth_costs_says_nothing_of_the_picture(gl, make_viewer) -> None:
    """It would come back at a level that has yet to be compiled."""
    viewer = make_viewer()
    levels = []
    for aov, level in (("beauty", 3), ("depth", 0), ("normal_ws", None), ("beauty", None)):
        viewer.view = dataclasses.replace(viewer.view, aov=aov)
        viewer.frame(FORWARD, FRAME_S, SIZE)
        levels.append(viewer.left.governor.level)
        if level is not None:
            viewer.left.governor.level = level
    assert levels[1:] == [3, 3, 3]


def test_no_budget_means_full_quality_in_motion(gl, make_viewer) -> None:
    viewer = make_viewer()
    viewer.is_governed = False
    viewer.budget_ms = 1e-3
    for _ in range(20):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    assert viewer.left.image.drawing.view.size == SIZE


def test_a_small_picture_is_stretched_by_who_shows_it(gl, viewer: Viewer) -> None:
    viewer.stretches = True
    # The first frame is of the cheapest level.
    viewer.frame(Controls(turn_rate=(0.1, 0.0)), FRAME_S, SIZE)
    assert viewer.left is not None
    assert viewer.left.level.frame_scale < 1.0
    assert viewer.presenter.picture is not None
    small = viewer.presenter.picture.size
    assert small[0] < 0.5 * SIZE[0]
    assert viewer.picture_size == SIZE
    assert viewer.pixels().shape == (SIZE[1], SIZE[0], 3)
    settle(viewer)
    assert viewer.presenter.picture.size == SIZE
