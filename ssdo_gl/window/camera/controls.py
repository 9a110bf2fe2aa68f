"""What keys, mouse and gamepad ask of the camera. Plain data."""

from __future__ import annotations

from dataclasses import dataclass

from ssdo_gl.math3d import Vector


@dataclass(frozen=True)
class Controls:
    """What the user asks for during one step.

    Attributes
    ----------
    move : Vector
        Held directions (right, up, forward), each -1 to 1; up is the scene's.
    turn : (float, float)
        Radians to the left and upwards since the last step (mouse).
    turn_rate : (float, float)
        Radians per second to the left and upwards (arrow keys, stick).
    orbit : (float, float)
        As `turn`, but around the pivot.
    slide : (float, float)
        How far the pivot shall move to the right and upwards in the picture since the last
        step, in heights of it.
    dolly : float
        Notches towards the pivot since the last step.
    speed : float
        Notches of more speed since the last step.
    """

    move: Vector = (0.0, 0.0, 0.0)
    turn: tuple[float, float] = (0.0, 0.0)
    turn_rate: tuple[float, float] = (0.0, 0.0)
    orbit: tuple[float, float] = (0.0, 0.0)
    slide: tuple[float, float] = (0.0, 0.0)
    dolly: float = 0.0
    speed: float = 0.0
    fast: bool = False

    @property
    def is_idle(self) -> bool:
        """Whether nothing is asked for that moves the camera."""
        ways = (*self.move, *self.turn, *self.turn_rate, *self.orbit, *self.slide)
        return self.dolly == 0.0 and not any(ways)
