"""What was edited in a window, step by step, for a way back and forth. Pure."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

MOST_STEPS = 200
# Steps of the camera alone that follow one another sooner are one: a walk is many keys.
ONE_WALK_SECONDS = 2.0


@dataclass(frozen=True)
class Edited:
    """All that can be edited, as it is at one time.

    Attributes
    ----------
    original : Scene
        Which lights there are, before they were edited, the materials and the environment.
    camera : Camera
        At rest.
    """

    settings: Settings
    lights: tuple[Light, ...]
    lights_on: tuple[bool, ...]
    original: Scene
    camera: Camera

    def difference(self, other: Edited) -> str:
        """Return what differs, in words; empty if nothing does."""
        lights = (self.lights, self.lights_on) != (other.lights, other.lights_on)
        # Those of lights that were added come last.
        materials = zip(self.original.materials, other.original.materials, strict=False)
        parts = {
            "lights": lights or self.original.lights is not other.original.lights,
            "materials": any(one is not another for one, another in materials),
            "environment": self.original.environment != other.original.environment,
            "settings": self.settings != other.settings,
            "camera": self.camera != other.camera,
        }
        return ", ".join(name for name, differs in parts.items() if differs)


class History:
    """The steps from the beginning to now, and those that were undone.

    Parameters
    ----------
    clock : callable
        Returns seconds that only ever grow.
    """

    def __init__(self, start: Edited, clock: Callable[[], float] = time.monotonic) -> None:
        self.start = start
        self._clock = clock
        self._now = start
        self._undone: list[Edited] = []
        self._done: list[Edited] = []
        self._walked_at: float | None = None

    @property
    def can_undo(self) -> bool:
        """Whether there is a step back."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Whether there is a step that was undone."""
        return bool(self._undone)

    def note(self, now: Edited) -> None:
        """Take what is edited now, once nothing is dragged and nothing moves."""
        what = now.difference(self._now)
        if not what:
            return
        is_walk, seconds = what == "camera", self._clock()
        goes_on = self._walked_at is not None and seconds - self._walked_at < ONE_WALK_SECONDS
        if not (is_walk and goes_on and self._done):
            self._done = [*self._done, self._now][-MOST_STEPS:]
        self._walked_at = seconds if is_walk else None
        self._now = now
        self._undone.clear()

    def undo(self) -> Edited | None:
        """Return what was before the last step, if there is one."""
        return self._go(self._done, self._undone)

    def redo(self) -> Edited | None:
        """Return what was after the step undone last, if there is one."""
        return self._go(self._undone, self._done)

    def _go(self, source: list[Edited], other: list[Edited]) -> Edited | None:
        if not source:
            return None
        other.append(self._now)
        self._now = source.pop()
        self._walked_at = None
        return self._now

    def arrive(self, now: Edited) -> None:
        """Note how what was gone to has come out: a camera only to rounding."""
        self._now = now
