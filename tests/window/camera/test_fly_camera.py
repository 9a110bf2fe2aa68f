"""The flight: the same path at every frame rate, at rest in the end, at home on request."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.window.camera import fly_camera
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.camera.destinations import (
    fit,
    focus_on,
    glide_to,
    go_home,
    jump_to,
    switch_projection,
)
from ssdo_gl.window.camera.fly_camera import Flight, advance, start_flight

HOME = Camera(position=(0.0, 0.0, 3.6), target=(0.0, 0.0, 0.0))
DIAGONAL = 3.5
# Straight flight is integrated in closed form: only rounding may differ.
STRAIGHT_TOLERANCE = 1e-12 * DIAGONAL
# In a turn the orientation is held at its mean over steps of at most 1/120 s; turning by
# 1.6 rad/s, that is wrong by (1.6 / 120)^2 / 24 = 7e-6 of the way, which is 0.4
# diagonals long here. Measured: 1e-6 diagonals.
TURN_TOLERANCE = 3e-6 * DIAGONAL
# Rates from a slide show to a fast display, none a multiple of the next.
FRAME_RATES = (7.0, 24.0, 60.0, 144.0)

Script = Callable[[float], Controls]


def fly(script: Script, rate: float, seconds: float, flight: Flight | None = None) -> Flight:
    """Fly by `script`, a function of time, with frames as long as 1/rate.

    Frames also end where the script changes (at whole quarters of a second), as real
    events end them: what differs between rates is then the integration alone.
    """
    flight = flight or start_flight(HOME, DIAGONAL)
    quarters = round(seconds * 4)
    for quarter in range(quarters):
        start, left = quarter / 4, 0.25
        while left > 1e-12:
            step = min(1.0 / rate, left)
            flight = advance(flight, script(start), step)
            left -= step
    return flight


def nudge(flight: Flight, controls: Controls, rate: float, seconds: float) -> Flight:
    """Give `controls` once, then let the flight go on by itself."""
    return fly(lambda t: Controls(), rate, seconds, advance(flight, controls, 0.0))


def forward_then_sideways(t: float) -> Controls:
    if t < 1.0:
        return Controls(move=(0.0, 0.0, 1.0))
    return Controls(move=(1.0, 0.5, 0.0), fast=True) if t < 1.5 else Controls()


def turning_walk(t: float) -> Controls:
    if t < 2.0:
        return Controls(move=(0.0, 0.0, 1.0), turn_rate=(1.6, -0.3))
    return Controls()


@pytest.mark.parametrize("rate", FRAME_RATES)
def test_straight_flight_is_the_same_at_every_frame_rate(rate: float) -> None:
    expected = fly(forward_then_sideways, 1000.0, 3.0)
    assert math.dist(expected.position, HOME.position) > 0.5 * DIAGONAL * 0.2
    result = fly(forward_then_sideways, rate, 3.0)
    assert math.dist(result.position, expected.position) < STRAIGHT_TOLERANCE


@pytest.mark.parametrize("rate", FRAME_RATES)
def test_turning_flight_is_the_same_at_every_frame_rate(rate: float) -> None:
    expected = fly(turning_walk, 2000.0, 3.0)
    result = fly(turning_walk, rate, 3.0)
    assert math.dist(result.position, expected.position) < TURN_TOLERANCE
    assert result.yaw == pytest.approx(expected.yaw, abs=1e-9)


@pytest.mark.parametrize("rate", FRAME_RATES)
def test_held_key_travels_speed_times_time(rate: float) -> None:
    """Starting and stopping lag cancel: the way is exactly speed * time held."""
    flight = fly(lambda t: Controls(move=(0.0, 0.0, float(t < 2.0))), rate, 4.0)
    way = math.dist(flight.position, HOME.position)
    # The remaining velocity is cut off below a millionth of the scene per second.
    assert way == pytest.approx(2.0 * fly_camera.DIAGONALS_PER_SECOND * DIAGONAL, rel=1e-5)


def test_speed_relaxes_exponentially() -> None:
    forward = Controls(move=(0.0, 0.0, 1.0))
    flight = advance(start_flight(HOME, DIAGONAL), forward, fly_camera.MOVE_SECONDS)
    reached = math.hypot(*flight.velocity) / fly_camera.speed_of(flight)
    assert reached == pytest.approx(1.0 - math.exp(-1.0), rel=1e-12)


def test_diagonal_flight_is_not_faster() -> None:
    straight = fly(lambda t: Controls(move=(0.0, 0.0, 1.0)), 60.0, 1.0)
    diagonal = fly(lambda t: Controls(move=(1.0, 1.0, 1.0)), 60.0, 1.0)
    assert math.dist(diagonal.position, HOME.position) == pytest.approx(
        math.dist(straight.position, HOME.position), rel=1e-12
    )


@pytest.mark.parametrize(
    ("move", "direction"),
    [((0, 0, 1), (0, 0, -1)), ((1, 0, 0), (1, 0, 0)), ((0, 1, 0), (0, 1, 0))],
)
def test_moves_go_where_they_say(move: tuple[float, ...], direction: tuple[float, ...]) -> None:
    flight = fly(lambda t: Controls(move=(move[0], move[1], move[2])), 60.0, 1.0)
    way = np.subtract(flight.position, HOME.position)
    np.testing.assert_allclose(way / np.linalg.norm(way), direction, atol=1e-12)


@pytest.mark.parametrize("notches", [-300, 300])
def test_wheel_ends_where_the_scene_is_a_pixel_or_the_pivot_is_met(notches: int) -> None:
    flight = fly_camera.set_pivot(start_flight(HOME, DIAGONAL), None)
    step = Controls(dolly=math.copysign(1.0, notches))
    for _ in range(abs(notches)):
        flight = advance(flight, step, 1.0 / 60.0)
    for _ in range(120):
        flight = advance(flight, Controls(), 1.0 / 60.0)
    assert flight.pivot is not None and not flight.is_moving
    distance = math.dist(flight.position, flight.pivot) / DIAGONAL
    assert distance == pytest.approx(fly_camera.DOLLY_LIMITS[int(notches < 0)], rel=1e-6)
    flight.camera().view_from_world_rotation()
    # And back again: what lies beyond the limit was never put aside.
    back = advance(flight, Controls(dolly=-step.dolly), 1.0)
    assert back.dolly != 0.0


def test_turning_left_looks_left_and_up_looks_up() -> None:
    flight = nudge(start_flight(HOME, DIAGONAL), Controls(turn=(0.3, 0.1)), 4.0, 2.0)
    assert flight.forward[0] == pytest.approx(-math.sin(0.3) * math.cos(0.1), abs=1e-12)
    assert flight.forward[1] == pytest.approx(math.sin(0.1), abs=1e-12)


def test_camera_is_exactly_home_until_something_moves() -> None:
    flight = start_flight(HOME, DIAGONAL)
    assert flight.camera() is HOME
    assert advance(flight, Controls(), 1.0).camera() is HOME
    moved = advance(flight, Controls(turn=(0.01, 0.0)), 0.1)
    assert moved.camera() != HOME


def test_home_ends_every_motion() -> None:
    flight = go_home(fly(turning_walk, 30.0, 1.0))
    assert flight.camera() is HOME
    assert not flight.is_moving


@pytest.mark.parametrize("up", [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 2.0, -0.5)])
@pytest.mark.parametrize("target", [(0.3, -1.0, 2.0), (4.0, 0.2, 0.1), (-1.0, -1.0, -9.0)])
def test_camera_of_a_turned_flight_is_what_yaw_and_pitch_say(
    up: tuple[float, float, float], target: tuple[float, float, float]
) -> None:
    """Turning there and back through the camera's own matrix: no roll, no drift."""
    home = Camera(position=(0.1, 0.2, 0.3), target=target, up=up)
    flight = nudge(start_flight(home, DIAGONAL), Controls(turn=(0.7, 0.2)), 4.0, 2.0)
    before = home.view_from_world_rotation()
    after = flight.camera().view_from_world_rotation()
    up_unit = math3d.normalized(up)
    assert after[0] @ up_unit == pytest.approx(0.0, abs=1e-12)
    turned = math.asin(-after[2] @ up_unit) - math.asin(-before[2] @ up_unit)
    assert turned == pytest.approx(0.2, abs=1e-9)
    flat = [math3d.normalized(m[0] - up_unit * (m[0] @ up_unit)) for m in (before, after)]
    assert np.cross(flat[0], flat[1]) @ up_unit == pytest.approx(math.sin(0.7), abs=1e-9)


