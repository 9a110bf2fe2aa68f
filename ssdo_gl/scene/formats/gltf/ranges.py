"""What a glTF file says that has no meaning: the nearest that has one is drawn, and said.

Khronos' validator calls most of it errors, some warnings; viewers draw all of it. What is no
number at all, or refers to what does not exist, is refused.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import Json, number, numbers
from ssdo_gl.settings.fields import shown

# Half a step of eight bits: exporters round, and no picture shows it.
_UNSEEN = 1.0 / 512.0


class Ranges:
    """Reads numbers and words of one document, and remembers which of them it replaced."""

    def __init__(self) -> None:
        self._replaced: dict[str, list[str]] = {}

    def number(
        self, data: Json, key: str, default: float, where: str, low: float = 0.0, high: float = 1.0
    ) -> float:
        """Return the number under `key`, or the end of the range that it lies beyond."""
        found = number(data, key, default, where)
        return float(self.nearest(np.array([found]), low, high, key, where)[0])

    def numbers(
        self, data: Json, key: str, default: tuple[float, ...], where: str, high: float = 1.0
    ) -> FloatArray:
        """Return as many numbers as `default` has, each from 0 to `high`."""
        return self.nearest(numbers(data, key, default, where), 0.0, high, key, where)

    def word(self, data: Json, key: str, choices: Iterable[str], where: str) -> str:
        """Return the word under `key`, or the first choice, the format's default."""
        first, *others = choices
        found = data.get(key, first)
        if found in (first, *others):
            return str(found)
        self.replaced(f"{key} {shown(found)} as {first}", where)
        return first

    def nearest(
        self, values: FloatArray, low: float, high: float, name: str, where: str
    ) -> FloatArray:
        """Return `values` within a range, and remember it if that changes the picture."""
        taken = np.clip(values, low, high)
        if np.abs(taken - values).max() > _UNSEEN:
            self.replaced(f"{name} {listed(values)} as {listed(taken)}", where)
        return taken

    def replaced(self, what: str, where: str) -> None:
        """Remember that something at `where` is drawn as something else."""
        users = self._replaced.setdefault(what, [])
        if where not in users:
            users.append(where)

    def note(self) -> str | None:
        """Return in one line what was replaced, if anything."""
        if not self._replaced:
            return None
        found = [
            f"{what} ({', '.join(users[:3])}"
            + (f" and {len(users) - 3} more)" if len(users) > 3 else ")")
            for what, users in self._replaced.items()
        ]
        more = f"; and {len(found) - 4} more" if len(found) > 4 else ""
        return f"values without a meaning, drawn as the nearest: {'; '.join(found[:4])}{more}"


def listed(values: FloatArray) -> str:
    """Return numbers as a file has them: one alone, several in brackets."""
    texts = [f"{value:g}" for value in values]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"
