"""What a page may say: every event with its fields and ranges, checked before anything hears it.

Coordinates are the page's (CSS pixels), origin at the top left of the picture.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

# A page as large as an 8K display, and as many pixels as a 4K display has.
MAX_SIDE_PX = 8192
MAX_PIXELS = 3840 * 2160
# Far beyond any display; what is dragged out of a page stays within.
_FAR_PX = 1e5
_TEXT_LENGTH = 64


class PageEventError(ValueError):
    """What came is no event of a page."""


@dataclass(frozen=True)
class _Number:
    low: float
    high: float
    whole: bool = False

    def check(self, value: object) -> bool:
        kinds = (int,) if self.whole else (int, float)
        is_number = isinstance(value, kinds) and not isinstance(value, bool)
        # Big integers first: they do not fit a float.
        return is_number and self.low <= value <= self.high and math.isfinite(value)  # type: ignore[operator, arg-type]


@dataclass(frozen=True)
class _OneOf:
    types: tuple[type, ...]

    def check(self, value: object) -> bool:
        is_short = not isinstance(value, str) or len(value) <= _TEXT_LENGTH
        return isinstance(value, self.types) and is_short


_TEXT, _FLAG = _OneOf((str,)), _OneOf((bool,))
_PLACE = _Number(-_FAR_PX, _FAR_PX)
_SIDE = _Number(1, MAX_SIDE_PX)
# Every event with its fields; none may be missing, no other may be there.
EVENTS: Mapping[str, Mapping[str, _Number | _OneOf]] = {
    "key": {"code": _TEXT, "down": _FLAG, "repeat": _FLAG, "mods": _Number(0, 15, whole=True)},
    "button": {"button": _Number(0, 2, whole=True), "down": _FLAG, "x": _PLACE, "y": _PLACE},
    "cursor": {"x": _PLACE, "y": _PLACE},
    "wheel": {"notches": _Number(-100.0, 100.0)},
    "focus": {"has": _FLAG},
    "size": {"width": _SIDE, "height": _SIDE, "scale": _Number(0.1, 8.0)},
    "ack": {"frame": _Number(0, 2**31, whole=True)},
    "choose": {"what": _TEXT, "value": _OneOf((str, bool, int, float))},
}


def checked_event(event: object) -> Mapping[str, Any]:
    """Return `event` if it is one of `EVENTS`; raises PageEventError."""
    if not isinstance(event, dict):
        raise PageEventError("an event is an object")
    kind = event.get("type")
    fields = EVENTS.get(kind) if isinstance(kind, str) else None
    if fields is None:
        raise PageEventError(f"no event is called {str(kind)[:_TEXT_LENGTH]!r}")
    if event.keys() - {"type"} != fields.keys():
        raise PageEventError(f"{kind}: its fields are {', '.join(fields)}")
    for name, field in fields.items():
        if not field.check(event[name]):
            raise PageEventError(f"{kind}: {name} is out of range")
    if kind == "size":
        width, height = pixels_of(event)
        if width * height > MAX_PIXELS or max(width, height) > MAX_SIDE_PX:
            raise PageEventError(f"size: {width} x {height} pixels are more than {MAX_PIXELS}")
    return event


def pixels_of(event: Mapping[str, Any]) -> tuple[int, int]:
    """Return the device's pixels of an event of size."""
    scale = event["scale"]
    return max(1, round(event["width"] * scale)), max(1, round(event["height"] * scale))


def read_event(text: str) -> Mapping[str, Any]:
    """Return the event that a message holds; raises PageEventError."""
    try:
        event = json.loads(text)
    # RecursionError: brackets by the thousand.
    except (ValueError, RecursionError):
        raise PageEventError("a message is JSON") from None
    return checked_event(event)
