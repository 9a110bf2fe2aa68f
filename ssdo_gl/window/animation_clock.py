"""The time of an animated scene: runs, stops, steps. Pure."""

from __future__ import annotations

from dataclasses import dataclass

# One step of a stopped animation: a frame of film, nearly.
STEP_SECONDS = 1.0 / 30.0
# How far the time line goes until somebody sets another length.
LENGTH_SECONDS = 10.0


@dataclass
class Clock:
    """Seconds since the scene was at rest.

    Attributes
    ----------
    is_running : bool
        Only where something moves at all, so that a still scene can come to rest.
    length_s : float
        How far the time line goes, > 0.
    loops : bool
        Whether it begins again at its end.
    """

    has_motion: bool
    seconds: float = 0.0
    is_running: bool = False
    length_s: float = LENGTH_SECONDS
    loops: bool = False

    @staticmethod
    def of(has_motion: bool) -> Clock:
        """Return a clock that runs if there is anything to see."""
        return Clock(has_motion, is_running=has_motion)

    def advance(self, seconds: float) -> None:
        """Let time pass, if it runs."""
        if self.is_running:
            self.seconds += seconds
            if self.loops and self.seconds > self.length_s:
                self.seconds %= self.length_s

    def scrub(self, seconds: float) -> None:
        """Stop, and go to a time."""
        self.is_running = False
        self.seconds = seconds

    def toggle(self) -> None:
        """Stop, or go on."""
        self.is_running = self.has_motion and not self.is_running

    def step(self) -> None:
        """Stop and go one step on."""
        self.is_running = False
        if self.has_motion:
            self.seconds += STEP_SECONDS
