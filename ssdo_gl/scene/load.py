"""From a name, a scene file or a model file to a Scene."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl import resources
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.formats import SUFFIXES, read_model
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.formats.toml.table import suggestion
from ssdo_gl.scene.scene import Scene, SceneError


def load_scene(source: str | Path) -> Scene:
    """Load a scene.

    Parameters
    ----------
    source : str or Path
        A ``.toml`` scene, a model file (``.glb .gltf .obj .ply .stl .off``), or the
        name of a built-in scene.

    Raises
    ------
    SceneError
        One line that names the file and key, the value, and what would be valid.
    """
    text = str(source)
    suffix = Path(text).suffix.lower()
    if suffix == ".toml":
        return _load_toml(Path(text), text)
    if suffix in SUFFIXES:
        return _load_model(Path(text), text)
    names = builtin_names()
    if text in names:
        file = resources.folder("scenes") / f"{text}.toml"
        return read_description(file.read_text(encoding="utf-8"), f"scenes/{text}.toml")
    if text and (suffix or "/" in text or "\\" in text or Path(text).exists()):
        valid = ", ".join((".toml", *SUFFIXES))
        raise SceneError(f"{text}: expected a file ending in one of {valid}")
    raise SceneError(f"no built-in scene is called {text!r}; {suggestion(text, names)}")


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes, sorted."""
    folder = resources.folder("scenes")
    return sorted(
        file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml")
    )


def _load_toml(path: Path, source: str) -> Scene:
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise SceneError(f"{source}: no such file") from None
    except UnicodeDecodeError as error:
        raise SceneError(f"{source}: byte {error.start} is not UTF-8 text") from None
    except OSError as error:
        raise SceneError(f"{source}: cannot be read: {error.strerror}") from None
    # TOML ends lines with LF or CRLF; a text with another mix fails in the parser.
    return read_description(text.replace("\r\n", "\n"), source, path)


def _load_model(path: Path, source: str) -> Scene:
    model = read_model(path, source)
    builder = SceneBuilder(source)
    for item in model.add_to(builder):
        builder.add(item)
    builder.lights += model.lights
    return builder.build(model.camera, None, exposure=None, title=path.stem)
