"""The [render] table: the scene's own wishes, which flags override."""

from __future__ import annotations

import math
from typing import Any

from ssdo_gl.scene.formats.toml.table import Table

_METHODS = (
    "direct",
    "ssao",
    "ssdo",
    "bounce",
    "reference-ao",
    "reference-near",
    "reference-gi",
)
# Texts with their choices; without any, the renderer knows which are valid.
_TEXTS: dict[str, tuple[str, ...]] = {
    "method": _METHODS,
    "estimator": (),
    "shadows": ("map", "traced", "none"),
    "combine": ("ambient", "multiply", "report"),
    "filter": (),
    "effects": ("auto", "full"),
}
_INTEGERS: dict[str, tuple[int, int]] = {
    "samples": (1, 1024),
    "steps": (1, 256),
    "spp": (1, 1 << 20),
    "bounces": (0, 64),
    "shadow_rays": (1, 4096),
    "seed": (0, (1 << 31) - 1),
    "antialias": (1, 256),
}
_POSITIVE = ("radius", "resolution_scale")
NAMES = (*_TEXTS, *_INTEGERS, *_POSITIVE, "size", "exposure")


def read_wishes(table: Table | None) -> dict[str, Any]:
    """Return the wishes by name: the flags' names with underscores for dashes."""
    wishes: dict[str, Any] = {}
    if table is None:
        return wishes
    table.allow(*NAMES)
    for key in table.data:
        if key in _TEXTS:
            wishes[key] = table.text(key, choices=_TEXTS[key])
        elif key in _INTEGERS:
            wishes[key] = table.integer(key, None, *_INTEGERS[key])
        elif key in _POSITIVE:
            wishes[key] = table.number(key, low=0.0, high=math.inf, open_ends=True)
        elif key == "exposure":
            wishes[key] = table.number(key, low=-60.0, high=60.0)
        else:
            width, height = table.numbers(key, 2)
            if not all(side >= 1 and side == int(side) for side in (width, height)):
                table.fail(key, "expected two whole numbers of pixels, [width, height]")
            wishes[key] = (int(width), int(height))
    return wishes
