"""The gate that every number from a file, or of an argument, passes."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.math3d import FloatArray, Vector, vector
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError, plain, shown

# float32 holds 3.4e38, but sums and products of larger numbers than this leave it.
LARGEST_NUMBER = 1e30
# Colours may leave [0, 1] by a step of half floats near 1, as conversions between spaces do.
_COLOR_ROUNDING = 2.0**-10


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


def hold_numbers(owner: object, *names: str) -> None:
    """Check fields of a frozen dataclass, and keep them as Python's, which every file takes."""
    for name in names:
        check_number(name, getattr(owner, name))
        object.__setattr__(owner, name, plain(getattr(owner, name)))


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


def linear_colors(colors: ArrayLike) -> FloatArray:
    """Return colours as scene-linear RGBA; those of uint8 are sRGB."""
    array = np.asarray(colors)
    if array.ndim != 2 or array.shape[1] not in (3, 4) or array.dtype.kind not in "uif":
        raise SceneError(f"colors: expected numbers of shape (V, 3) or (V, 4), got {array.shape}")
    values = array.astype(np.float64)
    if array.dtype == np.uint8:
        values /= 255.0
        values[:, :3] = linear_from_srgb(values[:, :3])
    beyond = (values < -_COLOR_ROUNDING) | (values > 1.0 + _COLOR_ROUNDING)
    if beyond.any():  # whole numbers up to 255 of another type than uint8, most often
        first = int(np.argmax(beyond.any(axis=1)))
        raise SceneError(
            f"colors[{first}] = {values[first].tolist()}: expected numbers from 0 to 1, or uint8"
        )
    return np.column_stack([values, np.ones(len(values))]) if array.shape[1] == 3 else values


def is_float64(value: object) -> bool:
    """Return whether an argument is an array of float64 as it is."""
    return isinstance(value, np.ndarray) and value.dtype == np.float64


def array_of(name: str, value: Any, wanted: type[np.number[Any]]) -> Any:
    """Return an argument as an array of numbers, row by row; raises SettingError."""
    try:
        array = np.asarray(value)
        got = f"of {array.dtype}"
        kinds = "iu" if wanted is np.int64 and array.size else "iuf"
        is_usable = array.dtype.kind in kinds
    except ValueError:
        is_usable, got = False, "of rows that differ in length"
    else:
        if array.ndim == 0:
            is_usable, got = False, "without rows"
    if not is_usable:
        what = "whole numbers" if wanted is np.int64 else "numbers"
        raise SettingError(f"{name}: expected an array of {what}, got one {got}")
    return array.astype(wanted, order="C", copy=False)
