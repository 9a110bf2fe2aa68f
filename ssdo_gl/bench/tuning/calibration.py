"""Short measurements on the user's own machine and scene, remembered between runs."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from ssdo_gl.bench.measure import BenchRenderer
from ssdo_gl.bench.storage import (
    BenchError,
    read_json,
    replace_json,
    say_not_kept,
    usual_folder,
)
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# What is said to be measured again next time, where the cache cannot be written.
_WHAT = "measured errors"


@dataclass
class Calibration:
    """What is remembered between runs, by key; one small JSON file.

    Attributes
    ----------
    folder : Path or None
        None where it cannot be written, which is said once: nothing is remembered.
    """

    folder: Path | None = field(default_factory=partial(usual_folder, "calibration", _WHAT))

    def load(self, key: str) -> dict[str, Any]:
        """Return what is known under `key`; nothing if that cannot be read."""
        content = None if self.folder is None else read_json(self.folder / f"{key}.json")
        return content if isinstance(content, dict) else {}

    def save(self, key: str, content: Mapping[str, Any]) -> None:
        """Remember `content` under `key`."""
        if self.folder is None:
            return
        try:
            replace_json(self.folder / f"{key}.json", content)
        except BenchError as error:
            say_not_kept(_WHAT, error)
            self.folder = None


@dataclass(frozen=True)
class Calibrated:
    """Numbers that were measured in one sitting: by what name, and when.

    Attributes
    ----------
    values : dict of str to float
        Errors by a rung's label; positive.
    """

    values: dict[str, float]
    date: str

    @staticmethod
    def now(values: Mapping[str, float]) -> Calibrated:
        """Return what has been measured just now."""
        return Calibrated(dict(values), time.strftime("%Y-%m-%d %H:%M"))

    @staticmethod
    def read(content: Mapping[str, Any]) -> Calibrated | None:
        """Return what `Calibration.load` found; None for anything but whole measurements."""
        values, date = content.get("values"), content.get("date")
        numbers = list(values.values()) if isinstance(values, dict) else []
        if not numbers or not all(_is_number(n) and n > 0.0 for n in numbers):
            return None
        return Calibrated(dict(content["values"]), date) if isinstance(date, str) else None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value) and not isinstance(value, bool)


@contextmanager
def opened(
    scene: Scene, settings: Settings, camera: Camera | None, backend: str, device: Device | None
) -> Iterator[tuple[BenchRenderer, Settings]]:
    """Yield a renderer for one calibration and its settings; close what was opened for it."""
    used = device or create_context(backend)
    if camera is not None:
        scene = dataclasses.replace(scene, camera=camera)
    # What is asked of the choice is not what the references should stop at.
    unbounded = dataclasses.replace(settings, max_error=None)
    try:
        with Renderer(scene, unbounded, device=used) as renderer:
            yield BenchRenderer(renderer), renderer.settings
    finally:
        if device is None:
            used.release()
