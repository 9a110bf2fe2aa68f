"""A renderer without OpenGL: images with a known error, times with a known cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ssdo_gl.bench.measure.bench_renderer import Images, MedianTimes
from ssdo_gl.bench.measure.fingerprints import fingerprint
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Standard deviation of one ray, or of one depth read.
RAY_NOISE, READ_NOISE = 0.3, 0.4
# What screen space misses, and what a single point per direction misses on top.
SCREEN_LOSS, POINT_LOSS = 0.06, 0.1
# What the near field misses of full transport.
MODEL_LOSS = 0.2
CHANNELS = {"beauty": 4, "depth": 1, "visibility": 1}


class Interrupted(Exception):
    """The user pressed Ctrl-C."""


def triangle_scene() -> Scene:
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    camera = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    return Scene((mesh,), (Material(),), (SceneObject(0, 0),), camera, title="fake")


def reference_image(size: tuple[int, int], name: str) -> np.ndarray:
    """Return the fake reference: a ramp; the left column is background."""
    width, height = size
    ramp = 0.2 + 0.6 * np.linspace(0, 1, width)
    image = np.broadcast_to(ramp[None, :, None], (height, width, CHANNELS.get(name, 3))).copy()
    if name == "depth":
        image[:] = 3.0
    if name == "emission":
        image[:] = 0.0
        image[: height // 8] = 5.0
    image[:, 0] = 0.0
    return image


class MeasuresEach:
    """What a bench's renderer does with many items."""

    def each(
        self,
        measure: Callable[[Any, Any], Any],
        items: Sequence[Any],
        *,
        chunk: int | None = None,
    ) -> Generator[Any, None, None]:
        for item in items:
            yield measure(self, item)


class FakeRenderer(MeasuresEach):
    """Renders by formula and counts calls; raises `Interrupted` after some if told to."""

    def __init__(self, interrupt_after: int | None = None, speed: float = 1.0) -> None:
        self.scene = triangle_scene()
        self.device_name = "fake"
        self.calls: list[tuple[str, Settings]] = []
        self.interrupt_after = interrupt_after
        self.speed = speed
        self.split_clocks: set[str] = set()
        self.others: list[Scene] = []

    @contextmanager
    def of_scene(self, scene: Scene) -> Iterator[FakeRenderer]:
        self.others.append(scene)
        yield FakeRenderer()

    def _count(self, kind: str, settings: Settings) -> None:
        if self.interrupt_after is not None and len(self.calls) >= self.interrupt_after:
            raise Interrupted
        self.calls.append((kind, settings))

    def count(self, kind: str) -> int:
        return sum(name == kind for name, _ in self.calls)

    def images(self, settings: Settings, wanted: Sequence[str]) -> Images:
        self._count("images", settings)
        digest = fingerprint(settings.method, settings.seed, settings.samples, settings.filter)
        rng = np.random.default_rng(int(digest[:8], 16))
        if settings.is_reference:
            offset, noise = 0.0, RAY_NOISE / math.sqrt(settings.spp)
            offset = MODEL_LOSS if settings.method == "reference-gi" else 0.0
        else:
            is_point = settings.chosen_estimator in ("rgs09", "hemisphere", "zbuffer")
            offset = SCREEN_LOSS + POINT_LOSS * is_point
            noise = READ_NOISE / math.sqrt(settings.samples)
            noise *= 0.2 if settings.filter != "none" else 1.0
        result = {}
        for name in wanted:
            image = reference_image(settings.size, name)
            if name not in ("depth", "emission"):
                image = image + offset + noise * rng.standard_normal(image.shape)
            result[name] = image.astype(np.float32)
        return result

    def cost_ms(self, settings: Settings) -> float:
        scale = settings.resolution_scale**2
        pixels = settings.size[0] * settings.size[1] / 1e4
        return self.speed * pixels * (1.0 + 0.1 * settings.samples * scale)

    def timed(self, settings: Settings, wanted: Sequence[str], frames: int) -> MedianTimes:
        self._count("timed", settings)
        cost = self.cost_ms(settings)
        return MedianTimes(cost, 2.0 * cost, math.nan, cost + 100.0)

    def split(
        self, settings: Settings, wanted: Sequence[str], frames: int, clock: str
    ) -> tuple[tuple[str, float], ...]:
        self._count("split", settings)
        self.split_clocks.add(clock)
        return (("gbuffer", 0.5), ("bounce", self.cost_ms(settings) - 0.5), ("composite", 0.1))