def test_home_that_looks_straight_down_is_kept_and_can_be_left() -> None:
    home = Camera(position=(0.0, 5.0, 0.0), target=(0.0, 0.0, 0.0))
    flight = start_flight(home, DIAGONAL)
    assert flight.camera() is home
    moved = advance(flight, Controls(move=(0.0, 1.0, 0.0)), 0.1)
    np.testing.assert_allclose(
        moved.camera().view_from_world_rotation(), home.view_from_world_rotation(), atol=1e-9
    )
    flight = nudge(flight, Controls(turn=(0.0, 0.5)), 60.0, 1.0)
    assert flight.pitch == pytest.approx(0.5 - 0.5 * math.pi)


def test_pitch_stops_before_straight_up() -> None:
    flight = fly(lambda t: Controls(turn_rate=(0.0, 5.0)), 60.0, 2.0)
    assert flight.pitch <= fly_camera.PITCH_LIMIT
    view_from_world = flight.camera().view_from_world_rotation()
    assert view_from_world[0] == pytest.approx(np.array([1.0, 0.0, 0.0]), abs=1e-9)


def test_flight_comes_to_rest_and_then_stays_bit_equal() -> None:
    flight = fly(turning_walk, 60.0, 4.0)
    assert not flight.is_moving
    assert advance(flight, Controls(), 0.016) == flight


