"""What each command does to the viewer."""

from __future__ import annotations

import dataclasses
import math
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

from ssdo_gl.images.files import OutputError
from ssdo_gl.options.command_line import loading_flags
from ssdo_gl.options.preset_files import preset_fields, write_preset
from ssdo_gl.scene.animate import camera_at
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.window.camera import (
    fit,
    focus_on,
    glide_to,
    go_home,
    jump_to,
    set_pivot,
    switch_projection,
)
from ssdo_gl.window.history import Edited
from ssdo_gl.window.input import Action, Command
from ssdo_gl.window.kept_files import Recent
from ssdo_gl.window.opening import reload_file
from ssdo_gl.window.saving import (
    PictureRequest,
    free_stem,
    light_elsewhere,
    picture_meta,
    save_scene,
    save_screenshot,
    view_command,
)
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS


class Host:
    """What a command may need of what is around the viewer: here nothing, as around a page.

    Attributes
    ----------
    recent : Recent
        Files that were opened last.
    defer : callable
        Does something between two frames: the panel is drawn within them, too.
    commands : mapping
        What it carries out itself.
    """

    def __init__(self) -> None:
        self.recent = Recent()
        self.defer: Callable[[Callable[[], object]], None] = lambda act: None
        self.commands: Mapping[Command, Callable[[], object]] = {}

    def permits(self, command: Command) -> bool:
        """Return whether a command may be carried out from there."""
        return True

    def cursor_uv(self) -> tuple[float, float]:
        """Return the cursor's place in the picture, 0..1 from the top left."""
        return 0.5, 0.5

    def set_clipboard(self, text: str) -> None:
        """Put `text` where other programs paste from."""

    def open(self, path: str) -> None:
        """Show the model, scene or preset at `path`, or a built-in scene."""

    def save_picture(self, request: PictureRequest) -> None:
        """Save a picture that was asked for."""


def perform(action: Action, viewer: Viewer, host: Host) -> None:
    """Carry out `action`; what goes wrong becomes a message."""
    if not host.permits(action.command):
        viewer.say(f"only in a window: {action.command.value}", key="refused")
        return
    try:
        if action.command in host.commands:
            host.commands[action.command]()
        elif action.command in _ACTIONS:
            _ACTIONS[action.command](viewer, host, action.number)
    except (OutputError, SettingError) as error:
        viewer.say(str(error), is_fault=True)


def _focus(viewer: Viewer, host: Host, number: int) -> None:
    point = viewer.pick(host.cursor_uv())
    if point is not None:
        viewer.flight = focus_on(viewer.flight, point)


