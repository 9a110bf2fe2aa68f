"""Creates an OpenGL 3.3 core context, with or without a display.

Three ways, tried in this order: EGL (a GPU or Mesa, no display), OSMesa (Mesa's
off-screen library, no display and no EGL) and a hidden window (any desktop).
"""

from __future__ import annotations

import os
import sys
import weakref
from collections.abc import Callable
from ctypes.util import find_library
from functools import cache, cached_property
from types import ModuleType
from typing import Any

import moderngl

from ssdo_gl.gpu.compute import computes_faster
from ssdo_gl.gpu.context_owner import (
    ContextOwner,
    destroy_context,
    destroy_dropped,
    drop_context,
    note_process,
)
from ssdo_gl.gpu.driver_cache import leave_full_disk_alone
from ssdo_gl.gpu.glfw_use import GLFW_USE, GlfwLoader, errors_of

BACKENDS = ("auto", "egl", "osmesa", "window")

_REQUIRED_VERSION = 330
# The first with compute shaders; a driver gives no newer one than it was asked for.
_COMPUTE_VERSION = 450
_ADVICE = (
    "on Debian or Ubuntu, apt-get install libegl1 libgl1 libgl1-mesa-dri (for egl) "
    "or libosmesa6 (for osmesa)"
    if sys.platform.startswith("linux")
    else "update the graphics driver"
)
# What drivers that draw on the CPU call themselves, in lower case.
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "gdi generic")
# Error codes of EGL that need a word of explanation (Khronos EGL 1.5, section 3.1).
_EGL_CODES = {
    "0x3001": "EGL found no driver: libgl1-mesa-dri may be missing",
    "0x3003": "EGL could not allocate the resources of a context",
    "0x3009": "the driver offers no OpenGL 3.3 core context",
}
DEVICE_INDEX = "GLCONTEXT_DEVICE_INDEX"
_CORE_PROFILE_BIT = 1  # GL_CONTEXT_CORE_PROFILE_BIT


def draws_on_cpu(gl: moderngl.Context) -> bool:
    """Return whether the driver of a context draws on the CPU."""
    return _is_software(gl.info["GL_RENDERER"])


@cache
def _is_software(renderer: str) -> bool:
    return any(name in renderer.lower() for name in _SOFTWARE_NAMES)


class ContextError(RuntimeError):
    """No usable OpenGL: one line that says what was tried and which package helps."""


class Device:
    """An OpenGL context and what is known about it.

    Attributes
    ----------
    backend : str
        ``egl``, ``osmesa`` or ``window``.
    renderer, version, vendor : str
        As the driver names them.
    is_software : bool
        Whether pixels are drawn by the CPU.
    """

    def __init__(
        self, gl: moderngl.Context, backend: str, close: Callable[[], None] | None = None
    ) -> None:
        self.gl = gl
        self.backend = backend
        self.renderer = str(gl.info["GL_RENDERER"])
        self.version = str(gl.info["GL_VERSION"])
        self.vendor = str(gl.info["GL_VENDOR"])
        self.is_software = draws_on_cpu(gl)
        self._close = close
        self._is_released = False
        self._owner = ContextOwner()
        self._finalizer: weakref.finalize[..., Device] | None = None
        # Python may drop a texture while another context is current, in which its name
        # belongs to something else; what is dropped waits for `activate`.
        gl.gc_mode = "context_gc"

    @cached_property
    def computes(self) -> bool:
        """Whether full-screen shaders run faster as compute shaders; may be set."""
        return not self.is_software and computes_faster(self.gl)

    def destroy_when_dropped(self) -> None:
        """Let the context go with the device, should nobody call `release`."""
        self._finalizer = weakref.finalize(self, drop_context, self.gl, self._close, self._owner)
        self._finalizer.atexit = False

    def activate(self) -> None:
        """Make this context the current one, and free what was dropped meanwhile.

        Raises
        ------
        RuntimeError
            If it was released, or belongs to another thread or process.
        """
        if self._is_released:
            raise RuntimeError("this renderer was released; make another one")
        self._owner.check()
        destroy_dropped()
        self.gl.__enter__()  # type: ignore[no-untyped-call]
        if self.gl.objects:
            # A framebuffer that is freed while bound makes the next one an OpenGL error.
            self.gl.detect_framebuffer(0).use()
        # Not `gl.gc()`: it stumbles over what was released before it was dropped.
        while self.gl.objects:
            dropped = self.gl.objects.popleft()
            if hasattr(dropped, "release"):
                dropped.release()

    def release(self) -> None:
        """Destroy the context and all it holds; a second call does nothing."""
        if self._is_released:
            return
        self._owner.check()
        self._is_released = True
        if self._finalizer is not None:
            self._finalizer.detach()
        destroy_context(self.gl, self._close)


def create_context(backend: str = "auto") -> Device:
    """Return a device with an OpenGL 3.3 core context made current.

    Parameters
    ----------
    backend : str
        ``egl``, ``osmesa`` or ``window`` (hidden); ``auto`` tries them in this order.
        Where several EGL devices exist, the environment variable
        ``GLCONTEXT_DEVICE_INDEX`` chooses.

    Raises
    ------
    ContextError
        If none of them works.
    """
    makers = {"egl": _create_egl, "osmesa": _create_osmesa, "window": _create_hidden_window}
    if backend not in BACKENDS:
        raise ContextError(f"no backend is called {backend!r}: choose {', '.join(BACKENDS)}")
    try:
        note_process()
    except RuntimeError as error:
        raise ContextError(str(error)) from None
    destroy_dropped()
    leave_full_disk_alone()
    answers = []
    for name, make in makers.items():
        if backend not in ("auto", name):
            continue
        try:
            return make()
        # Whatever a missing library or a driver raises through ctypes is an answer to
        # report, and never a traceback.
        except Exception as error:
            answers.append(f"{name}: {_one_line(error)}")
            if name == "egl" and DEVICE_INDEX in os.environ:
                break  # Who asks for one GPU does not want the next best thing.
    raise ContextError(f"no usable OpenGL 3.3 core ({'; '.join(answers)}); {_ADVICE}")


