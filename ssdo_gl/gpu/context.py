"""Creates an OpenGL 3.3 core context, with or without a display."""

from __future__ import annotations

import moderngl


class ContextError(RuntimeError):
    """No usable OpenGL: one line saying what was tried and which package helps."""


BACKENDS = ("auto", "egl", "osmesa", "window")

_SOFTWARE_NAMES = (
    "llvmpipe", "softpipe", "swrast", "swr", "swiftshader", "software", "gdi generic",
)  # fmt: skip


class Device:
    """An OpenGL context and what is known about it.

    Attributes
    ----------
    gl : moderngl.Context
    backend : str
        ``egl``, ``osmesa`` or ``window``.
    renderer, version : str
        As the driver names them.
    is_software : bool
        Whether pixels are drawn by the CPU.
    """

    def __init__(self, gl: moderngl.Context, backend: str) -> None:
        self.gl = gl
        self.backend = backend
        self.renderer = str(gl.info["GL_RENDERER"])
        self.version = str(gl.info["GL_VERSION"])
        self.is_software = any(name in self.renderer.lower() for name in _SOFTWARE_NAMES)
        # Objects are freed when Python drops them: everything runs on one thread.
        gl.gc_mode = "auto"

    def release(self) -> None:
        """Destroy the context; what was made with it must not be used afterwards."""
        self.gl.release()


def create_context(backend: str = "auto") -> Device:
    """Return a context; `backend` is one of auto, egl, osmesa, window."""
    if backend not in ("auto", "egl"):
        raise ContextError(f"backend {backend!r} is not available")
    try:
        gl = moderngl.create_context(standalone=True, backend="egl", require=330)  # type: ignore[arg-type]
    except Exception as error:
        raise ContextError(f"egl: {error}") from None
    return Device(gl, "egl")
