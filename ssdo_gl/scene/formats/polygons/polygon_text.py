"""Numbers in the text of polygon files."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray


def numbers(text: bytes) -> NDArray[np.float64]:
    """Return all numbers of a text; line ends and blank lines count as spaces.

    Raises
    ------
    ValueError
        Naming the word that is no number.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=np.float64, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    # A slower look finds the word at fault, and forgives what C on Windows prints.
    words = text.split()
    result = np.empty(len(words))
    for index, word in enumerate(words):
        try:
            result[index] = float(word)
        except ValueError:
            if b"#" not in word:
                shown = word[:40].decode("latin-1")
                raise ValueError(f"{shown!r} stands where a number is expected") from None
            result[index] = np.nan
    return result
