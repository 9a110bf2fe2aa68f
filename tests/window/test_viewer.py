"""The viewer without a window: moves, rests, and does what commands ask for."""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from window.driven_viewer import FORWARD, FRAME_S, ROUNDING, SETTINGS, SIZE, ask, said, settle

from ssdo_gl.bench.presets import NAMES, load_preset
from ssdo_gl.cli import main
from ssdo_gl.settings import AOVS
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.input.bindings import Command
from ssdo_gl.window.live import REFINE_FRAMES, inspect
from ssdo_gl.window.saving.saved_view import view_command
from ssdo_gl.window.views import View, divider_hit


def test_comes_to_rest_and_then_draws_nothing(gl, viewer) -> None:
    settle(viewer)
    assert viewer.left.image.is_refined
    before = viewer.presenter.pixels()
    assert before.std() > 10.0
    assert not viewer.frame(Controls(), FRAME_S, SIZE)
    assert np.array_equal(viewer.presenter.pixels(), before)
    assert viewer.monitor.alarm is None


def test_all_light_on_a_translucent_surface_comes_to_rest(gl, make_viewer, tmp_path) -> None:
    """It is another surface in each frame, whose probes are traced anew."""
    file = tmp_path / "pane.toml"
    file.write_text(
        '[materials.pane]\nopacity = 0.5\n[environment]\nkind = "constant"\nradiance = [1, 1, 1]\n'
        '[[object]]\nshape = "box"\nmin = [-1, 0, -1]\nmax = [1, 0.1, 1]\n'
        '[[object]]\nshape = "box"\nmin = [-1, 1, -1]\nmax = [1, 1.1, 1]\nmaterial = "pane"\n'
    )
    viewer = make_viewer(str(file), dataclasses.replace(SETTINGS, method="gi"))
    settle(viewer)
    assert viewer.left.image.sample_count == REFINE_FRAMES


def test_walking_changes_the_picture_and_home_brings_it_back(gl, viewer) -> None:
    settle(viewer)
    before = viewer.presenter.pixels().astype(int)
    for _ in range(15):
        assert viewer.frame(FORWARD, FRAME_S, SIZE)
    assert viewer.camera.position[2] < 3.4
    settle(viewer)
    walked = viewer.presenter.pixels().astype(int)
    assert np.abs(walked - before).mean() > 5.0
    ask(viewer, Command.HOME)
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), before)


def test_the_copied_command_renders_the_same_picture(gl, device, viewer, tmp_path) -> None:
    for _ in range(10):
        viewer.frame(Controls(move=(0.3, 0.0, 1.0), turn_rate=(0.4, -0.1)), FRAME_S, SIZE)
    settle(viewer)
    host = ask(viewer, Command.COPY_COMMAND)
    assert host.clipboard == view_command(viewer)
    picture = viewer.presenter.pixels().astype(int)
    out = tmp_path / "again.png"
    command = host.clipboard.replace("view.png", str(out))
    assert main(shlex.split(command)[1:]) == 0
    device.activate()
    with Image.open(out) as image:
        again = np.asarray(image).astype(int)
    assert picture.std() > 10.0
    assert np.abs(again - picture).max() <= ROUNDING


def test_parallel_rays_come_at_a_key_and_are_copied_along(gl, device, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    ask(viewer, Command.PROJECT)
    for _ in range(5):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    settle(viewer)
    picture = viewer.presenter.pixels().astype(int)
    assert viewer.camera.height is not None
    host = ask(viewer, Command.COPY_COMMAND)
    out = tmp_path / "again.png"
    assert main(shlex.split(host.clipboard.replace("view.png", str(out)))[1:]) == 0
    device.activate()
    with Image.open(out) as image:
        again = np.asarray(image).astype(int)
    assert np.abs(again - picture).max() <= ROUNDING
    ask(viewer, Command.HOME)
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), before)


@pytest.mark.parametrize("number", range(1, len(AOVS) + 1))
def test_number_keys_show_each_image(gl, viewer, number: int) -> None:
    ask(viewer, Command.VIEW, number)
    settle(viewer)
    assert viewer.view.aov == AOVS[number - 1]
    if viewer.view.aov not in ("directional", "specular"):
        assert viewer.presenter.pixels().max() > 0


