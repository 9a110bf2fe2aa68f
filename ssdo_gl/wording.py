"""Texts for people: made safe to print, the nearest known name, data in one line."""

from __future__ import annotations

import dataclasses
import difflib
import re
import unicodedata
from collections.abc import Iterable
from typing import Any

# Control codes move the cursor and set colours and titles, format codes reorder text;
# surrogates stand for bytes of file names that are not UTF-8.
_HIDDEN = ("Cc", "Cf", "Cs", "Co", "Zl", "Zp")


def printable(text: str) -> str:
    """Return `text` with everything that a terminal might obey shown as an escape."""
    return "".join(_shown(c) if unicodedata.category(c) in _HIDDEN else c for c in text)


def _shown(character: str) -> str:
    return character.encode("unicode_escape", "backslashreplace").decode("ascii")


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


def comma_hint(text: str) -> str:
    """Return the end of a message on what should be numbers, if they have decimal commas."""
    return "; decimals take a point, not a comma" if re.search(r"\d,\d", text) else ""


def counted(number: int, noun: str) -> str:
    """Return ``1 light``, ``3 lights``; ``3 meshes``."""
    plural = noun + ("es" if noun.endswith("sh") else "s")
    return f"{number} {noun if number == 1 else plural}"


def with_article(noun: str) -> str:
    """Return ``a light``, ``an int``."""
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"


def described(value: object, *facts: str) -> str:
    """Return ``Type(fact, fact)``, without the empty ones."""
    return f"{type(value).__name__}({', '.join(fact for fact in facts if fact)})"


def chosen_fields(value: Any) -> str:
    """Return ``Type(field=value, ...)`` of the fields that differ from their defaults."""
    facts = []
    for field in dataclasses.fields(value):
        item = getattr(value, field.name)
        has_default = field.default is not dataclasses.MISSING
        if field.repr and not (has_default and (item is field.default or item == field.default)):
            facts.append(f"{field.name}={item!r}")
    return described(value, *facts)
