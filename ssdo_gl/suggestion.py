"""The nearest known name, for messages about an unknown one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def suggestion(name: str, known: Iterable[str], *, lists: bool = True) -> str:
    """Return the end of a message: the nearest name, or else all of them if it `lists` them."""
    names = list(known)
    # What it begins, if that is one name alone: --list is no --light.
    near = [item for item in names if item.startswith(name)] if len(name.strip("-")) > 2 else []
    if len(near) != 1:
        near = difflib.get_close_matches(name, names, n=1)
    if near:
        return f"; did you mean {near[0]!r}?"
    if not lists:
        return ""
    return f"; choose one of {', '.join(names)}" if names else "; none is known here"