def _fit(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    width, height = viewer.picture_size
    viewer.flight = fit(viewer.flight, viewer.fit_bounds, width / height)


def _pivot(viewer: Viewer, host: Host, number: int) -> None:
    viewer.flight = set_pivot(viewer.flight, viewer.point_at(host.cursor_uv()))


def _zoom(viewer: Viewer, host: Host, number: int) -> None:
    _pivot(viewer, host, number)
    distance = math.dist(viewer.flight.position, viewer.flight.pivot or viewer.camera.target)
    viewer.say(f"{distance:.3g} to the point under the cursor", key="wheel")


def _home(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    viewer.flight = go_home(viewer.flight)


def _next_camera(viewer: Viewer, host: Host, number: int) -> None:
    cameras = viewer.original.cameras
    if not cameras:
        viewer.say("the file has no camera of its own", key="camera")
        return
    viewer.tour.stop()
    viewer.camera_number = (viewer.camera_number + 1) % len(cameras)
    chosen = cameras[viewer.camera_number]
    camera = camera_at(chosen.camera, chosen.motion, viewer.clock.seconds)
    viewer.flight = jump_to(viewer.flight, camera)
    viewer.say(f"camera {viewer.camera_number}: {chosen.name or 'without a name'}", key="camera")


def _project(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    viewer.flight = switch_projection(viewer.flight)
    viewer.say("pinhole camera" if viewer.flight.height is None else "parallel rays")


def _show_image(viewer: Viewer, host: Host, number: int) -> None:
    viewer.view = viewer.view.with_number(number)
    viewer.say(viewer.view.aov)


def _method(step: int) -> Callable[[Viewer, Host, int], None]:
    def change(viewer: Viewer, host: Host, number: int) -> None:
        viewer.choose_method(viewer.view.with_next_method(step).method)
        viewer.say(METHOD_LABELS[viewer.view.method])

    return change


def _other_method(viewer: Viewer, host: Host, number: int) -> None:
    viewer.view = viewer.view.with_next_other_method()
    viewer.say(f"right: {METHOD_LABELS[viewer.view.other_method]}")


def _split(viewer: Viewer, host: Host, number: int) -> None:
    is_split = not viewer.view.is_split
    viewer.view = dataclasses.replace(viewer.view, is_split=is_split, is_error=False)
    if is_split:
        left, right = viewer.view.method, viewer.view.other_method
        viewer.say(f"{METHOD_LABELS[left]}  |  {METHOD_LABELS[right]}")


def _error(viewer: Viewer, host: Host, number: int) -> None:
    is_error = not viewer.view.is_error
    viewer.view = dataclasses.replace(viewer.view, is_error=is_error, is_split=False)
    if is_error:
        left, right = viewer.view.method, viewer.view.other_method
        viewer.say(f"difference of {METHOD_LABELS[left]} to {METHOD_LABELS[right]}")


def _inspect(viewer: Viewer, host: Host, number: int) -> None:
    viewer.is_inspecting = not viewer.is_inspecting
    viewer.touch()


def _pause(viewer: Viewer, host: Host, number: int) -> None:
    viewer.clock.toggle()
    _say_time(viewer)


def _step(viewer: Viewer, host: Host, number: int) -> None:
    viewer.clock.step()
    _say_time(viewer)


def _say_time(viewer: Viewer) -> None:
    seconds = f"{viewer.clock.seconds:.2f} s"
    if not viewer.clock.has_motion:
        viewer.say("nothing moves in this scene", key="pause")
    elif viewer.clock.is_running:
        viewer.say(f"goes on from {seconds}", key="pause")
    else:
        viewer.say(f"stopped at {seconds}; . goes one step on", key="pause")


def _screenshot(viewer: Viewer, host: Host, number: int) -> None:
    if viewer.presenter.picture is None:
        return
    stem = Path(viewer.source).stem
    scene = save_scene(viewer) if viewer.is_edited else None
    meta = picture_meta(viewer, scene)
    path = save_screenshot(viewer.folder, stem, viewer.pixels(), meta)
    also = f"; the edited scene is {scene.name}" if scene else ""
    viewer.say(f"wrote {path.name} and {path.with_suffix('.json').name}{also}")


def _save_preset(viewer: Viewer, host: Host, number: int) -> None:
    settings = viewer.settings_of_side(0)
    path = free_stem(viewer.folder, "preset", ".toml")
    write_preset(path, settings, viewer.original.render)
    # All of it: what the file leaves to its defaults is not what is shown at that time.
    viewer.presets = {**viewer.presets, path.stem: preset_fields(settings)}
    viewer.say(f"wrote {path.name}: --preset {path.name} reads it")


def _copy_command(viewer: Viewer, host: Host, number: int) -> None:
    scene = save_scene(viewer) if viewer.is_edited else None
    command = view_command(viewer, scene)
    host.set_clipboard(command)
    viewer.say(f"copied: {command}")
    if scene is not None:
        viewer.say(f"the edited scene is in {scene}")


def _save_scene(viewer: Viewer, host: Host, number: int) -> None:
    path = save_scene(viewer)
    viewer.say(f"wrote {path.resolve()}")
    if viewer.settings.overrides:
        viewer.say("settings of single passes are not in it: C copies them as --set")
    if flags := loading_flags(light_elsewhere(viewer)):
        viewer.say(f"it cannot name a map from another folder: open it with {shlex.join(flags)}")


def _material(viewer: Viewer, host: Host, number: int) -> None:
    name = viewer.choose_material(host.cursor_uv())
    viewer.say(f"material: {name}" if name else "no surface there", key="material")


def _undo(viewer: Viewer, host: Host, number: int) -> None:
    _go_to_step(viewer, viewer.history.undo(), "undone", "nothing to undo")


def _redo(viewer: Viewer, host: Host, number: int) -> None:
    _go_to_step(viewer, viewer.history.redo(), "redone", "nothing to redo")


def _go_to_step(viewer: Viewer, step: Edited | None, done: str, nothing: str) -> None:
    if step is None:
        viewer.say(nothing, key="undo")
        return
    viewer.say(f"{done}: {viewer.edited.difference(step)}", key="undo")
    viewer.go_to(step)
    viewer.history.arrive(viewer.edited)


def _reset(viewer: Viewer, host: Host, number: int) -> None:
    what = viewer.edited.difference(viewer.history.start)
    viewer.go_to(viewer.history.start)
    viewer.note_edits()
    viewer.say(f"as at the start: {what}" if what else "nothing was edited", key="undo")


def _store(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.store(number, viewer.camera)
    viewer.say(f"bookmark {number} kept in {viewer.tour.file.name}")


def _recall(viewer: Viewer, host: Host, number: int) -> None:
    camera = viewer.tour.recall(number)
    if camera is None:
        viewer.say(f"no bookmark {number}: keep one with Ctrl+{number}")
        return
    viewer.tour.stop()
    viewer.flight = glide_to(viewer.flight, camera)


def _record(viewer: Viewer, host: Host, number: int) -> None:
    if viewer.tour.is_recording:
        viewer.tour.stop_recording()
        viewer.say(f"path of {viewer.tour.path.seconds:.1f} s kept in {viewer.tour.file.name}")
    else:
        viewer.tour.start_recording(viewer.flight.camera())
        viewer.say("recording the camera: L ends it")


def _play(viewer: Viewer, host: Host, number: int) -> None:
    if viewer.tour.played_s is not None:
        viewer.stop_path()
    elif not viewer.tour.path.keys:
        viewer.say("no camera path yet: record one with L")
    else:
        viewer.tour.play()


def _governor(viewer: Viewer, host: Host, number: int) -> None:
    viewer.is_governed = not viewer.is_governed
    viewer.touch()
    held = f"held at {viewer.budget_ms:g} ms" if viewer.is_governed else "not limited"
    viewer.say(f"frame time: {held}")


# Of those that the host does not carry out; looking with the mouse is the input map's.
_ACTIONS: dict[Command, Callable[[Viewer, Host, int], None]] = {
    Command.FOCUS: _focus,
    Command.FIT: _fit,
    Command.HOME: _home,
    Command.NEXT_CAMERA: _next_camera,
    Command.PROJECT: _project,
    Command.COLLIDE: lambda viewer, host, number: viewer.toggle_collisions(),
    Command.VIEW: _show_image,
    Command.NEXT_METHOD: _method(1),
    Command.PREVIOUS_METHOD: _method(-1),
    Command.SPLIT: _split,
    Command.NEXT_OTHER_METHOD: _other_method,
    Command.ERROR: _error,
    Command.INSPECT: _inspect,
    Command.PAUSE: _pause,
    Command.STEP: _step,
    Command.RELOAD_SCENE: lambda viewer, host, number: reload_file(viewer),
    Command.SAVE_SCENE: _save_scene,
    Command.MATERIAL: _material,
    Command.UNDO: _undo,
    Command.REDO: _redo,
    Command.RESET: _reset,
    Command.SCREENSHOT: _screenshot,
    Command.SAVE_PRESET: _save_preset,
    Command.COPY_COMMAND: _copy_command,
    Command.STORE: _store,
    Command.RECALL: _recall,
    Command.RECORD: _record,
    Command.PLAY: _play,
    Command.GOVERNOR: _governor,
    Command.PIVOT: _pivot,
    Command.ZOOM: _zoom,
}
