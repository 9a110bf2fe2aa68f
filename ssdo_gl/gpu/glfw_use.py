"""GLFW as a maker of contexts: kept initialised, asked for functions and for its messages."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType


class GlfwUse:
    """Keeps GLFW initialised for as long as one of our windows lives.

    GLFW is one per process: terminating it destroys every window, other people's too.
    """

    def __init__(self) -> None:
        self._window_count = 0
        self._is_ours = False

    def begin(self, glfw: ModuleType, platform: int, errors: list[str]) -> None:
        """Initialise GLFW for one more window on `platform`.

        Raises
        ------
        RuntimeError
            Saying why it cannot be.
        """
        current = glfw.get_platform()
        errors.clear()  # Asking before initialisation is an error to GLFW, not to us.
        if not current:
            glfw.init_hint(glfw.PLATFORM, platform)
            if not glfw.init():
                raise RuntimeError("; ".join(errors) or "GLFW does not initialise")
            self._is_ours = True
        elif (current == glfw.PLATFORM_NULL) != (platform == glfw.PLATFORM_NULL):
            kind = "without" if current == glfw.PLATFORM_NULL else "with"
            raise RuntimeError(f"GLFW is already in use {kind} a display in this process")
        self._window_count += 1

    def end(self, glfw: ModuleType) -> None:
        """Terminate GLFW with the last of our windows, if nobody else initialised it."""
        self._window_count -= 1
        if self._is_ours and self._window_count == 0:
            self._is_ours = False
            glfw.terminate()


GLFW_USE = GlfwUse()


class GlfwLoader:
    """What moderngl asks for functions when the context was made by GLFW.

    Its own way of finding a context knows X11 and EGL only.
    """

    def __init__(self, glfw: ModuleType) -> None:
        self._glfw = glfw
        self._window = glfw.get_current_context()

    def load_opengl_function(self, name: str) -> int:
        return int(self._glfw.get_proc_address(name) or 0)

    load = load_opengl_function

    def release(self) -> None:
        """Do nothing: the window owns the context."""

    def __enter__(self) -> None:
        """Make the window's context current."""
        self._glfw.make_context_current(self._window)

    def __exit__(self, *fault: object) -> None:
        """Do nothing."""


@contextmanager
def errors_of(glfw: ModuleType) -> Iterator[list[str]]:
    """Collect GLFW's messages, which it would otherwise issue as warnings."""
    errors: list[str] = []

    def collect(code: int, message: bytes) -> None:
        errors.append(message.decode("utf-8", "replace"))

    previous = glfw.set_error_callback(collect)
    try:
        yield errors
    finally:
        glfw.set_error_callback(previous)