def test_orbit_comes_to_rest_and_then_stays_bit_equal() -> None:
    flight = start_flight(Camera(position=(2.3, 1.9, 2.9), target=(0.35, 0.42, 0.35)), DIAGONAL)
    flight = fly_camera.set_pivot(flight, (0.11172773, -6.2e-08, 0.03464469))
    flight = nudge(flight, Controls(orbit=(-0.108, 0.0)), 60.0, 4.0)
    assert not flight.is_moving
    assert advance(flight, Controls(), 0.016) == flight


@pytest.mark.parametrize("rate", FRAME_RATES)
def test_orbit_keeps_the_pivot_at_its_place_in_the_picture(rate: float) -> None:
    pivot = (0.4, 0.3, -0.2)
    flight = fly_camera.set_pivot(start_flight(HOME, DIAGONAL), pivot)
    before = HOME.view_from_world_rotation() @ np.subtract(pivot, flight.position)
    flight = nudge(flight, Controls(orbit=(0.9, -0.4)), rate, 1.0)
    assert flight.yaw == pytest.approx(0.9, abs=1e-9)
    assert math.dist(flight.position, HOME.position) > 1.0
    camera = flight.camera()
    after = camera.view_from_world_rotation() @ np.subtract(pivot, camera.position)
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_dolly_scales_the_distance_to_the_pivot() -> None:
    flight = fly_camera.set_pivot(start_flight(HOME, DIAGONAL), (0.0, 0.0, 0.0))
    flight = advance(flight, Controls(dolly=2.0), 0.0)
    for _ in range(200):
        flight = advance(flight, Controls(), 0.02)
    expected = 3.6 * math.exp(-2.0 * fly_camera.DOLLY_STEP)
    # The last 1e-5 of the logarithm are dropped when it comes to rest.
    assert flight.position[2] == pytest.approx(expected, rel=2e-5)
    assert not flight.is_moving


def test_orbit_without_a_pivot_turns_around_the_target() -> None:
    flight = nudge(start_flight(HOME, DIAGONAL), Controls(orbit=(0.25, 0.0)), 4.0, 2.0)
    assert flight.pivot == pytest.approx(HOME.target)
    assert math.hypot(*flight.position) == pytest.approx(3.6, rel=1e-9)


