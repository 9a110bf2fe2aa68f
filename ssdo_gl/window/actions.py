"""What each command does to the viewer."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from ssdo_gl import __version__
from ssdo_gl.images.files import OutputError
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import SceneError
from ssdo_gl.settings.command_line import command_line
from ssdo_gl.settings.fields import SettingError, values
from ssdo_gl.settings.preset_files import is_preset, preset_fields, write_preset
from ssdo_gl.window.bindings import Action, Command
from ssdo_gl.window.camera import (
    fit,
    focus_on,
    glide_to,
    go_home,
    set_pivot,
    switch_projection,
)
from ssdo_gl.window.live import REFINE_FRAMES
from ssdo_gl.window.screenshot import free_stem, save_screenshot
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS


class Host(Protocol):
    """What a command may need of the window around the viewer."""

    def cursor_uv(self) -> tuple[float, float]:
        """Return the cursor's place in the picture, 0..1 from the top left."""

    def set_clipboard(self, text: str) -> None:
        """Put `text` where other programs paste from."""

    def toggle_vsync(self) -> bool:
        """Wait for the display or no longer; return whether it now waits."""

    def toggle_fullscreen(self) -> None:
        """Fill the screen, or go back to a window."""

    def toggle_panel(self) -> None:
        """Show or hide the panel."""

    def toggle_help(self) -> None:
        """Show or hide the list of keys."""

    def let_go(self) -> None:
        """Hide the list of keys; give up a film."""

    def toggle_film(self) -> None:
        """Begin to export the camera path, or give it up."""

    def reload_shaders(self) -> None:
        """Compile what has changed."""

    def quit(self) -> None:
        """Close the window."""


def perform(action: Action, viewer: Viewer, host: Host) -> None:
    """Carry out `action`; what goes wrong becomes a message."""
    try:
        _ACTIONS[action.command](viewer, host, action.number)
    except (OutputError, SettingError) as error:
        viewer.say(str(error), is_fault=True)


def open_file(path: str, viewer: Viewer) -> bool:
    """Show the model or scene in `path`; a bad one leaves the present scene.

    A preset is taken over instead, and gets a button in the panel. Returns whether
    there is another scene.
    """
    if is_preset(path):
        _open_preset(path, viewer)
        return False
    try:
        scene = load_scene(path, viewer.original.loading)
        viewer.open(scene, path)
    except (SceneError, SettingError) as error:
        viewer.say(str(error), is_fault=True)
        return False
    # A file of somebody else's must not take the window, and what is in it, along.
    except Exception as error:
        viewer.say(f"{path}: cannot be opened: {fault_text(error)}", is_fault=True)
        return False
    viewer.say(f"opened {Path(path).name}: {scene.triangle_count} triangles")
    return True


def _open_preset(path: str, viewer: Viewer) -> None:
    if viewer.read_preset is None:
        return
    name = Path(path).stem
    try:
        viewer.add_preset(name, viewer.read_preset(path))
    except SettingError as error:
        viewer.say(f"{Path(path).name}: {error}", is_fault=True)
    except Exception as error:
        viewer.say(f"{path}: is no preset: {fault_text(error)}", is_fault=True)
    else:
        viewer.say(f"preset {name}")


def fault_text(error: Exception) -> str:
    """Return what went wrong in one line, whatever it was."""
    return " ".join(str(error).split()) or type(error).__name__


def view_command(viewer: Viewer, out: str = "view.png") -> str:
    """Return the command line that renders what the left side shows at rest."""
    width, height = viewer.picture_size
    settings = dataclasses.replace(
        viewer.settings_of_side(0), size=(width, height), antialias=REFINE_FRAMES
    )
    if viewer.original.is_metered and not settings.gives("exposure"):
        # From another camera another one would be measured.
        settings = dataclasses.replace(settings, exposure=viewer.original.camera.exposure)
    if not settings.is_reference:
        # There the flag asks for other settings, which the window has found by now.
        settings = dataclasses.replace(settings, max_error=None)
    camera = viewer.camera
    return command_line(
        viewer.source,
        settings,
        scene_settings=viewer.original.render,
        camera=None if camera is viewer.original.camera else camera,
        loading=viewer.original.loading,
        aov=viewer.view.aov,
        seconds=viewer.clock.seconds,
        out=out,
    )


def _focus(viewer: Viewer, host: Host, number: int) -> None:
    point = viewer.pick(host.cursor_uv())
    if point is not None:
        viewer.flight = focus_on(viewer.flight, point)


