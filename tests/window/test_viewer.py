"""The viewer without a window: moves, rests, and does what commands ask for."""

from __future__ import annotations

import dataclasses
import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ssdo_gl.bench.presets import NAMES, load_preset
from ssdo_gl.cli import main
from ssdo_gl.effects.methods import METHODS
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import AOVS, Settings
from ssdo_gl.window import scene_flight
from ssdo_gl.window.actions import perform
from ssdo_gl.window.camera import Controls, jump_to
from ssdo_gl.window.film.export import FilmExport
from ssdo_gl.window.input.bindings import Action, Command
from ssdo_gl.window.live import REFINE_FRAMES, inspect
from ssdo_gl.window.opening import opened
from ssdo_gl.window.opening.opened import open_file
from ssdo_gl.window.saving.saved_view import view_command
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import View, divider_hit

SIZE = (48, 27)
RED_AND_BLUE = (200, 10, 10), (10, 10, 200)
SETTINGS = Settings("bounce", samples=8, steps=4)
FORWARD = Controls(move=(0.0, 0.0, 1.0))
FRAME_S = 1.0 / 30.0
# Both are averages of the same 16 frames, one in float32 and one in float64.
ROUNDING = 1


class FakeHost:
    """A host that only remembers what it was asked for."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.clipboard = ""

    def permits(self, command: Command) -> bool:
        return True

    def cursor_uv(self) -> tuple[float, float]:
        return 0.5, 0.6

    def set_clipboard(self, text: str) -> None:
        self.clipboard = text

    def toggle_vsync(self) -> bool:
        return False

    def __getattr__(self, name: str) -> Callable[[], None]:
        return lambda: self.asked.append(name)


@pytest.fixture
def make_viewer(device: Device, shaders: ShaderLibrary, tmp_path: Path):
    """Make viewers that are released at the end."""
    made = []

    def make(source: str = "cornell_meso", settings: Settings = SETTINGS) -> Viewer:
        viewer = Viewer(
            device,
            load_scene(source),
            settings,
            source=source,
            folder=tmp_path,
            shaders=shaders,
        )
        made.append(viewer)
        return viewer

    yield make
    for viewer in made:
        viewer.release()


@pytest.fixture
def viewer(make_viewer) -> Viewer:
    return make_viewer()


def settle(viewer: Viewer, limit: int = 300, size: tuple[int, int] = SIZE) -> int:
    """Let frames pass until nothing is left to do; return how many it took."""
    for count in range(limit):
        # The first frame notices what has changed, as the one after an event does.
        viewer.frame(Controls(), FRAME_S, size)
        if not viewer.is_busy:
            return count
    raise AssertionError("the picture does not come to rest")


def ask(viewer: Viewer, command: Command, number: int = 0) -> FakeHost:
    host = FakeHost()
    perform(Action(command, number), viewer, host)
    return host


def said(viewer: Viewer) -> str:
    return " | ".join(line.text for line in viewer.messages.lines)


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


@pytest.mark.parametrize("suffix", [".webp", ".png"])
def test_film_of_the_path_in_each_format(gl, viewer, tmp_path, suffix: str) -> None:
    viewer.choose_method("direct")
    viewer.frame(Controls(), FRAME_S, SIZE)
    films = FilmExport(viewer)
    films.toggle()
    assert not films.is_busy
    assert "record one" in said(viewer)
    ask(viewer, Command.RECORD)
    for _ in range(6):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    viewer.film_suffix = suffix
    films.toggle()
    size, seen = viewer.picture_size, []
    while films.step():
        seen.append(viewer.presenter.pixels())
        assert "wrote" in said(viewer) or " left" in said(viewer)
    assert "wrote" in said(viewer)
    assert viewer.picture_size == size == seen[0].shape[1::-1]
    assert not np.array_equal(seen[0], seen[-1])
    if suffix == ".png":
        with Image.open(sorted((tmp_path / "cornell_meso-001").iterdir())[0]) as first:
            assert np.array_equal(np.asarray(first)[:, :, :3], seen[0])
    viewer.frame(Controls(), FRAME_S, SIZE)
    assert not np.array_equal(viewer.presenter.pixels(), seen[-1])
    made = {path.name for path in tmp_path.iterdir() if "views" not in path.name}
    assert made == {"cornell_meso-001.webp" if suffix == ".webp" else "cornell_meso-001"}
    films.toggle()
    films.step()
    films.toggle()
    assert not films.is_busy
    assert {path.name for path in tmp_path.iterdir() if "views" not in path.name} == made


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


def test_bad_file_keeps_the_scene_and_says_why(gl, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    bad = tmp_path / "broken.obj"
    bad.write_text("v nonsense")
    assert not open_file(str(bad), viewer)
    assert "broken.obj" in said(viewer)
    assert any(line.is_fault for line in viewer.messages.lines)
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), before)


def test_dropped_model_replaces_the_scene(gl, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    model = tmp_path / "triangle.obj"
    model.write_text("v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n")
    assert open_file(str(model), viewer)
    settle(viewer)
    assert viewer.source == str(model)
    assert viewer.settings.samples == SETTINGS.samples
    assert viewer.view.method == viewer.settings.method
    assert viewer.diagonal == pytest.approx(100.0 * 2**0.5)
    assert not np.array_equal(viewer.presenter.pixels(), before)
    assert viewer.presenter.pixels().std() > 5.0


def test_dropped_preset_is_taken_over_and_a_bad_one_is_not(gl, viewer, tmp_path) -> None:
    viewer.read_preset = load_preset
    good = tmp_path / "mine.toml"
    good.write_text('[settings]\nmethod = "ssdo"\nsamples = 24\n')
    assert not open_file(str(good), viewer), "the scene is still the same"
    assert (viewer.view.method, viewer.settings.samples) == ("ssdo", 24)
    assert viewer.source == "cornell_meso"
    bad = tmp_path / "bad.toml"
    bad.write_text("[settings]\nsamples = -3\n")
    before = viewer.settings
    assert not open_file(str(bad), viewer)
    assert viewer.settings == before
    assert viewer.messages.lines[-1].is_fault
    assert "bad.toml" in viewer.messages.lines[-1].text
    assert "samples" in viewer.messages.lines[-1].text
    assert list(viewer.presets) == ["mine"]


@pytest.mark.parametrize(
    "fields",
    [
        {"samples": 10**6},
        {"exposure": float("nan")},
        {"overrides": {"ssao.strenth": 2.0}},
        {"overrides": {"nothing.strength": 2.0}},
        {"estimater": "march"},
    ],
)
def test_preset_that_nobody_has_checked_is_a_message(gl, viewer, tmp_path, fields) -> None:
    viewer.read_preset = lambda path: fields
    file = tmp_path / "mine.toml"
    file.write_text("[settings]\n")
    before = viewer.settings, viewer.view
    open_file(str(file), viewer)
    assert (viewer.settings, viewer.view) == before
    assert viewer.messages.lines[-1].is_fault
    assert "mine.toml" in said(viewer)
    assert not viewer.presets


@pytest.mark.parametrize("error", [MemoryError(), RecursionError("deep"), ValueError("a\nb")])
def test_file_that_makes_a_reader_fail_is_a_message(gl, viewer, monkeypatch, error) -> None:
    def load(path: str) -> None:
        raise error

    monkeypatch.setattr(opened, "load_scene", load)
    before = viewer.scene
    assert not open_file("some.glb", viewer)
    assert viewer.scene is before
    assert "some.glb: cannot be opened" in said(viewer)
    assert "\n" not in said(viewer)


def test_scene_whose_settings_do_not_fit_is_a_message(gl, viewer, tmp_path) -> None:
    file = tmp_path / "other.toml"
    file.write_text(
        '[render]\nestimator = "zbuffer"\nmethod = "ssao"\n[[object]]\nshape = "box"\n'
        "min = [0, 0, 0]\nmax = [1, 1, 1]\n"
    )
    viewer.settings = dataclasses.replace(viewer.settings, method="ssdo")
    before = viewer.scene, viewer.flight, viewer.tour
    opened = open_file(str(file), viewer)
    assert opened == (viewer.scene is not before[0])
    settle(viewer)


@pytest.mark.parametrize("key", ["_take", "start_flight"])
def test_scene_that_cannot_be_flown_through_leaves_the_one_before(
    gl, viewer, tmp_path, monkeypatch, key: str
) -> None:
    settle(viewer)
    before = viewer._state()
    model = tmp_path / "triangle.obj"
    model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    def fail(*_: object) -> None:
        raise ValueError("no")

    target = viewer if key == "_take" else scene_flight
    monkeypatch.setattr(target, key, fail)
    assert not open_file(str(model), viewer)
    assert viewer._state() == before
    settle(viewer)


def test_saved_preset_can_be_chosen_again(gl, viewer) -> None:
    perform(Action(Command.SAVE_PRESET), viewer, FakeHost())
    viewer.settings = dataclasses.replace(viewer.settings, samples=64, overrides={"a.b": 1})
    viewer.choose_method("direct")
    viewer.choose_preset("preset-001")
    assert viewer.settings == SETTINGS
    assert viewer.view.method == SETTINGS.method


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


def test_bookmarks_are_kept_and_recalled(gl, viewer, make_viewer) -> None:
    for _ in range(10):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    settle(viewer)
    place = viewer.camera.position
    ask(viewer, Command.STORE, 3)
    other = make_viewer()
    assert other.tour.numbers == [3]
    ask(other, Command.RECALL, 3)
    settle(other)
    assert other.camera.position == pytest.approx(place, abs=1e-5)
    ask(other, Command.RECALL, 4)
    assert "no bookmark 4" in said(other)


def test_path_is_recorded_played_and_kept(gl, viewer, make_viewer) -> None:
    ask(viewer, Command.RECORD)
    for _ in range(30):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    end = viewer.camera.position
    assert viewer.tour.path.seconds == pytest.approx(1.0, abs=0.15)
    other = make_viewer()
    ask(other, Command.PLAY)
    other.frame(Controls(), 0.0, SIZE)
    assert other.camera.position == pytest.approx(viewer.scene.camera.position)
    for _ in range(40):
        other.frame(Controls(), FRAME_S, SIZE)
    assert other.tour.played_s is None
    # Keys are a tenth of a second apart: the end may be cut by as much.
    assert np.linalg.norm(np.subtract(other.camera.position, end)) < 0.1
    settle(other)


def test_input_takes_over_from_a_playing_path(gl, viewer) -> None:
    ask(viewer, Command.RECORD)
    for _ in range(20):
        viewer.frame(FORWARD, FRAME_S, SIZE)
    ask(viewer, Command.RECORD)
    ask(viewer, Command.PLAY)
    for _ in range(5):
        viewer.frame(Controls(), FRAME_S, SIZE)
    there = viewer.camera.position
    viewer.frame(Controls(move=(1.0, 0.0, 0.0)), FRAME_S, SIZE)
    assert viewer.tour.played_s is None
    assert np.linalg.norm(np.subtract(viewer.camera.position, there)) < 0.1


def test_play_without_a_path_says_so(viewer) -> None:
    ask(viewer, Command.PLAY)
    assert "record one" in said(viewer)
    assert viewer.tour.played_s is None


@pytest.mark.parametrize("command", list(Command))
def test_every_command_can_be_given_at_any_time(gl, viewer, command: Command) -> None:
    for _ in range(2):
        ask(viewer, command, 1)
        viewer.frame(Controls(), FRAME_S, SIZE)


def test_folder_that_cannot_be_written_to_is_a_message(gl, viewer) -> None:
    settle(viewer)
    viewer.folder = Path("/nonexistent")
    ask(viewer, Command.SCREENSHOT)
    assert "cannot be written" in said(viewer)


KEY = "[0, 0, 0, 3, 0, 0, -1, 1, 40]"


@pytest.mark.parametrize(
    "text",
    [
        "nonsense",
        "[" * 100_000,
        "[]",
        '{"bookmarks": []}',
        '{"bookmarks": {"1": {"position": [0, 0, 0], "target": [0, 0, -1], "fov_y": 0}}}',
        '{"bookmarks": {"1": {"position": [1e300, 0, 0], "target": [0, 1, 0], "fov_y": 9}}}',
        '{"bookmarks": {"1": {"position": [1e17, 0, 0], "target": [1e17, 0, 9], "fov_y": 9}}}',
        '{"bookmarks": {"1": {"position": [%s, 0, 0], "target": [0, 0, 9], "fov_y": 40}}}'
        % ("9" * 400),
        '{"bookmarks": {"1": 5}}',
        '{"path": 5}',
        '{"path": [[%s, 0, 0, 3, 0, 0, -1, 1, 40]]}' % ("9" * 400),
        '{"path": [[0, 1e300, 0, 3, 0, 0, -1, 1, 40]]}',
        '{"path": [[0, 0, 0, 3, 0, 0, 0, 1, 40]]}',
        f'{{"path": [{KEY}, {KEY}]}}',
        f'{{"path": [{KEY.replace("40", "NaN")}]}}',
    ],
)
def test_views_file_that_is_damaged_is_a_message_and_kept(
    gl, make_viewer, tmp_path, text: str
) -> None:
    file = tmp_path / "cornell_meso.views.json"
    file.write_text(text)
    viewer = make_viewer()
    assert "views.json" in said(viewer)
    viewer.frame(Controls(), FRAME_S, SIZE)
    ask(viewer, Command.STORE, 1)
    assert "move it away" in said(viewer)
    assert file.read_text() == text


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