def test_looking_ends_the_orbit() -> None:
    flight = fly_camera.set_pivot(start_flight(HOME, DIAGONAL), (0.0, 0.0, 0.0))
    flight = advance(flight, Controls(orbit=(0.1, 0.0)), 0.5)
    still = flight.position
    flight = advance(flight, Controls(turn=(0.5, 0.0)), 0.5)
    assert flight.position == pytest.approx(still, abs=1e-5)


@pytest.mark.parametrize("rate", FRAME_RATES)
def test_focus_turns_to_the_point_and_halves_the_distance(rate: float) -> None:
    point = (1.5, -0.5, 1.0)
    flight = focus_on(start_flight(HOME, DIAGONAL), point)
    distance = math.dist(point, HOME.position)
    flight = fly(lambda t: Controls(), rate, 4.0, flight)
    assert not flight.is_moving
    assert math.dist(point, flight.position) == pytest.approx(0.5 * distance, rel=1e-6)
    to_point = np.subtract(point, flight.position)
    np.testing.assert_allclose(flight.forward, to_point / np.linalg.norm(to_point), atol=1e-5)


def test_move_key_cancels_a_glide() -> None:
    flight = focus_on(start_flight(HOME, DIAGONAL), (0.0, 0.0, -1.0))
    flight = advance(flight, Controls(move=(1.0, 0.0, 0.0)), 0.01)
    assert flight.glide == (0.0, 0.0, 0.0)


def test_glide_and_jump_end_at_the_same_view() -> None:
    goal = Camera(position=(1.0, 2.0, -3.0), target=(0.0, 0.5, 0.0), fov_y=55.0)
    start = fly(turning_walk, 60.0, 1.0)
    glided = fly(lambda t: Controls(), 60.0, 4.0, glide_to(start, goal))
    jumped = jump_to(start, goal)
    assert not jumped.is_moving
    np.testing.assert_allclose(glided.position, jumped.position, atol=1e-5 * DIAGONAL)
    np.testing.assert_allclose(
        jumped.camera().view_from_world_rotation(), goal.view_from_world_rotation(), atol=1e-9
    )
    assert jumped.camera().fov_y == 55.0
    np.testing.assert_allclose(jumped.camera().target, goal.target, atol=1e-12)


def test_speed_scales_with_the_scene_and_the_wheel() -> None:
    small, large = start_flight(HOME, 1.0), start_flight(HOME, 1000.0)
    assert fly_camera.speed_of(large) == pytest.approx(1000.0 * fly_camera.speed_of(small))
    faster = advance(small, Controls(speed=6.0), 0.0)
    assert fly_camera.speed_of(faster) == pytest.approx(2.0 * fly_camera.speed_of(small))
    limited = advance(small, Controls(speed=1e4), 0.0)
    assert limited.speed_factor == fly_camera.SPEED_LIMITS[1]


def test_near_a_wall_flight_is_slower_and_never_stops() -> None:
    flight = start_flight(HOME, DIAGONAL)
    open_speed = fly_camera.speed_of(flight)
    half_way = 0.5 * fly_camera.OPEN_SPACE * DIAGONAL
    assert fly_camera.speed_of(flight, clearance=half_way) == pytest.approx(0.5 * open_speed)
    assert fly_camera.speed_of(flight, clearance=0.0) == pytest.approx(0.1 * open_speed)
    assert fly_camera.speed_of(flight, clearance=100.0) == open_speed


def test_a_long_pause_is_no_leap() -> None:
    flight = advance(start_flight(HOME, DIAGONAL), Controls(move=(0.0, 0.0, 1.0)), 3600.0)
    assert math.dist(flight.position, HOME.position) < 0.25 * fly_camera.speed_of(flight)