def attach_to_window() -> Device:
    """Return a device for the GLFW window whose context is current; it stays the caller's.

    Raises
    ------
    ContextError
        If that context is older than OpenGL 3.3 or not a core profile.
    """
    import glfw

    try:
        return _adopt_glfw(glfw, "window", lambda: None)
    except Exception as error:
        raise ContextError(f"no usable OpenGL 3.3 core (window: {_one_line(error)})") from None


def describe(device: Device) -> dict[str, object]:
    """Return what a report should say of the device: names, backend, limits."""
    info = device.gl.info
    return {
        "renderer": device.renderer,
        "gl_version": device.version,
        "vendor": device.vendor,
        "backend": device.backend,
        "software": device.is_software,
        "full_screen": "compute shaders" if device.computes else "fragment shaders",
        "limits": {
            "texture_size": info["GL_MAX_TEXTURE_SIZE"],
            "texture_units": info["GL_MAX_TEXTURE_IMAGE_UNITS"],
            "color_attachments": info["GL_MAX_COLOR_ATTACHMENTS"],
            "uniform_components": info["GL_MAX_FRAGMENT_UNIFORM_COMPONENTS"],
        },
    }


def _create_egl() -> Device:
    for library in ("EGL", "GL"):
        # glcontext names the library that failed to load, but not which package has it.
        if find_library(library) is None:
            raise ContextError(f"lib{library} was not found")
    settings: dict[str, Any] = {"backend": "egl", "standalone": True}
    try:
        gl = moderngl.create_context(require=_COMPUTE_VERSION, **settings)
    except Exception:
        # An older driver; what else is wrong, this says again.
        gl = moderngl.create_context(require=_REQUIRED_VERSION, **settings)
    return _checked(gl, "egl", None)


def _create_osmesa() -> Device:
    if find_library("OSMesa") is None:
        raise ContextError("libOSMesa was not found")
    import glfw

    # GLFW's null platform has no display at all, yet makes OSMesa contexts.
    # OSMesa refuses the forward-compatible flag that macOS windows need.
    hints = {
        glfw.CONTEXT_CREATION_API: glfw.OSMESA_CONTEXT_API,
        glfw.OPENGL_FORWARD_COMPAT: glfw.FALSE,
    }
    return _create_with_glfw(glfw, "osmesa", glfw.PLATFORM_NULL, hints)


def _create_hidden_window() -> Device:
    import glfw

    return _create_with_glfw(glfw, "window", glfw.ANY_PLATFORM, {})


def _create_with_glfw(
    glfw: ModuleType, backend: str, platform: int, hints: dict[int, int]
) -> Device:
    """Return a device whose context belongs to an invisible GLFW window."""
    with errors_of(glfw) as errors:
        GLFW_USE.begin(glfw, platform, errors)

        def close() -> None:
            if window:
                glfw.destroy_window(window)
            GLFW_USE.end(glfw)

        glfw.default_window_hints()
        required = {
            glfw.VISIBLE: glfw.FALSE,
            glfw.CONTEXT_VERSION_MAJOR: 3,
            glfw.CONTEXT_VERSION_MINOR: 3,
            glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE,
            glfw.OPENGL_FORWARD_COMPAT: glfw.TRUE,
        }
        for hint, value in {**required, **hints}.items():
            glfw.window_hint(hint, value)
        # The size is of no use: everything is drawn into framebuffers of our own.
        window = glfw.create_window(16, 16, "ssdo_gl", None, None)
        try:
            if not window:
                raise ContextError("; ".join(errors) or "GLFW makes no window")
            glfw.make_context_current(window)
            return _adopt_glfw(glfw, backend, close)
        except Exception:
            close()
            raise


def _adopt_glfw(glfw: ModuleType, backend: str, close: Callable[[], None]) -> Device:
    settings: dict[str, Any] = {"context": GlfwLoader(glfw)}
    gl = moderngl.create_context(require=_REQUIRED_VERSION, **settings)
    return _checked(gl, backend, close)


def _checked(gl: moderngl.Context, backend: str, close: Callable[[], None] | None) -> Device:
    """Return the device, or raise if its context is no core profile."""
    if not gl.info["GL_CONTEXT_PROFILE_MASK"] & _CORE_PROFILE_BIT:
        version = gl.info["GL_VERSION"]
        gl.release()
        raise ContextError(f"OpenGL {version} is not a core profile")
    device = Device(gl, backend, close)
    device.destroy_when_dropped()
    return device


def _one_line(error: BaseException) -> str:
    """Return the message without line breaks, with EGL's codes in words."""
    text = " ".join(str(error).split()) or type(error).__name__
    for code, meaning in _EGL_CODES.items():
        if code in text:
            return f"{meaning} ({text})"
    if "found 0 devices" in text:
        return f"EGL found no device: libgl1-mesa-dri may be missing ({text})"
    return text
