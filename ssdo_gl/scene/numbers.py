"""The gate that every number from a file, or of an argument, passes."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np

from ssdo_gl.math3d import Vector, vector
from ssdo_gl.settings.fields import SettingError, shown

# float32 holds 3.4e38, but sums and products of larger numbers than this leave it.
LARGEST_NUMBER = 1e30


def finite(value: object, largest: float = LARGEST_NUMBER) -> float | None:
    """Return `value` as a float if it is a number of usable size, else None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    if not abs(value) <= largest:  # also false for NaN
        return None
    return float(value)


def three_numbers(name: str, value: Any) -> Vector:
    """Return an argument as a tuple of three finite floats; raises SettingError."""
    if type(value) is tuple and [type(number) for number in value] == [float] * 3:
        point: Vector = value
    else:
        try:
            point = vector(value)
        except (TypeError, ValueError):
            text = " ".join(shown(value).split())
            raise SettingError(f"{name} = {text}: expected three numbers") from None
    if not all(map(math.isfinite, point)):
        raise SettingError(f"{name} = {point}: expected finite numbers")
    if max(map(abs, point)) > LARGEST_NUMBER:
        raise SettingError(f"{name} = {point}: expected at most {LARGEST_NUMBER:g} in size")
    return point


def check_number(name: str, value: Any) -> None:
    """Raise SettingError unless an argument is a finite number."""
    if not (isinstance(value, (float, int, np.number)) and math.isfinite(value)):
        raise SettingError(f"{name} = {shown(value)}: expected a finite number")
    if abs(float(value)) > LARGEST_NUMBER:
        raise SettingError(f"{name} = {shown(value)}: expected at most {LARGEST_NUMBER:g} in size")


def checked_size(value: Any) -> tuple[int, int]:
    """Return a width and a height in pixels; raises SettingError."""
    try:
        width, height = map(operator.index, value)
    except (TypeError, ValueError):
        width = height = 0
    if min(width, height) < 1:
        raise SettingError(f"size = {shown(value)}: expected two whole numbers from 1 on")
    return width, height


def check_index(name: str, value: Any) -> None:
    """Raise SettingError unless an argument is a whole number from 0 on."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not (is_whole and value >= 0):
        raise SettingError(f"{name} = {shown(value)}: expected an index from 0 on")


def light_numbers(name: str, value: Any) -> Vector:
    """Return an argument as three finite numbers from 0 on; raises SettingError."""
    color = three_numbers(name, value)
    if min(color) < 0.0:
        raise SettingError(f"{name} = {color}: expected numbers from 0 on")
    return color
