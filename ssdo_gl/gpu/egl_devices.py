"""The GPUs that EGL offers, by the numbers that `context.DEVICE_INDEX` takes."""

from __future__ import annotations

import ctypes
from ctypes.util import find_library
from typing import Any

_MAX_DEVICES = 64
_EXTENSIONS = 0x3055


def gpu_numbers() -> list[int]:
    """Return the numbers of EGL's devices that are GPUs, each GPU once; none without EGL."""
    return gpus_among(_extensions_of_devices())


def gpus_among(extensions: list[bytes]) -> list[int]:
    """Return which of the devices with these extensions are GPUs.

    Where NVIDIA's driver is, Mesa may list its GPUs again, and can do nothing with them.
    """
    nvidia = [n for n, text in enumerate(extensions) if b"EGL_NV_device_cuda" in text]
    return nvidia or [
        n for n, text in enumerate(extensions) if text and b"EGL_MESA_device_software" not in text
    ]


def _extensions_of_devices() -> list[bytes]:
    name = find_library("EGL")
    if name is None:
        return []
    try:
        egl = ctypes.CDLL(name)
        query: Any = _function(egl, b"eglQueryDevicesEXT")
        text: Any = _function(egl, b"eglQueryDeviceStringEXT")
    except (OSError, AttributeError):
        return []
    text.restype = ctypes.c_char_p
    devices, count = (ctypes.c_void_p * _MAX_DEVICES)(), ctypes.c_int()
    if not query(_MAX_DEVICES, devices, ctypes.byref(count)):
        return []
    return [text(ctypes.c_void_p(device), _EXTENSIONS) or b"" for device in devices[: count.value]]


def _function(egl: ctypes.CDLL, name: bytes) -> Any:
    """Return a function of an extension; AttributeError if there is none."""
    find = egl.eglGetProcAddress
    find.restype = ctypes.c_void_p
    address = find(name)
    if not address:
        raise AttributeError(name.decode())
    return ctypes.CFUNCTYPE(ctypes.c_uint)(address)
