"""One uniform of a program: packs values for the driver and sends those that are new."""

from __future__ import annotations

import struct
from typing import Any

import moderngl
import numpy as np

from ssdo_gl.gpu.shader_source import ShaderError, UniformDeclaration

# Matrices are square: the number of rows by GLSL type.
_MATRIX_ROWS = {"mat2": 2, "mat3": 3, "mat4": 4}
# Letter of `struct` by the beginning of a GLSL type.
_LETTERS = {"float": "f", "vec": "f", "int": "i", "ivec": "i", "uint": "I", "uvec": "I"}


class UniformSlot:
    """A uniform that the driver has, and the value that it holds.

    Attributes
    ----------
    constant : object
        The value, if it is a number, a tuple of numbers or a read-only array: what cannot
        change need not be packed to know that it has not. Else None.

    Parameters
    ----------
    program_name : str
        For messages.
    """

    def __init__(
        self,
        program_name: str,
        name: str,
        declaration: UniformDeclaration,
        member: moderngl.Uniform,
    ) -> None:
        self._label = f"{program_name}: {declaration.type} {name}"
        self._type, self._is_array = declaration.type, declaration.is_array
        self._member = member
        # Asked once here: for every draw it would make the driver wait.
        self._byte_count = len(member.read())
        self._layout = None if self._is_array else _layout_of(self._type)
        is_real = self._type.startswith(("float", "vec"))
        self._kinds = frozenset((int, float, np.float64) if is_real else (int,))
        self._dtype = _dtype_of(self._type)
        self._rows = _MATRIX_ROWS.get(self._type)
        self._data: bytes | None = None
        self.constant: object = None

    def set(self, value: object) -> None:
        """Give the uniform a value; raise ShaderError if it does not fit the type."""
        data = self._constants(value)
        is_constant = data is not None or (type(value) is np.ndarray and _cannot_change(value))
        if data is None:
            data = self._packed(value)
        if data != self._data:
            self._member.write(data)
            self._data = data
        self.constant = value if is_constant else None

    def _constants(self, value: object) -> bytes | None:
        """Return numbers that cannot change as bytes; None for all else.

        Without NumPy that takes a tenth of the time, and a frame sets a hundred values.
        """
        layout = self._layout
        if layout is None:
            return None
        numbers = value if type(value) is tuple else (value,)
        if not self._kinds.issuperset(map(type, numbers)):
            return None
        try:
            return layout.pack(*numbers)
        except (struct.error, OverflowError):
            return None

    def _packed(self, value: object) -> bytes:
        """Return any value as the bytes that the driver takes."""
        array, rows = np.asarray(value), self._rows
        if self._dtype is not np.float32 and array.dtype.kind not in "iub":
            raise ShaderError(f"{self._label} takes whole numbers, not {value!r}")
        if rows is not None:
            if array.shape[-2:] != (rows, rows):
                raise ShaderError(f"{self._label} got an array of {array.shape}")
            # OpenGL stores matrices column by column.
            array = array.swapaxes(-1, -2)
        data = array.astype(self._dtype).tobytes()
        wanted = self._byte_count
        # A driver may cut unused elements off the end of an array, never off a vector.
        if len(data) != wanted and not (self._is_array and len(data) > wanted):
            raise ShaderError(f"{self._label} takes {wanted // 4} numbers, not {array.size}")
        return data[:wanted]


def _cannot_change(array: np.ndarray[Any, Any]) -> bool:
    """Return whether nobody can write to an array, which is no part of another one."""
    return not array.flags.writeable and array.base is None


def _dtype_of(kind: str) -> type[np.generic]:
    """Return what values of a GLSL type are packed as."""
    if kind.startswith("u"):
        return np.uint32
    return np.int32 if kind.startswith(("int", "ivec", "bool", "bvec")) else np.float32


def _layout_of(kind: str) -> struct.Struct | None:
    """Return how `struct` packs a number or vector of a GLSL type; None for others."""
    count = kind[-1] if "vec" in kind else "1"
    letter = _LETTERS.get(kind.rstrip("234"))
    return None if letter is None else struct.Struct(f"={count}{letter}")
