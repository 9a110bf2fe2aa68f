"""Reader of .mtl material libraries of Wavefront .obj files."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from PIL import Image

from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.images import read_texture
from ssdo_gl.scene.material import Color, Material, Texture
from ssdo_gl.scene.paths import contained_file
from ssdo_gl.scene.scene import SceneError

# Cut-out masks of .mtl files carry no threshold of their own.
CUTOFF = 0.5
# Numbers that each option of a texture statement takes.
_OPTION_ARGUMENTS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2}
_NORMAL_MAPS = ("bump", "map_bump", "norm", "map_kn", "disp")


def read_mtl(owner: Path, name: str, model: Model, where: str) -> dict[str, Material]:
    """Return the materials of a library that an .obj file names.

    A library or texture that is missing is noted in `model`, not an error: models are
    often passed on without them.
    """
    try:
        path = contained_file(owner, name, f"{where}: mtllib")
        text = path.read_text(encoding="utf-8", errors="replace")
    except SceneError as error:
        model.note(f"materials not read: {error}")
        return {}
    blocks: dict[str, dict[str, list[str]]] = {}
    current: dict[str, list[str]] = {}
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0].lower() == "newmtl":
            current = blocks.setdefault(" ".join(words[1:]), {})
        else:
            current[words[0].lower()] = words[1:]
    shown = f"{where}: {path.name}"
    return {title: _material(title, block, path, model, shown) for title, block in blocks.items()}


def _material(
    name: str, block: dict[str, list[str]], owner: Path, model: Model, where: str
) -> Material:
    texture = _texture(block.get("map_kd"), owner, model, where)
    albedo = _color(block, "kd", (0.8, 0.8, 0.8), where)
    if texture is not None and not any(albedo):
        albedo = (1.0, 1.0, 1.0)
        model.note(f"material {name!r}: Kd 0 would hide its texture: taken as 1")
    if max(albedo) > 1.0:
        albedo = _clipped(albedo)
        model.note(f"material {name!r}: Kd above 1 taken as 1")
    mask = _texture(block.get("map_d"), owner, model, where)
    if mask is not None:
        texture = _masked(texture, mask)
    emission_texture = _texture(block.get("map_ke"), owner, model, where)
    default = (1.0, 1.0, 1.0) if emission_texture is not None else (0.0, 0.0, 0.0)
    _list_the_rest(name, block, model)
    return Material(
        name=name,
        albedo=albedo,
        emission=_color(block, "ke", default, where),
        albedo_texture=texture,
        emission_texture=emission_texture,
        alpha_cutoff=CUTOFF if mask is not None else None,
    )


def _list_the_rest(name: str, block: dict[str, list[str]], model: Model) -> None:
    """List what the material asks for beyond diffuse reflection."""
    if any(_number(word) > 0.0 for word in block.get("ks", [])):
        model.asks_for("specular reflection", name)
    if any(key in block for key in _NORMAL_MAPS):
        model.asks_for("normal maps", name)
    opacity = [_number(word) for word in block.get("d", [])[-1:]]
    opacity += [1.0 - _number(word) for word in block.get("tr", [])[-1:]]
    if any(value < 1.0 for value in opacity):
        model.asks_for("transparency, drawn opaque", name)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return 0.0


def _color(block: dict[str, list[str]], key: str, default: Color, where: str) -> Color:
    if key not in block:
        return default
    words = block[key]
    try:
        numbers = [float(word) for word in words[:3]]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        numbers *= 3
    if len(numbers) != 3 or not all(0.0 <= n < np.inf for n in numbers):
        shown = " ".join([key.capitalize(), *words])
        raise SceneError(f"{where}: {shown!r}: expected three finite numbers >= 0")
    return numbers[0], numbers[1], numbers[2]


def _clipped(color: Color) -> Color:
    r, g, b = (min(value, 1.0) for value in color)
    return r, g, b


def _texture(words: list[str] | None, owner: Path, model: Model, where: str) -> Texture | None:
    """Return the image of a texture statement, skipping its options."""
    if not words:
        return None
    rest = list(words)
    wrap_clamp = False
    while len(rest) > 1 and rest[0].startswith("-"):
        option = rest.pop(0).lower()
        if option == "-clamp":
            wrap_clamp = rest[0].lower() == "on"
        count = _OPTION_ARGUMENTS.get(option, 1)
        while count > 0 and len(rest) > 1 and (count == 1 or _is_number(rest[0])):
            rest.pop(0)
            count -= 1
    name = " ".join(rest)
    try:
        path = contained_file(owner, name, f"{where}: texture")
    except SceneError as error:
        model.note(f"texture not used: {error}")
        return None
    return read_texture(path, where, wrap="clamp" if wrap_clamp else "repeat")


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _masked(texture: Texture | None, mask: Texture) -> Texture:
    """Return the texture (or white) with the mask's brightness as alpha."""
    height, width = (texture or mask).pixels.shape[:2]
    rgba = Image.fromarray(np.asarray(mask.pixels)).resize((width, height))
    has_alpha = bool(np.any(mask.pixels[..., 3] < 255))
    alpha = np.asarray(rgba.getchannel("A") if has_alpha else rgba.convert("RGB").convert("L"))
    pixels = np.full((height, width, 4), 255, dtype=np.uint8)
    if texture is not None:
        pixels[..., :3] = texture.pixels[..., :3]
    pixels[..., 3] = alpha
    base = texture or mask
    return dataclasses.replace(base, pixels=pixels)
