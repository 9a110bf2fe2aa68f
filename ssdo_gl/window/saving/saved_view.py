"""What a window shows, as a command, as a scene file, as data beside a picture."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from ssdo_gl.images.files import OutputError, write_atomically
from ssdo_gl.options.command_line import command_line
from ssdo_gl.scene.lights import BLACK
from ssdo_gl.scene.load import builtin_names
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values
from ssdo_gl.settings.loading import FIT, USUAL, LoadOptions
from ssdo_gl.version import __version__
from ssdo_gl.window.live import REFINE_FRAMES
from ssdo_gl.window.saving.scene_files import render_table, scene_text
from ssdo_gl.window.saving.screenshot import free_stem
from ssdo_gl.window.viewer import Viewer


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
    loading = viewer.original.loading
    camera, asked = viewer.camera, viewer.loaded.render
    has_camera = scene is not None or camera is viewer.original.camera
    if scene is not None:
        # The file asks for what is shown.
        asked = {**asked, **render_table(settings_shown(viewer), asked)}
        loading = light_elsewhere(viewer)
    return command_line(
        viewer.source if scene is None else str(scene),
        settings,
        scene_settings=asked,
        camera=None if has_camera else camera,
        loading=loading,
        aov=viewer.view.aov,
        seconds=viewer.clock.seconds,
        out=out,
    )


def _base(viewer: Viewer) -> tuple[str, Path]:
    """Return what a scene file calls the present scene, and the folder it belongs in."""
    if viewer.source in builtin_names():
        return viewer.source, viewer.folder
    # A scene lies in the folder of what it is made from, and follows no links.
    source = Path(viewer.source).resolve()
    return source.name, source.parent


def _load_table(viewer: Viewer) -> dict[str, Any]:
    """Return how a scene file says that its base is read."""
    loading = viewer.original.loading
    table = loading.given()
    if loading.map_path is not None:
        folder, image = _base(viewer)[1].resolve(), Path(loading.map_path).resolve()
        table["light"] = image.relative_to(folder).as_posix() if folder in image.parents else ""
    camera = FIT if loading.frames_all else loading.camera
    return {n: v for n, v in {**table, "camera": camera}.items() if v not in (None, "")}


def light_elsewhere(viewer: Viewer) -> LoadOptions:
    """Return the light that a scene file cannot name: a map from another folder."""
    loading = viewer.original.loading
    is_named = loading.map_path is None or "light" in _load_table(viewer)
    return USUAL if is_named else LoadOptions(light=loading.light)


def save_scene(viewer: Viewer) -> Path:
    """Write a scene file that renders what the left side shows; return where.

    In the folder of what it is made from, of a built-in scene in that of the window; numbered,
    so that nothing is overwritten.

    Raises
    ------
    OutputError
        If nobody may write there.
    """
    base, folder = _base(viewer)
    path = free_stem(folder, Path(base).stem, ".toml")
    lights = [
        light if is_on else light.with_emitted(BLACK)
        for light, is_on in zip(viewer.lights, viewer.lights_on, strict=True)
    ]
    text = scene_text(
        base,
        viewer.loaded,
        load=_load_table(viewer),
        camera=viewer.camera,
        lights=lights,
        sources=viewer.light_sources,
        materials=viewer.original.materials,
        environment=viewer.original.environment,
        settings=settings_shown(viewer),
    )
    try:
        write_atomically(path, text.encode())
    except OutputError as error:
        raise OutputError(f"{error}; open a copy in a folder of your own to save it") from None
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
