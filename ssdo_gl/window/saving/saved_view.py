"""What a window shows, as a command, as a scene file, as data beside a picture."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import OutputError, write_atomically
from ssdo_gl.options.command_line import command_line
from ssdo_gl.process import home_folder
from ssdo_gl.scene.lights import BLACK
from ssdo_gl.scene.load import builtin_names
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values
from ssdo_gl.version import __version__
from ssdo_gl.window.live import REFINE_FRAMES
from ssdo_gl.window.saving.scene_files import base_name, render_table, scene_text, write_scene
from ssdo_gl.window.saving.screenshot import free_stem
from ssdo_gl.window.viewer import Viewer

# Formats that name no other file.
_WHOLE = (".ply", ".stl", ".off")
# Of a .glb: before its JSON, whose length is the fourth number.
_HEADER = struct.Struct("<5I")


def settings_shown(viewer: Viewer) -> Settings:
    """Return the settings that render what the left side shows at rest."""
    settings = dataclasses.replace(
        viewer.settings_of_side(0), size=viewer.picture_size, antialias=REFINE_FRAMES
    )
    if viewer.original.is_metered and not settings.gives("exposure"):
        # From another camera another one would be measured.
        settings = dataclasses.replace(settings, exposure=viewer.original.camera.exposure)
    if not settings.is_reference:
        # There the flag asks for other settings, which the window has found by now.
        settings = dataclasses.replace(settings, max_error=None)
    return settings


def view_command(
    viewer: Viewer,
    scene: Path | None = None,
    out: str = "view.png",
    settings: Settings | None = None,
) -> str:
    """Return the command line that renders what the left side shows at rest.

    Parameters
    ----------
    scene : Path or None
        What `save_scene` wrote of a scene that was edited.
    settings : Settings or None
        Instead of those that are shown.
    """
    settings = settings or settings_shown(viewer)
    camera, asked = viewer.camera, viewer.loaded.render
    has_camera = scene is not None or camera is viewer.original.camera
    if scene is not None:
        # The file asks for what is shown.
        asked = {**asked, **render_table(settings_shown(viewer), asked)}
    return command_line(
        viewer.source if scene is None else str(scene),
        settings,
        scene_settings=asked,
        camera=None if has_camera else camera,
        loading=viewer.original.loading,
        aov=viewer.view.aov,
        seconds=viewer.clock.seconds,
        out=out,
    )


def save_scene(viewer: Viewer) -> Path:
    """Write a scene file that renders what the left side shows; return where.

    In the folder of what it is made from, of a built-in scene in the present one; numbered, so
    that nothing is overwritten. Where that cannot be written, in the present folder or that of
    the user, beside a copy of a model that is all in one file; a message says so.

    Raises
    ------
    OutputError
        If there is no such place.
    """
    is_builtin = viewer.source in builtin_names()
    source = Path(viewer.source)
    usual = viewer.folder if is_builtin else source.parent
    try:
        return _write_scene(viewer, viewer.source, usual)
    except OutputError as error:
        fault = str(error)
    if not (is_builtin or is_in_one_file(source)):
        raise OutputError(f"{fault}; save from a copy of {source.name} in a folder of your own")
    for folder in filter(None, (viewer.folder, home_folder())):
        try:
            name = viewer.source if is_builtin else str(copy_of(source, folder))
            path = _write_scene(viewer, name, folder)
        except OutputError:
            continue
        also = "" if is_builtin else f", and a copy of {source.name}"
        viewer.say(
            f"{usual.resolve()} cannot be written: {path.name} is in {folder.resolve()}{also}"
        )
        return path
    raise OutputError(fault)


def _write_scene(viewer: Viewer, source: str, folder: Path) -> Path:
    path = free_stem(folder, Path(source).stem, ".toml")
    lights = [
        light if is_on else light.with_emitted(BLACK)
        for light, is_on in zip(viewer.lights, viewer.lights_on, strict=True)
    ]
    text = scene_text(
        base_name(source, folder),
        viewer.loaded,
        camera=viewer.camera,
        lights=lights,
        sources=viewer.light_sources,
        materials=viewer.original.materials,
        environment=viewer.original.environment,
        settings=settings_shown(viewer),
    )
    write_scene(path, text)
    return path


def picture_meta(viewer: Viewer, scene: Path | None) -> dict[str, Any]:
    """Return what made the picture, for the file beside it."""
    camera = viewer.camera
    sides = {"left": viewer.left, "right": viewer.right}
    return {
        "ssdo_gl": __version__,
        "command": view_command(viewer, scene),
        "scene": viewer.source if scene is None else str(scene),
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


def is_in_one_file(path: Path) -> bool:
    """Return whether a model needs no other file."""
    if path.suffix.lower() in _WHOLE:
        return True
    if path.suffix.lower() != ".glb":
        return False
    try:
        with path.open("rb") as file:
            length = _HEADER.unpack(file.read(_HEADER.size))[3]
            return b'"uri"' not in file.read(length)
    except (OSError, struct.error):
        return False


def copy_of(path: Path, folder: Path) -> Path:
    """Return a copy of `path` in `folder`, the one that is there already, or one that is made.

    Raises
    ------
    OutputError
        If it cannot be made, or another file has its name.
    """
    copy = folder / path.name
    try:
        data = path.read_bytes()
        if copy.exists() and copy.read_bytes() != data:
            raise OutputError(f"{copy}: is another file")
    except OSError as error:
        raise OutputError(f"{path}: cannot be copied: {error.strerror}") from None
    write_atomically(copy, data)
    return copy
