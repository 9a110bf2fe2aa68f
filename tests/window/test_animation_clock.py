"""The time of an animation: runs, loops, is scrubbed."""

from __future__ import annotations

import pytest

from ssdo_gl.window.animation_clock import Clock


def test_a_loop_begins_again_at_its_end() -> None:
    clock = Clock.of(has_motion=True)
    clock.length_s, clock.loops = 2.0, True
    for _ in range(5):
        clock.advance(0.5)
    assert clock.seconds == pytest.approx(0.5)
    clock.loops = False
    clock.advance(2.0)
    assert clock.seconds == pytest.approx(2.5)


def test_scrubbing_stops_at_a_time() -> None:
    clock = Clock.of(has_motion=True)
    clock.scrub(1.25)
    clock.advance(1.0)
    assert clock.seconds == 1.25
    assert not clock.is_running
