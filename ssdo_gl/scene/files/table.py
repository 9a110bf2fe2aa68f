"""Typed, range-checked reading of one TOML table, with errors that name the place."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FLAT_SINE, FloatArray, Vector
from ssdo_gl.scene.material import Color
from ssdo_gl.scene.numbers import finite
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import shown
from ssdo_gl.settings.settings import LONGEST
from ssdo_gl.wording import suggestion


class Table:
    """A TOML table that knows where it stands in which file.

    Parameters
    ----------
    source : str
        The file, as the user named it.
    place : str
        The table inside the file, for example ``[[light]] 2``; empty at the top.
    """

    def __init__(self, source: str, place: str, data: Mapping[str, Any]) -> None:
        self.source, self.place, self.data = source, place, data

    def where(self, key: str = "") -> str:
        """Return the place of `key` as errors show it."""
        inside = " ".join(part for part in (self.place, key) if part)
        return f"{self.source}: {inside}" if inside else self.source

    def fail(self, key: str, expected: str) -> NoReturn:
        """Raise the error of a bad or missing value: place, value, what is valid."""
        if key not in self.data:
            raise SceneError(f"{self.where()}: {key!r} is missing: {expected}")
        raise SceneError(f"{self.where(key)} = {shown(self.data[key])}: {expected}")

    def allow(self, *known: str) -> None:
        """Refuse every key that is not in `known`."""
        for key in self.data:
            if key not in known:
                hint = suggestion(key, known)
                raise SceneError(f"{self.where()}: unknown key {shown(key)}{hint}")

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
        open_ends: bool = False,
    ) -> float:
        """Return a finite number within [low, high], or (low, high) if `open_ends`."""
        if key not in self.data and default is not None:
            return default
        expected = "expected a number" + _range_text(low, high, open_ends)
        value = finite(self.data.get(key), LONGEST)
        if value is None:
            self.fail(key, expected)
        inside = low < value < high if open_ends else low <= value <= high
        if not inside:
            self.fail(key, expected)
        return value

    def integer(self, key: str, default: int | None, low: int, high: int) -> int:
        """Return a whole number within [low, high]."""
        if key not in self.data and default is not None:
            return default
        value = self.data.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self.fail(key, f"expected a whole number from {low} to {high}")
        return value

    def boolean(self, key: str, default: bool) -> bool:
        """Return true or false."""
        value = self.data.get(key, default)
        if not isinstance(value, bool):
            self.fail(key, "expected true or false")
        return value

    def text(self, key: str, default: str | None = None, choices: Sequence[str] = ()) -> str:
        """Return a string, one of `choices` where any are given."""
        if key not in self.data and default is not None:
            return default
        value = self.data.get(key)
        if not isinstance(value, str):
            self.fail(key, f"expected one of {', '.join(choices)}" if choices else "expected text")
        if choices and value not in choices:
            hint = suggestion(value, choices, lists=False)
            self.fail(key, f"expected one of {', '.join(choices)}{hint}")
        return value

    def numbers(self, key: str, count: int) -> FloatArray:
        """Return `count` finite numbers, shape (count,), float64."""
        value = self.data.get(key)
        if isinstance(value, list) and len(value) == count:
            numbers = [finite(item, LONGEST) for item in value]
            usable = [number for number in numbers if number is not None]
            if len(usable) == count:
                return np.array(usable)
        self.fail(key, f"expected {count} finite numbers up to {LONGEST:g}, [x, y, z]")

    def vector(self, key: str, default: Vector | None = None) -> Vector:
        """Return three finite numbers."""
        if key not in self.data and default is not None:
            return default
        x, y, z = self.numbers(key, 3)
        return float(x), float(y), float(z)

    def direction(self, key: str, default: Vector | None = None) -> Vector:
        """Return three finite numbers that are not all zero, as they stand."""
        value = self.vector(key, default)
        if not any(value):
            self.fail(key, "a direction must not be zero")
        return value

    def parallelogram(self) -> tuple[Vector, Vector, Vector]:
        """Return `corner`, `edge_u` and `edge_v`, which must span an area."""
        corner = self.vector("corner")
        edge_u, edge_v = self.direction("edge_u"), self.direction("edge_v")
        sine = np.linalg.norm(np.cross(math3d.normalized(edge_u), math3d.normalized(edge_v)))
        if sine < FLAT_SINE:
            self.fail("edge_v", "must not be parallel to edge_u: the area would be zero")
        return corner, edge_u, edge_v

    def color(self, key: str, default: Color | None = None, high: float = math.inf) -> Color:
        """Return linear red, green and blue >= 0 and at most `high`."""
        if key not in self.data and default is not None:
            return default
        value = self.data.get(key)
        expected = "expected three numbers [r, g, b]" + _range_text(0.0, high, False)
        if not isinstance(value, list) or len(value) != 3:
            self.fail(key, expected)
        parts = [finite(item, LONGEST) for item in value]
        good = [part for part in parts if part is not None and 0.0 <= part <= high]
        if len(good) != 3:
            self.fail(key, expected)
        return good[0], good[1], good[2]

    def table(self, key: str) -> Table | None:
        """Return the table under `key`, or None."""
        if key not in self.data:
            return None
        value = self.data[key]
        if not isinstance(value, dict):
            self.fail(key, "expected a table")
        inside = f"{self.place} {key}" if self.place else f"[{key}]"
        return Table(self.source, inside, value)

    def tables(self, key: str) -> list[Table]:
        """Return the array of tables under `key`, empty if there is none."""
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.fail(key, f"expected an array of tables: write [[{key}]]")
        result = []
        for index, item in enumerate(value):
            name = item.get("name")
            called = f" ({shown(name)})" if isinstance(name, str) else ""
            result.append(Table(self.source, f"[[{key}]] {index + 1}{called}", item))
        return result


def _range_text(low: float, high: float, open_ends: bool) -> str:
    more, less = ("greater than", "less than") if open_ends else ("at least", "at most")
    ends = []
    if low > -math.inf:
        ends.append(f"{more} {low:g}")
    if high == math.inf:
        less, high = "at most", LONGEST
    ends.append(f"{less} {high:g}")
    return " " + " and ".join(ends)
