"""What flies along with a scene: the time of its animation, lines that come and go."""

from __future__ import annotations

import pytest
from window.driven_viewer import Clock as Wall

from ssdo_gl.window.scene_flight import FAULT_SECONDS, MOST_LINES, SECONDS, Clock, Messages


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


def test_lines_go_after_a_while_and_faults_later() -> None:
    clock = Wall()
    messages = Messages(clock)
    messages.say("wrote a.png")
    messages.say("cannot write", is_fault=True)
    assert not messages.expire()
    clock.seconds += SECONDS + 0.1
    assert messages.expire()
    assert [line.text for line in messages.lines] == ["cannot write"]
    clock.seconds += FAULT_SECONDS
    assert messages.expire()
    assert messages.lines == []
    assert not messages.expire()


def test_a_line_of_the_same_key_takes_the_place_of_the_old_one() -> None:
    messages = Messages(Wall())
    messages.say("1 of 9", key="film")
    messages.say("hello")
    messages.say("hello")
    messages.say("2 of 9", key="film")
    assert [line.text for line in messages.lines] == ["hello", "2 of 9"]


def test_only_the_last_few_are_shown() -> None:
    messages = Messages(Wall())
    for number in range(20):
        messages.say(str(number))
    assert [line.text for line in messages.lines] == [str(n) for n in range(20)][-MOST_LINES:]
