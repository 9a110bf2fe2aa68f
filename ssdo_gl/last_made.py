"""Keeps what was made last for as long as it would come out the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Given = TypeVar("Given")
Made = TypeVar("Made")


def are_same(a: Sequence[object], b: Sequence[object]) -> bool:
    """Return whether two sequences hold the very same objects."""
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


class LastMade(Generic[Made]):
    """What was made last: it holds while it is made from the very same objects.

    They must not change. They are kept, so that no other object takes their place in memory.
    """

    def __init__(self) -> None:
        self._last: tuple[tuple[object, ...], Made] | None = None

    def get(self, made_from: tuple[object, ...], make: Callable[[], Made]) -> Made:
        """Return it; make it anew where any object it is made from is another one."""
        last = self._last
        # The loop, because it is asked many times a frame.
        if last is not None:
            for a, b in zip(last[0], made_from, strict=True):
                if a is not b:
                    break
            else:
                return last[1]
        last = self._last = made_from, make()
        return last[1]


class MadeOfEach(Generic[Given, Made]):
    """What `make` makes of objects that do not change: the same one every time.

    At most `most` of them and the objects they are made of are kept.
    """

    def __init__(self, make: Callable[[Given], Made], most: int) -> None:
        self._make = make
        self._most = most
        self._made: dict[int, tuple[Given, Made]] = {}

    def of(self, given: Given) -> Made:
        """Return what is made of `given`."""
        known = self._made.get(id(given))
        if known is None:
            if len(self._made) >= self._most:
                self._made.clear()
            known = self._made[id(given)] = given, self._make(given)
        return known[1]
