"""Which thread and process a context belongs to, and what becomes of it when it is dropped."""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Callable

import moderngl

_FORKED = (
    "OpenGL was in use before this process was forked, and its driver does not work here:"
    " start processes with multiprocessing's 'spawn' method"
)


class ContextOwner:
    """The thread and process that have made a context.

    In another thread the context is not current, and the driver does nothing: images are
    what memory held before. In a forked process the driver waits for threads that are not
    there.
    """

    def __init__(self) -> None:
        self._thread = threading.current_thread()
        self._process = os.getpid()

    @property
    def is_forked(self) -> bool:
        """Whether this process is a fork of the one that has made the context."""
        return self._process != os.getpid()

    @property
    def is_here(self) -> bool:
        """Whether the context works here."""
        return self._thread is threading.current_thread() and not self.is_forked

    def check(self) -> None:
        """Raise RuntimeError where the context does not work."""
        if self.is_forked:
            raise RuntimeError(_FORKED)
        if not self.is_here:
            raise RuntimeError(
                f"this renderer belongs to thread {self._thread.name!r} and is used in"
                f" {threading.current_thread().name!r}: make one in each thread"
            )


# Contexts that were dropped where they could not be destroyed.
_dropped: list[tuple[moderngl.Context, Callable[[], None] | None, ContextOwner]] = []
_first_process: int | None = None


def note_process() -> None:
    """Note which process uses OpenGL; raise RuntimeError in a fork of it."""
    global _first_process
    if _first_process not in (None, os.getpid()):
        raise RuntimeError(_FORKED)
    _first_process = os.getpid()


def drop_context(
    gl: moderngl.Context, close: Callable[[], None] | None, owner: ContextOwner
) -> None:
    """Note that a device was dropped; its context is destroyed when its thread comes by.

    Not now: objects are dropped at any moment, and another context may be at work.
    """
    if owner.is_forked:
        return
    _dropped.append((gl, close, owner))
    warnings.warn(
        "a renderer was dropped without release(); use `with Renderer(...)`",
        ResourceWarning,
        stacklevel=2,
    )


def destroy_dropped() -> None:
    """Destroy what was dropped and belongs to this thread."""
    for item in [item for item in _dropped if item[2].is_here]:
        _dropped.remove(item)
        # What a context holds is freed in whichever one is current.
        item[0].__enter__()  # type: ignore[no-untyped-call]
        destroy_context(*item[:2])


def destroy_context(gl: moderngl.Context, close: Callable[[], None] | None) -> None:
    """Destroy a context and all it holds."""
    # Objects that outlive the context must not call into it when they are dropped.
    gl.gc_mode = None  # type: ignore[assignment]
    gl.release()
    if close is not None:
        close()
