"""Texture statements of .mtl files: options, then the name of an image."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.material import Texture, Wrap
from ssdo_gl.scene.numbers import LARGEST_NUMBER, finite
from ssdo_gl.scene.scene_error import SceneError

# Numbers that an option takes at most; of all others one word is skipped.
_NUMBERS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2, "-bm": 1}


@dataclass(frozen=True)
class Placement:
    """Where an image lies: its coordinates are `scale` times those of the file, plus `offset`."""

    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    def placed(self, uvs: FloatArray) -> FloatArray:
        """Return texture coordinates (V, 2), v = 0 at the bottom row, as the image has them."""
        with np.errstate(over="ignore", invalid="ignore"):  # dropped later
            return np.asarray(uvs * self.scale + self.offset)


@dataclass(frozen=True)
class Map:
    """An image, where it lies, and what multiplies the heights it may hold."""

    texture: Texture
    placement: Placement
    bump: float = 1.0


def read_map(
    statement: str | None, found: Callable[[str], Path], model: Model, where: str
) -> Map | None:
    """Return what a texture statement names, or None with a note if it cannot be used.

    Parameters
    ----------
    found : callable
        From the name of a file to its path; raises ValueError.
    """
    if not statement:
        return None
    rest = statement.split()
    clamp = False
    numbers: dict[str, list[float]] = {}
    while len(rest) > 1 and rest[0].startswith("-"):
        option = rest.pop(0).lower()
        values: list[float] = []
        while len(values) < _NUMBERS.get(option, 0) and len(rest) > 1:
            value = finite_number(rest[0])
            if value is None:
                break
            values.append(value)
            rest.pop(0)
        numbers[option] = values
        if option not in _NUMBERS and len(rest) > 1:
            word = rest.pop(0).lower()
            clamp = word == "on" if option == "-clamp" else clamp
    if "-t" in numbers:
        model.note(f"{where}: turbulence of textures (-t) is not drawn")
    try:
        wrap: Wrap = "clamp" if clamp else "repeat"
        texture = model.texture(found(" ".join(rest)), where, wrap=wrap)
    except (SceneError, ValueError) as error:
        model.note(f"texture not used: {error}")
        return None
    low_high = _filled(numbers.get("-mm"), 0.0, 1.0)
    return Map(
        model.derived((texture, *low_high), lambda: _with_range(texture, *low_high)),
        Placement(_filled(numbers.get("-s"), 1.0, 1.0), _filled(numbers.get("-o"), 0.0, 0.0)),
        (numbers.get("-bm") or [1.0])[0],
    )


def finite_number(word: str) -> float | None:
    """Return the number that a word is; None if it is none of usable size."""
    try:
        return finite(float(word), LARGEST_NUMBER)
    except ValueError:
        return None


def _filled(values: list[float] | None, first: float, second: float) -> tuple[float, float]:
    """Return the first two values, missing ones as given."""
    one, other = [*(values or ()), *(first, second)[len(values or ()) :]][:2]
    return one, other


def _with_range(texture: Texture, base: float, gain: float) -> Texture:
    """Return the texture with `base` plus `gain` times its colours, 0 to 1 as stored."""
    if (base, gain) == (0.0, 1.0):
        return texture
    pixels = texture.pixels.copy()
    changed = np.rint(255.0 * base + gain * pixels[..., :3].astype(np.float64))
    pixels[..., :3] = np.clip(changed, 0.0, 255.0)
    return replace(texture, pixels=pixels)


def is_cut_out(texture: Texture, cutoff: float) -> bool:
    """Return whether a colour image has an alpha channel with some of it cut out.

    One that would cut everything out is there for another reason.
    """
    out = texture.pixels[..., 3] < cutoff * 255.0
    return bool(np.any(out)) and not bool(np.all(out))


def masked(colors: Map | None, mask: Map, model: Model) -> Map:
    """Return the colours (or white) with the mask's brightness as alpha, where they lie."""
    key = (None if colors is None else colors.texture, mask.texture)
    base = colors or mask
    return Map(model.derived(key, lambda: _masked(colors, mask)), base.placement)


def _masked(colors: Map | None, mask: Map) -> Texture:
    base = colors or mask
    height, width = base.texture.pixels.shape[:2]
    rgba = Image.fromarray(np.asarray(mask.texture.pixels)).resize((width, height))
    has_alpha = bool(np.any(mask.texture.pixels[..., 3] < 255))
    alpha = np.asarray(rgba.getchannel("A") if has_alpha else rgba.convert("RGB").convert("L"))
    pixels = np.full((height, width, 4), 255, dtype=np.uint8)
    if colors is not None:
        pixels[..., :3] = colors.texture.pixels[..., :3]
    pixels[..., 3] = alpha
    return replace(base.texture, pixels=pixels)
