"""How the camera flies: state and controls in, state and camera out. Pure.

Every smoothed quantity relaxes exponentially and is integrated in closed form, so
that the path does not depend on how often frames are drawn: half the frame rate
means steps twice as long, not another flight.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from ssdo_gl.math3d import Vector, add, difference, dot, vector
from ssdo_gl.scene.camera import Camera
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.camera.orientation import Axes, axes_of

_ZERO: Vector = (0.0, 0.0, 0.0)

# Scene diagonals travelled per second at the speed a flight starts with: a room is
# crossed in about four seconds, the pace at which one still sees what passes by.
DIAGONALS_PER_SECOND = 0.2
FAST_FACTOR = 4.0
# One notch of the wheel; six of them double the speed.
SPEED_STEP = 2.0 ** (1.0 / 6.0)
SPEED_LIMITS = (1e-4, 1e4)
# One notch of the wheel while orbiting, in natural-log units of the distance.
DOLLY_STEP = 0.15
# How near and how far the wheel goes, in scene diagonals: beyond, the scene is less than
# a pixel, or a pixel less than float32 tells apart.
DOLLY_LIMITS = (1e-6, 1e3)
# Where the nearest surface is closer than this many diagonals, speed shrinks with the
# distance, down to `SLOWEST`: a step at a wall is small, a step under the sky is not.
OPEN_SPACE = 0.15
SLOWEST = 0.1
# Time constants in seconds. One notices lag above some 50 ms in looking; motion may
# coast a little longer (half as long makes no key seen sooner, `make bench-input`); a glide to
# a point shall be watched.
LOOK_SECONDS = 0.025
MOVE_SECONDS = 0.08
GLIDE_SECONDS = 0.18
# A step longer than this is split: between two parts the orientation is held at its mean,
# whose error shrinks with the square of the length.
LONGEST_STEP_SECONDS = 1.0 / 120.0
# A stall (a dragged window, a suspended laptop) must not throw the camera out.
LONGEST_PAUSE_SECONDS = 0.25
# Straight up is kept out by a tenth of a degree: there, "up" stops saying which way
# is right, and the camera could not be written as position, target and up.
PITCH_LIMIT = math.radians(89.9)
# Below these a picture does not change any more, and the flight counts as at rest:
# a thirtieth of a pixel of a 4K picture; a millionth of the scene per second.
REST_ANGLE = 1e-5
REST_SPEED = 1e-6


@dataclass(frozen=True)
class Flight:
    """The state of a flight; lengths in scene units, angles in radians, world space.

    Attributes
    ----------
    yaw, pitch : float
        Where the camera looks now.
    yaw_goal, pitch_goal : float
        Where it will look once it has settled.
    glide : Vector
        What is left of the way to a point it was sent to.
    dolly : float
        Natural log of the ratio by which the distance to the pivot has yet to shrink.
    pivot : Vector or None
        Stays at its place in the picture while `orbiting`.
    speed_factor : float
        What the wheel has made of the speed.
    reach : float
        Distance of the point that the camera calls its target.
    fov_y : float
        Degrees.
    height : float or None
        Of what parallel rays show, scene units; None: a pinhole camera.
    home : Camera
        Where the flight began; yaw 0 is where it looks.
    diagonal : float
        Of the scene's bounds.
    """

    axes: Axes
    position: Vector
    yaw: float
    pitch: float
    yaw_goal: float
    pitch_goal: float
    reach: float
    fov_y: float
    height: float | None
    home: Camera
    home_pitch: float
    diagonal: float
    velocity: Vector = _ZERO
    glide: Vector = _ZERO
    dolly: float = 0.0
    pivot: Vector | None = None
    orbiting: bool = False
    speed_factor: float = 1.0

    @property
    def is_moving(self) -> bool:
        """Whether the camera would go on moving without any input."""
        return bool(
            any(self.velocity)
            or any(self.glide)
            or self.dolly
            or self.yaw != self.yaw_goal
            or self.pitch != self.pitch_goal
        )

    @property
    def forward(self) -> Vector:
        """The unit viewing direction."""
        return self.axes.forward(self.yaw, self.pitch)

    def camera(self) -> Camera:
        """Return the camera; exactly the home camera until something has moved."""
        home = (vector(self.home.position), 0.0, self.home_pitch, self.home.fov_y, self.home.height)
        if (self.position, self.yaw, self.pitch, self.fov_y, self.height) == home:
            return self.home
        up = self.axes.up
        if abs(self.pitch) > PITCH_LIMIT:
            # Only a home that looks straight down gets here; `up` must then tell yaw.
            up = self.axes.forward(self.yaw, self.pitch + 0.5 * math.pi)
        return dataclasses.replace(
            self.home,
            position=self.position,
            target=add(self.position, self.forward, self.reach),
            up=up,
            fov_y=self.fov_y,
            height=self.height,
        )


def start_flight(home: Camera, diagonal: float) -> Flight:
    """Return a flight at rest at `home`.

    Parameters
    ----------
    diagonal : float
        Of the scene's bounds, scene units, > 0; sets the speed.
    """
    axes, pitch = axes_of(home)
    return Flight(
        axes=axes,
        position=vector(home.position),
        yaw=0.0,
        pitch=pitch,
        yaw_goal=0.0,
        pitch_goal=pitch,
        reach=math.dist(home.position, home.target),
        fov_y=home.fov_y,
        height=home.height,
        home=home,
        home_pitch=pitch,
        diagonal=diagonal,
    )


def advance(
    flight: Flight, controls: Controls, seconds: float, clearance: float | None = None
) -> Flight:
    """Return the flight after `seconds` of `controls`.

    Parameters
    ----------
    controls : Controls
        Held directions and rates last for the whole step; amounts since the last step
        are taken in at its beginning.
    seconds : float
        What is longer than `LONGEST_PAUSE_SECONDS` is a pause, not a flight.
    clearance : float or None
        Distance of the nearest surface in view, scene units; None: nothing is near.
    """
    seconds = min(max(seconds, 0.0), LONGEST_PAUSE_SECONDS)
    flight = _take_in(flight, controls)
    speed = speed_of(flight, controls.fast, clearance)
    count = max(1, math.ceil(seconds / LONGEST_STEP_SECONDS))
    for _ in range(count):
        flight = _step(flight, controls, speed, seconds / count)
    return _settled(flight, controls)


def speed_of(flight: Flight, fast: bool = False, clearance: float | None = None) -> float:
    """Return the speed that a held key leads to, scene units per second."""
    nearness = 1.0
    if clearance is not None:
        nearness = min(1.0, max(SLOWEST, clearance / (OPEN_SPACE * flight.diagonal)))
    base = flight.diagonal * DIAGONALS_PER_SECOND * flight.speed_factor
    return base * nearness * (FAST_FACTOR if fast else 1.0)


def set_pivot(flight: Flight, point: Vector | None) -> Flight:
    """Return a flight that orbits around `point` from now on.

    None, where the cursor met nothing: the middle of the picture at the target's distance.
    """
    if point is None:
        point = add(flight.position, flight.forward, flight.reach)
    return dataclasses.replace(flight, pivot=point)


def _slid(flight: Flight, way: tuple[float, float]) -> Flight:
    """Return a flight that stands beside, so that the pivot moves by `way` in the picture."""
    assert flight.pivot is not None
    right, up, forward = flight.axes.frame(flight.yaw, flight.pitch)
    depth = abs(dot(forward, difference(flight.pivot, flight.position)))
    height = flight.height or 2.0 * math.tan(math.radians(0.5 * flight.fov_y)) * depth
    position = add(add(flight.position, right, -height * way[0]), up, -height * way[1])
    return dataclasses.replace(flight, position=position, glide=_ZERO)


def _take_in(flight: Flight, controls: Controls) -> Flight:
    """Add what happened since the last step to the goals."""
    low, high = SPEED_LIMITS
    # Logarithms, because a free-spinning wheel must not overflow.
    factor = math.log(flight.speed_factor) + controls.speed * math.log(SPEED_STEP)
    factor = math.exp(min(math.log(high), max(math.log(low), factor)))
    changes: dict[str, Any] = {}
    if controls.speed:
        changes["speed_factor"] = min(high, max(low, factor))
    if any(controls.move):
        changes["glide"] = _ZERO
    pivoted = any(controls.orbit) or controls.dolly != 0.0
    if (pivoted or any(controls.slide)) and flight.pivot is None:
        flight = set_pivot(flight, None)
    if any(controls.slide):
        flight = _slid(flight, controls.slide)
    if pivoted:
        changes["orbiting"] = True
        changes["glide"] = _ZERO
    elif any(controls.turn) or any(controls.turn_rate):
        changes["orbiting"] = False
        changes["dolly"] = 0.0
    yaw = flight.yaw_goal + controls.turn[0] + controls.orbit[0]
    pitch = flight.pitch_goal + controls.turn[1] + controls.orbit[1]
    changes["yaw_goal"] = yaw
    changes["pitch_goal"] = limited_pitch(pitch, flight.pitch_goal)
    flight = dataclasses.replace(flight, **changes)
    if not pivoted or flight.pivot is None or flight.pivot == flight.position:
        return flight
    distance = (flight.height or math.dist(flight.pivot, flight.position)) / flight.diagonal
    nearest, farthest = (math.log(distance / limit) for limit in DOLLY_LIMITS)
    # Who is beyond a limit already may come back, and goes no further.
    dolly = max(min(farthest, 0.0), flight.dolly + DOLLY_STEP * controls.dolly)
    return dataclasses.replace(flight, dolly=min(max(nearest, 0.0), dolly))


def _step(flight: Flight, controls: Controls, speed: float, seconds: float) -> Flight:
    """Integrate one short step in closed form, orientation held at its value half-way."""
    yaw, yaw_goal = _chase(flight.yaw, flight.yaw_goal, controls.turn_rate[0], seconds)
    pitch, pitch_goal = _chase(flight.pitch, flight.pitch_goal, controls.turn_rate[1], seconds)
    half_yaw, _ = _chase(flight.yaw, flight.yaw_goal, controls.turn_rate[0], 0.5 * seconds)
    half_pitch, _ = _chase(flight.pitch, flight.pitch_goal, controls.turn_rate[1], 0.5 * seconds)
    wanted = _velocity(flight.axes, half_yaw, half_pitch, controls.move, speed)

    keep = math.exp(-seconds / MOVE_SECONDS)
    # The integral of velocity that relaxes from v to w: w t + (v - w) (1 - keep) tau.
    lag = MOVE_SECONDS * (1.0 - keep)
    glided = 1.0 - math.exp(-seconds / GLIDE_SECONDS)
    position, velocity, glide = [], [], []
    for p, v, w, g in zip(flight.position, flight.velocity, wanted, flight.glide, strict=True):
        position.append(p + w * seconds + (v - w) * lag + g * glided)
        velocity.append(w + (v - w) * keep)
        glide.append(g * (1.0 - glided))
    dolly = flight.dolly * glided
    moved = dataclasses.replace(
        flight,
        position=(position[0], position[1], position[2]),
        velocity=(velocity[0], velocity[1], velocity[2]),
        glide=(glide[0], glide[1], glide[2]),
        yaw=yaw,
        yaw_goal=yaw_goal,
        pitch=limited_pitch(pitch, flight.pitch),
        pitch_goal=limited_pitch(pitch_goal, flight.pitch_goal),
        dolly=flight.dolly - dolly,
    )
    # What stands still must not drift by the rounding of a turn about nothing.
    is_turned = flight.orbiting and moved != flight
    return _around_pivot(flight, moved, math.exp(-dolly)) if is_turned else moved


def _around_pivot(before: Flight, after: Flight, ratio: float) -> Flight:
    """Put the pivot back to its place in the picture, `ratio` times as far away.

    Between parallel rays the picture shows `ratio` times as much instead.
    """
    assert before.pivot is not None  # orbiting starts with one
    offset = difference(before.pivot, after.position)
    old = before.axes.frame(before.yaw, before.pitch)
    new = after.axes.frame(after.yaw, after.pitch)
    coordinates = [ratio * dot(axis, offset) for axis in old]
    if before.height is not None:
        coordinates[2] /= ratio
        after = dataclasses.replace(after, height=before.height * ratio)
    turned = [sum(c * axis[i] for c, axis in zip(coordinates, new, strict=True)) for i in range(3)]
    position = difference(before.pivot, (turned[0], turned[1], turned[2]))
    return dataclasses.replace(after, position=position)


def _settled(flight: Flight, controls: Controls) -> Flight:
    """End what has become too small to see, so that the picture can come to rest.

    What is left of a motion is travelled at once: it ends where it would have ended.
    """
    changes: dict[str, Any] = {}
    position = flight.position
    slow = REST_SPEED * flight.diagonal * max(1.0, flight.speed_factor)
    if not any(controls.move) and 0.0 < math.hypot(*flight.velocity) < slow:
        position = add(position, flight.velocity, MOVE_SECONDS)
        changes["velocity"] = _ZERO
    if 0.0 < math.hypot(*flight.glide) < REST_SPEED * flight.diagonal:
        position = add(position, flight.glide)
        changes["glide"] = _ZERO
    if not any(controls.turn_rate):
        if abs(flight.yaw - flight.yaw_goal) < REST_ANGLE:
            changes["yaw"] = flight.yaw_goal
        if abs(flight.pitch - flight.pitch_goal) < REST_ANGLE:
            changes["pitch"] = flight.pitch_goal
    ratio = 1.0
    if abs(flight.dolly) < REST_ANGLE:
        ratio = math.exp(-flight.dolly)
        changes["dolly"] = 0.0
    settled = dataclasses.replace(flight, position=position, **changes)
    if settled == flight or not flight.orbiting:
        return settled
    return _around_pivot(flight, settled, ratio)


def _chase(value: float, goal: float, rate: float, seconds: float) -> tuple[float, float]:
    """Return (value, goal) after `seconds` of a goal that moves at `rate`.

    The solution of value' = (goal - value) / tau: it ends up rate * tau behind.
    """
    behind = rate * LOOK_SECONDS
    moved_goal = goal + rate * seconds
    gap = value - goal + behind
    return moved_goal - behind + gap * math.exp(-seconds / LOOK_SECONDS), moved_goal


def limited_pitch(pitch: float, before: float) -> float:
    """Return `pitch` inside the limit; a start beyond it is kept until left."""
    limit = max(PITCH_LIMIT, abs(before))
    return min(limit, max(-limit, pitch))


def _velocity(axes: Axes, yaw: float, pitch: float, move: Vector, speed: float) -> Vector:
    """Return the world-space velocity that `move` asks for; diagonals are no faster."""
    length = math.hypot(*move)
    if length == 0.0:
        return _ZERO
    scale = speed / max(1.0, length)
    forward, right = axes.forward(yaw, pitch), axes.right(yaw)
    x, y, z = (
        scale * (move[0] * r + move[1] * u + move[2] * f)
        for r, u, f in zip(right, axes.up, forward, strict=True)
    )
    return x, y, z