@pytest.mark.parametrize("method", list(METHODS)[:4])
def test_methods_follow_one_another(gl, make_viewer, method: str) -> None:
    viewer = make_viewer(settings=dataclasses.replace(SETTINGS, method=method))
    ask(viewer, Command.NEXT_METHOD)
    assert viewer.view.method == list(METHODS)[list(METHODS).index(method) + 1]
    ask(viewer, Command.PREVIOUS_METHOD)
    settle(viewer)
    assert viewer.left.image.renderer.settings.method == method


def test_estimator_of_another_method_is_dropped(viewer) -> None:
    viewer.settings = dataclasses.replace(viewer.settings, method="ssao", estimator="zbuffer")
    viewer.choose_method("ssdo")
    viewer.settings.checked()
    assert viewer.settings.estimator is None


def test_presets_set_quality_and_one_of_them_the_method(gl, viewer) -> None:
    viewer.presets = {name: load_preset(name) for name in NAMES}
    for name in NAMES:
        viewer.choose_preset(name)
        viewer.settings.checked()
        viewer.settings_of_side(0).checked()
    assert viewer.view.method == "reference-gi"
    assert "--max-error" in view_command(viewer)
    viewer.choose_method("ssao")
    viewer.choose_preset("fast")
    viewer.settings_of_side(0).checked()
    assert viewer.view.method == "ssao"
    assert "--max-error" not in view_command(viewer)


