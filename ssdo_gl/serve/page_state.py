"""What a page shows around the picture, and what its panel may choose."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from ssdo_gl.effects.registry import image_names
from ssdo_gl.serve.page_events import PageEventError
from ssdo_gl.serve.remote_host import PERMITTED
from ssdo_gl.settings.settings import MAX_EXPOSURE_EV
from ssdo_gl.window.input import BINDINGS, help_groups
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import METHOD_LABELS

# What the page does of these by itself.
PAGE_KEYS = (
    ("Tab", "show or hide the panel"),
    ("H, F1", "show or hide the list of keys"),
    ("F11", "fill the screen, or back"),
    ("F12", "save the picture"),
)


def choices(viewer: Viewer) -> dict[str, Any]:
    """Return what does not change while a page is open: names to choose from, and keys."""
    refused = {item.command.value for item in BINDINGS if item.command not in PERMITTED}
    groups = {
        title: [row for row in rows if row[1] not in refused]
        for title, rows in help_groups().items()
    }
    return {
        "title": viewer.scene.title,
        "methods": dict(METHOD_LABELS),
        "aovs": list(image_names()),
        "presets": list(viewer.presets),
        "help": {**{title: rows for title, rows in groups.items() if rows}, "Page": PAGE_KEYS},
    }


def shown_state(viewer: Viewer) -> dict[str, Any]:
    """Return what is shown at present, for the panel and the lines over the picture.

    In the plain types of JSON: what writes them for marimo takes no others, not even those
    that say of themselves that nobody has chosen them.
    """
    view, left, settings = viewer.view, viewer.left, viewer.settings
    exposure = viewer.scene.camera.exposure if settings.exposure is None else settings.exposure
    monitor = viewer.monitor
    counts = [
        (side.image.sample_count, int(side.image.samples_wanted))
        for side in (left, viewer.right)
        if side is not None
    ]
    is_known = left is not None and left.image.drawing is not None
    return {
        "method": str(view.method),
        "other_method": str(view.other_method),
        "aov": str(view.aov),
        "split": view.is_split,
        "error": view.is_error,
        "divider": view.divider,
        "governed": viewer.is_governed,
        "exposure": round(exposure, 3),
        "resting": viewer.is_resting and not viewer.is_busy,
        "frame_ms": round(viewer.frame_ms, 1) if is_known else None,
        "samples": counts,
        "scale": left.level.frame_scale if left is not None and not viewer.is_resting else 1.0,
        "relative_error": monitor.error if view.is_error else None,
        "fault": None if monitor.alarm is None else str(monitor.alarm),
        "messages": [{"text": m.text, "is_fault": m.is_fault} for m in viewer.messages.lines],
    }


def _replaced(viewer: Viewer, **changes: Any) -> None:
    viewer.view = dataclasses.replace(viewer.view, **changes)


def _name(value: object, known: Mapping[str, Any] | tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in known:
        raise PageEventError(f"choose: {str(value)[:64]!r} is none of {', '.join(known)}")
    return value


def flag(value: object) -> bool:
    """Return `value` if it is true or false; raises PageEventError."""
    if not isinstance(value, bool):
        raise PageEventError("choose: expected true or false")
    return value


def _number(value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise PageEventError(f"choose: expected a number from {low:g} to {high:g}")
    return float(value)


def _expose(viewer: Viewer, value: object) -> None:
    exposure = _number(value, -MAX_EXPOSURE_EV, MAX_EXPOSURE_EV)
    viewer.settings = dataclasses.replace(viewer.settings, exposure=exposure)


def _govern(viewer: Viewer, value: object) -> None:
    viewer.is_governed = flag(value)
    viewer.touch()


_CHOICES: Mapping[str, Callable[[Viewer, object], None]] = {
    "method": lambda viewer, value: viewer.choose_method(_name(value, METHOD_LABELS)),
    "other_method": lambda viewer, value: _replaced(
        viewer, other_method=_name(value, METHOD_LABELS)
    ),
    "aov": lambda viewer, value: _replaced(viewer, aov=_name(value, image_names())),
    "preset": lambda viewer, value: viewer.choose_preset(_name(value, viewer.presets)),
    "split": lambda viewer, value: _replaced(viewer, is_split=flag(value), is_error=False),
    "error": lambda viewer, value: _replaced(viewer, is_error=flag(value), is_split=False),
    "exposure": _expose,
    "governed": _govern,
}


def choose(viewer: Viewer, what: str, value: object) -> None:
    """Take over what a panel has chosen.

    Raises
    ------
    PageEventError
        If there is no such choice; the viewer then stays as it is.
    SettingError
        If a preset does not go with what is shown.
    """
    if what not in _CHOICES:
        raise PageEventError(f"choose: what is one of {', '.join(_CHOICES)}")
    _CHOICES[what](viewer, value)