def test_far_from_the_origin_the_target_keeps_its_direction() -> None:
    """1e5 away, position + forward must still tell the direction to 1e-9."""
    home = dataclasses.replace(HOME, position=(1e5, 1e5, 1e5 + 3.6), target=(1e5, 1e5, 1e5))
    flight = start_flight(home, DIAGONAL)
    flight = nudge(flight, Controls(turn=(0.5, 0.1)), 4.0, 2.0)
    np.testing.assert_allclose(
        -flight.camera().view_from_world_rotation()[2], flight.forward, atol=1e-9
    )


def seen_at(flight: Flight, point: tuple[float, float, float]) -> tuple[float, float]:
    """Return where a point is in the picture, in heights from its middle."""
    right, up, forward = flight.axes.frame(flight.yaw, flight.pitch)
    x, y, z = (
        float(np.dot(axis, np.subtract(point, flight.position))) for axis in (right, up, forward)
    )
    height = 2.0 * math.tan(math.radians(0.5 * flight.fov_y)) * z
    return x / height, y / height


def test_a_slide_takes_the_point_along_with_the_cursor() -> None:
    point = (0.4, 0.3, 0.5)
    flight = fly_camera.set_pivot(start_flight(HOME, DIAGONAL), point)
    before = seen_at(flight, point)
    flight = advance(flight, Controls(slide=(0.1, -0.2)), 1.0 / 60.0)
    assert seen_at(flight, point) == pytest.approx((before[0] + 0.1, before[1] - 0.2))


@pytest.mark.parametrize("yaw", [0.0, 2.0])
@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_a_scene_that_fits_is_seen_whole_and_large(yaw: float, aspect: float) -> None:
    low, high = np.array([-3.0, 0.0, 1.0]), np.array([2.0, 8.0, 3.0])
    flight = dataclasses.replace(start_flight(HOME, DIAGONAL), yaw=yaw, yaw_goal=yaw)
    flight = fit(flight, (low, high), aspect)
    while flight.is_moving:
        flight = advance(flight, Controls(), 1.0 / 30.0)
    corners = [(x, y, z) for x in (-3.0, 2.0) for y in (0.0, 8.0) for z in (1.0, 3.0)]
    places = np.abs([seen_at(flight, corner) for corner in corners])
    reach = max(places[:, 0].max() / aspect, places[:, 1].max())
    assert 0.4 < reach < 0.5
    assert flight.yaw == pytest.approx(yaw)


def test_parallel_rays_and_back_keep_the_target_in_its_size() -> None:
    flight = fly(turning_walk, 60.0, 1.0)
    before = flight.camera()
    parallel = switch_projection(flight)
    assert parallel.camera().height == pytest.approx(before.height_at_target)
    assert parallel.position == flight.position
    back = switch_projection(parallel)
    assert back.camera().height is None
    assert back.position == pytest.approx(flight.position)


def test_the_wheel_changes_how_much_parallel_rays_show() -> None:
    """The pivot stays at its place in the picture, and the camera at its distance from it."""
    pivot = (0.7, 0.4, -0.5)
    flight = switch_projection(start_flight(HOME, DIAGONAL))
    before = flight.camera()
    flight = advance(fly_camera.set_pivot(flight, pivot), Controls(dolly=2.0), 0.0)
    for _ in range(200):
        flight = advance(flight, Controls(), 0.02)
    after = flight.camera()
    assert not flight.is_moving
    assert before.height is not None and after.height is not None
    ratio = math.exp(-2.0 * fly_camera.DOLLY_STEP)
    assert after.height == pytest.approx(before.height * ratio, rel=2e-5)
    seen = [c.view_from_world_rotation() @ np.subtract(pivot, c.position) for c in (before, after)]
    np.testing.assert_allclose(seen[1][:2], seen[0][:2] * ratio, rtol=3e-5)
    assert seen[1][2] == pytest.approx(seen[0][2])


def test_the_wheel_ends_between_parallel_rays_too() -> None:
    flight = switch_projection(start_flight(HOME, DIAGONAL))
    for _ in range(600):
        flight = advance(flight, Controls(dolly=-1.0), 0.05)
    height = flight.camera().height
    assert height is not None and height < 2.0 * fly_camera.DOLLY_LIMITS[1] * DIAGONAL
