"""The one function that texts from files pass before they are printed."""

from __future__ import annotations

import unicodedata

# Control codes move the cursor and set colours and titles, format codes reorder text;
# surrogates stand for bytes of file names that are not UTF-8.
_HIDDEN = ("Cc", "Cf", "Cs", "Co", "Zl", "Zp")


def printable(text: str) -> str:
    """Return `text` with everything that a terminal might obey shown as an escape."""
    return "".join(_shown(c) if unicodedata.category(c) in _HIDDEN else c for c in text)


def _shown(character: str) -> str:
    return character.encode("unicode_escape", "backslashreplace").decode("ascii")