def _fit(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    width, height = viewer.picture_size
    viewer.flight = fit(viewer.flight, viewer.bounds, width / height)


def _pivot(viewer: Viewer, host: Host, number: int) -> None:
    viewer.flight = set_pivot(viewer.flight, viewer.point_at(host.cursor_uv()))


def _zoom(viewer: Viewer, host: Host, number: int) -> None:
    _pivot(viewer, host, number)
    distance = math.dist(viewer.flight.position, viewer.flight.pivot or viewer.camera.target)
    viewer.say(f"{distance:.3g} to the point under the cursor", key="wheel")


def _home(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    viewer.flight = go_home(viewer.flight)


def _project(viewer: Viewer, host: Host, number: int) -> None:
    viewer.tour.stop()
    viewer.flight = switch_projection(viewer.flight)
    viewer.say("pinhole camera" if viewer.flight.height is None else "parallel rays")


def _collide(viewer: Viewer, host: Host, number: int) -> None:
    viewer.toggle_collisions()


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
    seconds = f"{viewer.clock.seconds:.2f} s"
    if not viewer.clock.has_motion:
        viewer.say("nothing moves in this scene", key="pause")
    elif viewer.clock.is_running:
        viewer.say(f"goes on from {seconds}", key="pause")
    else:
        viewer.say(f"stopped at {seconds}; . goes one step on", key="pause")


def _step(viewer: Viewer, host: Host, number: int) -> None:
    viewer.clock.step()


def _screenshot(viewer: Viewer, host: Host, number: int) -> None:
    if viewer.presenter.picture is None:
        return
    stem = Path(viewer.source).stem
    path = save_screenshot(viewer.folder, stem, viewer.presenter.pixels(), picture_meta(viewer))
    viewer.say(f"wrote {path.name} and {path.with_suffix('.json').name}")


def picture_meta(viewer: Viewer) -> dict[str, Any]:
    """Return what made the picture, for the file beside it."""
    camera = viewer.camera
    sides = {"left": viewer.left, "right": viewer.right}
    return {
        "ssdo_gl": __version__,
        "command": view_command(viewer),
        "scene": viewer.source,
        "seconds": viewer.clock.seconds,
        "camera": dataclasses.asdict(camera),
        "view": dataclasses.asdict(viewer.view),
        "settings": values(viewer.settings),
        "renderer": viewer.device.renderer,
        "gl_version": viewer.device.version,
        "samples": {
            name: side.image.sample_count for name, side in sides.items() if side is not None
        },
    }


def _save_preset(viewer: Viewer, host: Host, number: int) -> None:
    settings = viewer.settings_of_side(0)
    path = free_stem(viewer.folder, "preset", ".toml")
    write_preset(path, settings, viewer.original.render)
    # All of it: what the file leaves to its defaults is not what is shown at that time.
    viewer.presets = {**viewer.presets, path.stem: preset_fields(settings)}
    viewer.say(f"wrote {path.name}: --preset {path.name} reads it")


def _copy_command(viewer: Viewer, host: Host, number: int) -> None:
    command = view_command(viewer)
    host.set_clipboard(command)
    viewer.say(f"copied: {command}")
    if viewer.scene is not viewer.original:
        viewer.say("the lights were edited here; the command uses those of the file")


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


def _vsync(viewer: Viewer, host: Host, number: int) -> None:
    viewer.say("waits for the display" if host.toggle_vsync() else "does not wait for the display")


def _host(call: Callable[[Host], object]) -> Callable[[Viewer, Host, int], None]:
    def ask(viewer: Viewer, host: Host, number: int) -> None:
        call(host)

    return ask


def _nothing(viewer: Viewer, host: Host, number: int) -> None:
    """The input map itself has taken note of it."""


_ACTIONS: dict[Command, Callable[[Viewer, Host, int], None]] = {
    Command.TOGGLE_PANEL: _host(lambda host: host.toggle_panel()),
    Command.TOGGLE_HELP: _host(lambda host: host.toggle_help()),
    Command.CAPTURE: _nothing,
    Command.RELEASE: _host(lambda host: host.let_go()),
    Command.FOCUS: _focus,
    Command.FIT: _fit,
    Command.HOME: _home,
    Command.PROJECT: _project,
    Command.COLLIDE: _collide,
    Command.VIEW: _show_image,
    Command.NEXT_METHOD: _method(1),
    Command.PREVIOUS_METHOD: _method(-1),
    Command.SPLIT: _split,
    Command.NEXT_OTHER_METHOD: _other_method,
    Command.ERROR: _error,
    Command.INSPECT: _inspect,
    Command.PAUSE: _pause,
    Command.STEP: _step,
    Command.RELOAD: _host(lambda host: host.reload_shaders()),
    Command.SCREENSHOT: _screenshot,
    Command.SAVE_PRESET: _save_preset,
    Command.COPY_COMMAND: _copy_command,
    Command.STORE: _store,
    Command.RECALL: _recall,
    Command.RECORD: _record,
    Command.PLAY: _play,
    Command.EXPORT: _host(lambda host: host.toggle_film()),
    Command.GOVERNOR: _governor,
    Command.VSYNC: _vsync,
    Command.FULLSCREEN: _host(lambda host: host.toggle_fullscreen()),
    Command.PIVOT: _pivot,
    Command.ZOOM: _zoom,
    Command.QUIT: _host(lambda host: host.quit()),
}
