"""From the text of a scene to the scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ssdo_gl.scene import files
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.environment import sun_of
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.formats.toml import materials, objects
from ssdo_gl.scene.formats.toml.based import read_based_scene
from ssdo_gl.scene.formats.toml.scene_tables import (
    read_camera,
    read_environment,
    read_height,
    read_light,
    read_render_settings,
)
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.loading import USUAL, LoadOptions
from ssdo_gl.toml_text import read_toml

TOP_KEYS = ("title", "purpose", "camera", "environment", "render", "materials", "light", "object")


def read_file(path: Path, source: str, options: LoadOptions = USUAL) -> Scene:
    """Return the scene of a .toml file.

    Parameters
    ----------
    source : str
        What errors call the file.

    Raises
    ------
    SceneError
        As `read_description`, or if the file cannot be read or is not UTF-8.
    """
    try:
        text = files.read_file(path, source).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{source}: byte {error.start} is not UTF-8 text") from None
    # TOML ends lines with LF or CRLF; a text with another mix fails in the parser.
    return read_description(text.replace("\r\n", "\n"), source, path, options)


def read_description(
    text: str, source: str, file: Path | None = None, options: LoadOptions = USUAL
) -> Scene:
    """Return the scene that a TOML text describes.

    Parameters
    ----------
    source : str
        What errors call the text, usually the file as the user named it.
    file : Path or None
        The file it comes from; meshes and images are looked up in its folder.
        None: the text may not name files.

    Raises
    ------
    SceneError
        One line naming `source`, the key (or line and column), the value and what
        would be valid.
    """
    try:
        data = read_toml(text)
    except ValueError as error:
        raise SceneError(f"{source}: {error}") from None
    top = Table(source, "", data)
    if "base" in top:
        return read_based_scene(top, file, options)
    top.allow(*TOP_KEYS)
    builder = SceneBuilder(source, options)
    environment = read_environment(top.table("environment"), file, builder)
    if sun := sun_of(environment):
        builder.lights.append(sun)
    render = read_render_settings(top.table("render"))
    material_of_name = materials.read_materials(top.table("materials"), file, builder)
    for table in top.tables("light"):
        read_light(table, builder)
    for table in top.tables("object"):
        objects.read_object(table, file, material_of_name, builder)
    camera_table = top.table("camera") or Table(source, "[camera]", {})
    camera, fov_y, exposure = read_camera(camera_table)
    scene = builder.build(
        Scene,
        camera,
        environment,
        exposure=exposure,
        fov_y=fov_y,
        height=read_height(camera_table),
        render=render,
        title=top.text("title", ""),
        purpose=top.text("purpose", ""),
    )
    # A lamp that was added to a room has no usual strength for which to say an exposure.
    has_lamp = scene.added_light_count and isinstance(scene.lights[-1], RectangleLight)
    is_measured = has_lamp and "exposure" not in camera_table
    return replace(scene, metering_slack=0.0) if is_measured else scene
