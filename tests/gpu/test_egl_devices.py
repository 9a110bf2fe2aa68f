"""Which of EGL's devices are GPUs."""

from __future__ import annotations

import ctypes.util

import pytest

from ssdo_gl.gpu import egl_devices
from ssdo_gl.gpu.context import DEVICE_INDEX, create_context
from ssdo_gl.gpu.egl_devices import gpu_numbers, gpus_among

NVIDIA = b"EGL_NV_device_cuda EGL_EXT_device_drm"
DRM, SOFTWARE = b"EGL_EXT_device_drm", b"EGL_MESA_device_software"


@pytest.mark.parametrize(
    ("extensions", "gpus"),
    [
        ([], []),
        ([SOFTWARE], []),
        ([DRM, DRM, SOFTWARE], [0, 1]),
        ([NVIDIA, NVIDIA, DRM, DRM, SOFTWARE], [0, 1]),
        ([b"", SOFTWARE], []),
    ],
)
def test_each_gpu_counts_once(extensions: list[bytes], gpus: list[int]) -> None:
    assert gpus_among(extensions) == gpus


def test_devices_of_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    extensions = egl_devices._extensions_of_devices()
    if not extensions:
        pytest.skip("no EGL, or none that lists devices")
    assert all(extensions)
    for number in range(len(extensions)):
        monkeypatch.setenv(DEVICE_INDEX, str(number))
        if SOFTWARE in extensions[number] or number in gpu_numbers():
            device = create_context("egl")
            assert device.is_software == (SOFTWARE in extensions[number])
            device.release()


def test_without_egl_there_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(egl_devices, "find_library", lambda name: None)
    assert ctypes.util.find_library("EGL") is None or gpu_numbers() == []
