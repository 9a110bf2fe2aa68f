"""TOML from people: read, or refused in one line that says where and why."""

from __future__ import annotations

import re
import tomllib
from typing import Any


def read_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        One line, the place in front.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(_syntax_message(str(error), text)) from None
    except RecursionError:
        raise ValueError("tables or arrays are nested too deeply") from None
    except ValueError:
        # Python reads no decimal of more than 4300 digits.
        raise ValueError("a whole number has thousands of digits") from None


def _syntax_message(message: str, text: str) -> str:
    """Return the parser's message, on one line and with the place in front."""
    flat = " ".join(message.split())
    match = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", flat)
    if match:
        line, column = int(match[2]), int(match[3])
        rest = text.replace("\r\n", "\n").split("\n")[line - 1][column - 1 :]
        hint = _hint(rest) if match[1] == "Invalid value" else ""
        return f"line {line}, column {column}: not valid TOML: {match[1]}{hint}"
    end = re.fullmatch(r"(.*) \(at end of document\)", flat)
    if end:
        last = text.rsplit("\n", 1)[-1]
        line, column = text.count("\n") + 1, len(last) + 1
        return f"line {line}, column {column}: not valid TOML: {end[1]} at the end of the file"
    return f"not valid TOML: {flat}"


def _hint(rest: str) -> str:
    """Return what TOML asks for where people write what other languages take."""
    word = re.match(r"[^\s,\]}#]*", rest)
    found = word[0] if word else ""
    if re.match(r"[+-]?\.\d", found):
        return f"; write {found.replace('.', '0.', 1)} for {found}"
    if found in ("True", "False"):
        return f"; write {found.lower()} for {found}"
    return f'; text stands in quotes: "{found}"' if re.fullmatch(r"[A-Za-z_][\w-]*", found) else ""
