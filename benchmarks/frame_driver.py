"""Draws frames of one scene as a window does, and says what each took: one side of a comparison.

`main` is a process of its own: its arguments are TREE and JOB. It imports the program of the
checkout TREE, this one or one of another commit, so it asks for no more than what all have.
JOB is JSON: the scene, and fields of `Settings`. On standard input come lines of JSON, ``[CASE,
FIRST, COUNT]``: draw frames FIRST, FIRST + 1, ... of a case. Each is answered by a line: ``ms``,
processor time of all threads, frame by frame; ``none``, why there is no such case; or ``error``,
after which the process ends. The first answer comes once the scene is loaded.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
import math
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Where what is needed lives now, and where it once lived.
RENDERERS = (
    "ssdo_gl.renderer:Renderer",
    "ssdo_gl.window.live.live_renderer:LiveRenderer",
    "ssdo_gl.app.live_renderer:LiveRenderer",
)
SETTINGS_FOR = (
    "ssdo_gl.options.resolve:settings_for",
    "ssdo_gl.settings.resolve:settings_for",
    "ssdo_gl.options:settings_for",
)
# A window's sub-pixel offsets: the one that it moves with, and steps from one to the next at rest.
OFFSETS, CENTRE, STEP = 16, 7, 7
FRAMES_A_SECOND = 30.0
# The camera sways sideways by this part of its distance from what it looks at, by so many
# radians a frame: about two pixels.
CAMERA_SWAY, CAMERA_PHASE = 0.1, 0.04
# Lamps sway by this part of the scene, suns turn by so many degrees a second.
LAMP_SWAY, SUN_DEGREES = 0.05, 10.0


class NoCaseError(Exception):
    """The scene, or the commit, has nothing to draw there."""


def first_of(homes: tuple[str, ...], has: str = "") -> Any:
    """Return the first of several objects, MODULE:NAME, that is there and has an attribute."""
    for home in homes:
        module, _, name = home.partition(":")
        try:
            found = getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError):
            continue
        if not has or hasattr(found, has):
            return found
    raise NoCaseError(f"there is none of {', '.join(homes)}")


class Frames:
    """A scene of a checkout, and what draws it."""

    def __init__(self, source: str, fields: dict[str, Any]) -> None:
        load = first_of(("ssdo_gl.scene.load:load_scene",))
        self._scene = load(source)
        fields = {**fields, "size": tuple(fields["size"])}
        settings = first_of(SETTINGS_FOR)(self._scene.render, fields)
        kind = first_of(RENDERERS, "draw")
        keywords: dict[str, Any] = {}
        if kind.__name__ == "LiveRenderer":
            device = first_of(("ssdo_gl.gpu.context:create_context",))("auto")
            shaders = first_of(("ssdo_gl.gpu.shader:ShaderLibrary",))(device.gl)
            keywords = {"device": device, "shaders": shaders}
        self._renderer = kind(self._scene, settings, **keywords)
        self._cases: dict[str, Callable[[int], Any]] = {
            "still": self._still,
            "camera": self._camera,
            "lamps": self._lamps,
        }
        self._lit: Any = None
        self.is_settled = True

    def draw(self, case: str, first: int, count: int) -> list[float]:
        """Return the processor time of frames, in milliseconds."""
        # The scene that the case before has left is another one.
        if case == "lamps" and self._lit is None:
            self._lit = with_moving_lamps(self._scene)
        self._renderer.use_scene(self._lit if case == "lamps" else self._scene)
        taken = []
        for number in range(first, first + count):
            start = time.process_time()
            drawing = self._cases[case](number)
            taken.append(1e3 * (time.process_time() - start))
            self.is_settled = getattr(drawing, "is_settled", True)
        return taken

    def _still(self, number: int) -> Any:
        index = (CENTRE + STEP * number) % OFFSETS + number // OFFSETS * OFFSETS
        return self._one(self._scene.camera, 0.0, index)

    def _camera(self, number: int) -> Any:
        camera = self._scene.camera
        x, y, z = (b - a for a, b in zip(camera.position, camera.target, strict=True))
        # To the right, in the horizontal plane.
        step = CAMERA_SWAY * math.sin(CAMERA_PHASE * number)
        aside = (-step * z, 0.0, step * x) if x or z else (step * y, 0.0, 0.0)
        places = {
            name: tuple(p + s for p, s in zip(getattr(camera, name), aside, strict=True))
            for name in ("position", "target")
        }
        return self._one(dataclasses.replace(camera, **places), 0.0, CENTRE)

    def _lamps(self, number: int) -> Any:
        return self._one(self._scene.camera, number / FRAMES_A_SECOND, CENTRE)

    def _one(self, camera: Any, seconds: float, index: int) -> Any:
        return self._renderer.draw(
            ["display"], camera=camera, seconds=seconds, index=index, count=OFFSETS
        )


def with_moving_lamps(scene: Any) -> Any:
    """Return a scene whose lamps move: as it has them move, or all of them, where nothing does."""
    if any(item.motion for item in (*scene.objects, *scene.lights)):
        return scene
    if not scene.lights:
        raise NoCaseError("has no lamp")
    motion = first_of(("ssdo_gl.scene.motion:Motion",))
    low, high = scene.bounds()
    extent = max(float(b - a) for a, b in zip(low, high, strict=True))
    sways, turns = (
        motion(sway=(LAMP_SWAY * extent, 0.0, 0.0)),
        motion(orbit=(0.0, SUN_DEGREES, 0.0)),
    )
    suns = "DirectionalLight"
    lights = tuple(
        dataclasses.replace(light, motion=turns if type(light).__name__ == suns else sways)
        for light in scene.lights
    )
    return dataclasses.replace(scene, lights=lights)


def answers(tree: str, job: dict[str, Any], say: Callable[[dict[str, Any]], None]) -> None:
    """Load the scene and answer one line after the other."""
    sys.path.insert(0, tree)
    package = Path(importlib.import_module("ssdo_gl").__file__ or "")
    if Path(tree).resolve() not in package.resolve().parents:
        raise NoCaseError(f"ssdo_gl was imported from {package.parent}")
    frames = Frames(job["scene"], job["settings"])
    say({"ms": []})
    for line in sys.stdin:
        try:
            taken = frames.draw(*json.loads(line))
        except NoCaseError as error:
            say({"none": str(error)})
        else:
            say({"ms": taken, "is_settled": frames.is_settled})


def main() -> None:
    """Answer on what was standard output: libraries may print there, too."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as out:
        os.dup2(2, 1)

        def say(answer: dict[str, Any]) -> None:
            out.write(json.dumps(answer) + "\n")
            out.flush()

        try:
            answers(sys.argv[1], json.loads(sys.argv[2]), say)
        except Exception as error:
            # Which errors are the user's own has changed from commit to commit.
            text = " ".join(str(error).split())
            is_plain = isinstance(error, ValueError | NoCaseError)
            say({"error": text if is_plain and text else f"{type(error).__name__}: {text}"})