def test_split_and_difference(gl, viewer) -> None:
    viewer.view = dataclasses.replace(viewer.view, other_method="direct")
    settle(viewer)
    whole = viewer.presenter.pixels().astype(int)
    ask(viewer, Command.SPLIT)
    settle(viewer)
    split = viewer.presenter.pixels().astype(int)
    assert np.array_equal(split[:, : SIZE[0] // 2 - 2], whole[:, : SIZE[0] // 2 - 2])
    assert np.abs(split[:, SIZE[0] // 2 + 2 :] - whole[:, SIZE[0] // 2 + 2 :]).mean() > 2.0
    ask(viewer, Command.ERROR)
    assert not viewer.view.is_split
    settle(viewer)
    assert viewer.right is not None
    ask(viewer, Command.ERROR)
    settle(viewer)
    assert viewer.right is None
    assert np.array_equal(viewer.presenter.pixels(), whole)


def test_error_view_measures_the_error(gl, viewer) -> None:
    viewer.view = dataclasses.replace(viewer.view, other_method="direct")
    ask(viewer, Command.ERROR)
    settle(viewer)
    against_direct = viewer.monitor.error
    assert against_direct is not None and against_direct > 0.05
    viewer.view = dataclasses.replace(viewer.view, other_method=viewer.view.method)
    settle(viewer)
    assert viewer.monitor.error == pytest.approx(0.0, abs=1e-6)
    ask(viewer, Command.ERROR)
    settle(viewer)
    assert viewer.monitor.error is None


def test_error_of_another_pair_is_not_shown(gl, viewer) -> None:
    viewer.view = dataclasses.replace(viewer.view, other_method="direct")
    ask(viewer, Command.ERROR)
    settle(viewer)
    assert viewer.monitor.is_error_final
    viewer.choose_method("ssao")
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert viewer.monitor.error is None
    settle(viewer)
    assert viewer.monitor.error is not None
    viewer.frame(FORWARD, FRAME_S, SIZE)
    assert viewer.monitor.error is None


def test_error_against_a_reference_runs_along_with_its_rays(gl, viewer) -> None:
    viewer.settings = dataclasses.replace(viewer.settings, spp=256)
    viewer.view = dataclasses.replace(viewer.view, other_method="reference-near")
    ask(viewer, Command.ERROR)
    running = {}
    for _ in range(600):
        viewer.frame(Controls(), FRAME_S, SIZE)
        monitor = viewer.monitor
        # The first are of pictures that have not their full size yet: not to be compared.
        is_full = viewer.left.image.plane.texture.size == SIZE
        if is_full and monitor.error is not None and not monitor.is_error_final:
            running[viewer.right.image.sample_count] = monitor.error
        if not viewer.is_busy:
            break
    assert len(set(running.values())) >= 2
    assert viewer.monitor.is_error_final
    assert 0.0 <= viewer.monitor.uncertainty <= viewer.monitor.error
    assert running[min(running)] > viewer.monitor.error > 0.0


def test_value_that_is_not_finite_raises_the_alarm(gl, viewer) -> None:
    viewer.view = dataclasses.replace(viewer.view, aov="direct")
    settle(viewer)
    texture = viewer.left.image.last_plane.texture
    values = np.zeros((*SIZE[::-1], 4), np.float32)
    values[3, 5] = np.nan
    texture.write(values.tobytes())
    viewer.monitor.is_due = True
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert viewer.monitor.alarm is not None
    assert viewer.monitor.alarm.count == 1
    viewer.restart()
    settle(viewer)
    assert viewer.monitor.alarm is None


def test_divider_is_grabbed_where_it_is() -> None:
    view = View(is_split=True, divider=0.25)
    assert divider_hit(view, 102.0, 400.0)
    assert not divider_hit(view, 110.0, 400.0)
    assert not divider_hit(dataclasses.replace(view, is_split=False), 100.0, 400.0)
    assert view.with_divider(-3.0).divider > 0.0
    assert view.with_divider(9.0).divider < 1.0


def test_window_without_pixels_draws_nothing(gl, viewer) -> None:
    assert not viewer.frame(FORWARD, FRAME_S, (0, 0))
    assert viewer.presenter.picture is None
    settle(viewer)
    assert not viewer.frame(Controls(), FRAME_S, (0, 40))
    settle(viewer)


def test_resizing_keeps_the_picture(gl, viewer) -> None:
    settle(viewer)
    small = viewer.presenter.pixels()
    viewer.frame(Controls(), FRAME_S, (96, 54))
    assert viewer.picture_size == (96, 54)
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), small)


def test_focus_and_orbit_take_the_point_under_the_cursor(gl, viewer) -> None:
    settle(viewer)
    point = viewer.pick((0.5, 0.6))
    assert point is not None
    ask(viewer, Command.PIVOT)
    assert viewer.flight.pivot == point
    ask(viewer, Command.FOCUS)
    settle(viewer)
    after = viewer.pick((0.5, 0.5))
    # The picture is 27 pixels high: a pixel is 0.03 units wide at that distance.
    assert np.linalg.norm(np.subtract(after, point)) < 0.1


def test_near_a_wall_the_same_key_goes_less_far(gl, viewer) -> None:
    def step_from(position: tuple[float, float, float]) -> float:
        camera = dataclasses.replace(
            viewer.scene.camera, position=position, target=(0.0, 0.0, -9.0)
        )
        viewer.flight = viewer.flight.__class__(
            **{**vars(viewer.flight), "position": position, "velocity": (0.0, 0.0, 0.0)}
        )
        viewer.frame(Controls(), FRAME_S, SIZE)
        before = np.array(viewer.camera.position)
        for _ in range(5):
            viewer.frame(Controls(move=(1.0, 0.0, 0.0)), FRAME_S, SIZE)
        assert camera.fov_y == viewer.camera.fov_y
        return float(np.linalg.norm(viewer.camera.position - before))

    assert step_from((0.5, 0.6, -0.95)) < 0.5 * step_from((0.0, 0.0, 3.6))


def test_collisions_keep_the_camera_in_the_room(gl, viewer) -> None:
    viewer.settings = dataclasses.replace(viewer.settings, method="direct")
    viewer.choose_method("direct")
    assert not viewer.collides
    ask(viewer, Command.COLLIDE)
    for _ in range(150):
        viewer.frame(Controls(move=(0.1, 0.0, 1.0), fast=True), FRAME_S, SIZE)
    assert viewer.camera.position[2] > -1.0
    ask(viewer, Command.COLLIDE)
    for _ in range(30):
        viewer.frame(Controls(move=(0.0, 0.0, 1.0), fast=True), FRAME_S, SIZE)
    assert viewer.camera.position[2] < -1.0


def test_carousel_runs_stops_and_steps(gl, make_viewer) -> None:
    viewer = make_viewer("carousel")
    for _ in range(5):
        assert viewer.is_busy
        viewer.frame(Controls(), FRAME_S, SIZE)
    assert viewer.clock.seconds == pytest.approx(5 * FRAME_S)
    moving = viewer.presenter.pixels().astype(int)
    ask(viewer, Command.PAUSE)
    settle(viewer)
    assert viewer.clock.seconds == pytest.approx(5 * FRAME_S)
    ask(viewer, Command.STEP)
    assert "stopped at 0.20 s" in said(viewer)
    settle(viewer)
    assert viewer.clock.seconds == pytest.approx(5 * FRAME_S + 1 / 30)
    viewer.clock.seconds = 1.0
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert np.abs(viewer.presenter.pixels() - moving).max() > 10


@pytest.mark.parametrize("command", [Command.PAUSE, Command.STEP])
def test_still_scene_says_that_nothing_moves(viewer, command) -> None:
    ask(viewer, command)
    assert "nothing moves" in said(viewer)
    assert not viewer.clock.is_running


def test_lights_are_edited_and_restored(gl, viewer) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    viewer.lights_on = [False] * len(viewer.lights)
    viewer.apply_lights()
    settle(viewer)
    assert viewer.presenter.pixels().max() == 0
    viewer.lights_on = [True] * len(viewer.lights)
    viewer.apply_lights()
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), before)
    viewer.lights[0] = viewer.lights[0].with_emitted((0.0, 9.0, 0.0))
    viewer.apply_lights()
    settle(viewer)
    green = viewer.presenter.pixels().astype(int)
    assert (green[:, :, 1] - green[:, :, 0]).mean() > 5.0


