"""Where a flight can be sent to: a point, a view, the whole scene, home. Pure."""

from __future__ import annotations

import dataclasses
import itertools
import math

from ssdo_gl.math3d import FloatArray, Vector, add, difference, dot, vector
from ssdo_gl.scene.camera import Camera
from ssdo_gl.window.camera.fly_camera import REST_SPEED, Flight, limited_pitch, start_flight

_ZERO: Vector = (0.0, 0.0, 0.0)
# What is left around a scene that fits into the view.
FIT_MARGIN = 1.06


def focus_on(flight: Flight, point: Vector) -> Flight:
    """Return a flight that turns to `point` and glides half the way to it."""
    offset = difference(point, flight.position)
    distance = math.hypot(*offset)
    if distance < REST_SPEED * flight.diagonal:
        return flight
    yaw, pitch = flight.axes.angles(offset, flight.yaw_goal)
    glide = (0.5 * offset[0], 0.5 * offset[1], 0.5 * offset[2])
    return dataclasses.replace(
        flight,
        glide=glide,
        yaw_goal=yaw,
        pitch_goal=limited_pitch(pitch, flight.pitch_goal),
        pivot=point,
        orbiting=False,
        dolly=0.0,
        reach=0.5 * distance,
    )


def glide_to(flight: Flight, camera: Camera) -> Flight:
    """Return a flight that glides to the view of `camera`; its roll is left out."""
    direction = difference(camera.target, camera.position)
    yaw, pitch = flight.axes.angles(direction, flight.yaw_goal)
    return dataclasses.replace(
        flight,
        glide=difference(camera.position, flight.position),
        yaw_goal=yaw,
        pitch_goal=pitch,
        orbiting=False,
        velocity=_ZERO,
        dolly=0.0,
        reach=math.hypot(*direction),
        fov_y=camera.fov_y,
        height=camera.height,
    )


def jump_to(flight: Flight, camera: Camera) -> Flight:
    """Return a flight at rest at the view of `camera`; its roll is left out."""
    flight = glide_to(flight, camera)
    return dataclasses.replace(
        flight,
        position=vector(camera.position),
        yaw=flight.yaw_goal,
        pitch=flight.pitch_goal,
        glide=_ZERO,
    )


def stilled(flight: Flight) -> Flight:
    """Return a flight at rest at exactly the view that this one has now."""
    return dataclasses.replace(
        flight,
        velocity=_ZERO,
        glide=_ZERO,
        dolly=0.0,
        yaw_goal=flight.yaw,
        pitch_goal=flight.pitch,
    )


def switch_projection(flight: Flight) -> Flight:
    """Return a flight with parallel rays or without; what is at the target keeps its size."""
    camera = flight.camera()
    is_parallel = camera.height is not None
    return jump_to(flight, camera.perspective() if is_parallel else camera.orthographic())


def go_home(flight: Flight) -> Flight:
    """Return a flight at rest at home; the speed that the wheel has set is kept."""
    fresh = start_flight(flight.home, flight.diagonal)
    return dataclasses.replace(fresh, speed_factor=flight.speed_factor)


def fit(flight: Flight, bounds: tuple[FloatArray, FloatArray], aspect: float) -> Flight:
    """Return a flight that glides to where all of the scene is seen, looking the same way.

    Parameters
    ----------
    bounds : (ndarray, ndarray)
        Corners of the scene, world space.
    aspect : float
        Width over height of the picture.
    """
    centre = vector(0.5 * (bounds[0] + bounds[1]))
    frame = flight.axes.frame(flight.yaw_goal, flight.pitch_goal)
    tangents = dataclasses.replace(flight.home, height=None).tan_half_fov(aspect)
    distance = 0.0
    for corner in itertools.product(*zip(*bounds, strict=True)):
        x, y, depth = (dot(axis, difference(vector(corner), centre)) for axis in frame)
        distance = max(distance, abs(x) / tangents[0] - depth, abs(y) / tangents[1] - depth)
    distance *= FIT_MARGIN
    forward = frame[2]
    view = dataclasses.replace(
        flight.home, position=add(centre, forward, -distance), target=centre, height=None
    )
    if flight.height is not None:
        view = view.orthographic()
    return dataclasses.replace(glide_to(flight, view), pivot=centre)
