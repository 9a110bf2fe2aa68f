"""Lines that come, replace one another and go."""

from __future__ import annotations

from window.driven_viewer import Clock

from ssdo_gl.window.messages import FAULT_SECONDS, MOST_LINES, SECONDS, Messages


def test_lines_go_after_a_while_and_faults_later() -> None:
    clock = Clock()
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
    messages = Messages(Clock())
    messages.say("1 of 9", key="film")
    messages.say("hello")
    messages.say("hello")
    messages.say("2 of 9", key="film")
    assert [line.text for line in messages.lines] == ["hello", "2 of 9"]


def test_only_the_last_few_are_shown() -> None:
    messages = Messages(Clock())
    for number in range(20):
        messages.say(str(number))
    assert [line.text for line in messages.lines] == [str(n) for n in range(20)][-MOST_LINES:]