def test_screenshot_and_settings_lie_side_by_side(gl, viewer, tmp_path) -> None:
    settle(viewer)
    ask(viewer, Command.SCREENSHOT)
    ask(viewer, Command.SCREENSHOT)
    files = {path.name for path in tmp_path.iterdir()}
    assert {f"cornell_meso-00{i}.{s}" for i in (1, 2) for s in ("png", "json")} <= files
    meta = json.loads((tmp_path / "cornell_meso-001.json").read_text())
    assert meta["command"].startswith("ssdo-gl cornell_meso --snapshot")
    assert meta["settings"]["samples"] == SETTINGS.samples
    with Image.open(tmp_path / "cornell_meso-001.png") as image:
        assert np.array_equal(np.asarray(image), viewer.presenter.pixels())


@pytest.mark.parametrize("command", list(Command))
def test_every_command_can_be_given_at_any_time(gl, viewer, command: Command) -> None:
    for _ in range(2):
        ask(viewer, command, 1)
        viewer.frame(Controls(), FRAME_S, SIZE)


def test_folder_that_cannot_be_written_to_is_a_message(gl, viewer, tmp_path: Path) -> None:
    settle(viewer)
    viewer.folder = tmp_path / "file"
    viewer.folder.write_text("")
    ask(viewer, Command.SCREENSHOT)
    assert "cannot be written" in said(viewer)


def test_a_frame_in_the_making_leaves_nothing_of_the_last_one_to_look_at(gl, viewer) -> None:
    """Other images are drawn for who looks at values, and what held the last may be freed."""
    settle(viewer)
    ask(viewer, Command.INSPECT)
    viewer.frame(Controls(), 1.0, SIZE)
    viewer.frame(Controls(), 1.0, SIZE)
    viewer.is_inspecting = False
    viewer.settings = dataclasses.replace(viewer.settings, seed=1)
    settle(viewer)
    ask(viewer, Command.INSPECT)
    seen = []
    for _ in range(3):
        viewer.frame(Controls(), 1.0, SIZE, lambda *_: seen.append(viewer.inspected))
        drawing = viewer.inspected
        assert drawing is not None
        assert inspect(viewer.device.gl, drawing, (0.5, 0.5)) is not None
    assert seen
    assert seen[0] is None
