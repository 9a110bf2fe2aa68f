"""A device that several renderers use in turn, so that shaders are compiled once."""

from __future__ import annotations

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.shader import ShaderLibrary


class WarmDevice:
    """A device and its compiled shaders, made when first asked for."""

    def __init__(self) -> None:
        self._made: tuple[Device, ShaderLibrary] | None = None

    def made(self, backend: str) -> tuple[Device, ShaderLibrary]:
        """Return the device and its shaders; `backend` is that of the first call.

        Raises
        ------
        ContextError
        """
        if self._made is None:
            device = create_context(backend)
            self._made = device, ShaderLibrary(device.gl, computes=device.computes)
        return self._made

    def close(self) -> None:
        """Release the device; the next call makes another one."""
        if self._made is not None:
            self._made[0].release()
            self._made = None
