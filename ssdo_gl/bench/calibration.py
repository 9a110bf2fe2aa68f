"""Short measurements on the user's own machine and scene, remembered between runs."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssdo_gl.bench.files import cache_folder, replace_json
from ssdo_gl.bench.fingerprint import fingerprint
from ssdo_gl.bench.machine import machine_class
from ssdo_gl.bench.renderings import RendererStudio
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.planning.content import analyse
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


@dataclass
class Calibration:
    """What is remembered between runs, by key; one small JSON file."""

    folder: Path = field(default_factory=lambda: cache_folder("calibration"))

    def load(self, key: str) -> dict[str, Any]:
        """Return what is known under `key`; nothing if that cannot be read."""
        try:
            content = json.loads((self.folder / f"{key}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return content if isinstance(content, dict) else {}

    def save(self, key: str, content: Mapping[str, Any]) -> None:
        """Remember `content` under `key`."""
        replace_json(self.folder / f"{key}.json", content)


def scene_class(scene: Scene, settings: Settings) -> str:
    """Return what a calibrated time depends on besides the machine and the rung.

    Scenes of one class have the same kinds of content, the same passes, size and
    shadows, as many lights, and the same number of triangles and radius to a factor of
    two. The first frame of a chosen setting is checked anyway.
    """
    content = dataclasses.asdict(analyse(scene))
    triangles = content.pop("triangle_count")
    low, high = scene.bounds()
    extent = float(((high - low) ** 2).sum()) ** 0.5
    radius = settings.radius or scene.default_radius()
    relative = radius / extent if extent > 0.0 and math.isfinite(radius) else 0.0
    octaves = [round(math.log2(v)) if v > 0.0 else -99 for v in (float(triangles), relative)]
    names = ("method", "size", "shadows", "combine", "effects", "overrides", "shadow_rays")
    relevant = {name: getattr(settings, name) for name in names}
    return fingerprint(content, octaves, len(scene.lights), relevant)


class Opened:
    """A studio for one calibration; closes what it opened."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        camera: Camera | None,
        backend: str,
        device: Device | None,
    ) -> None:
        self._own = None if device is not None else create_context(backend)
        used = device or self._own
        assert used is not None
        if camera is not None:
            scene = dataclasses.replace(scene, camera=camera)
        # What is asked of the choice is not what the references should stop at.
        wished = dataclasses.replace(settings, max_error=None)
        self._renderer = Renderer(scene, wished, device=used)
        self.settings = self._renderer.settings
        self.studio = RendererStudio(self._renderer)
        self.machine = machine_class(used)
        self.camera_key = fingerprint(scene.camera)

    def __enter__(self) -> Opened:
        return self

    def __exit__(self, *error: object) -> None:
        self._renderer.release()
        if self._own is not None:
            self._own.release()
