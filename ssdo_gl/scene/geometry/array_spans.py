"""Long arrays a part at a time: temporaries that fit into a cache take no memory, nor time."""

from __future__ import annotations

from collections.abc import Iterator

SPAN = 1 << 14


def spans(count: int, length: int = SPAN) -> Iterator[slice]:
    """Yield slices of at most `length` that cover `count` rows, in order."""
    for start in range(0, count, length):
        yield slice(start, min(start + length, count))
