"""One-line descriptions of data that holds large arrays, for `repr`."""

from __future__ import annotations

import dataclasses
from typing import Any


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
