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
        return f"line {match[2]}, column {match[3]}: not valid TOML: {match[1]}"
    end = re.fullmatch(r"(.*) \(at end of document\)", flat)
    if end:
        last = text.rsplit("\n", 1)[-1]
        line, column = text.count("\n") + 1, len(last) + 1
        return f"line {line}, column {column}: not valid TOML: {end[1]} at the end of the file"
    return f"not valid TOML: {flat}"
