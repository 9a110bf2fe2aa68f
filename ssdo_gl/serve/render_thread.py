"""The thread that owns the OpenGL context and draws for all viewers, one after another."""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.process import give_back_memory
from ssdo_gl.scene.camera import Camera
from ssdo_gl.serve.delivery import SentPicture
from ssdo_gl.serve.page_state import choices
from ssdo_gl.serve.remote_session import RemoteSession
from ssdo_gl.window.camera import Flight
from ssdo_gl.window.opening import fault_text
from ssdo_gl.window.viewer import Viewer

# How often lines that have been shown long enough are looked for.
IDLE_SECONDS = 0.5
# Between looks while somebody moves, but nothing is to be drawn yet.
PAUSE_SECONDS = 0.004
# What refines at rest waits no longer than this for those who move.
PATIENCE_SECONDS = 2.0
# The time of a frame is divided among those who move, down to this part of it: with more of
# them pictures become fewer, not coarser.
SMALLEST_SHARE = 0.25
# Events of one viewer that were not looked at yet; a hand and a mouse send 1000 a second.
MOST_EVENTS = 4096

# A picture, a message for the page (with its ``type``), or None: nothing comes any more.
Delivered = SentPicture | Mapping[str, Any] | None


class Visitor:
    """One who looks: their events on the way in, pictures and states on the way out.

    Parameters
    ----------
    deliver : callable
        Called in the thread that renders; returns at once.

    Attributes
    ----------
    events : deque
        Events as `page_events.checked_event` returns them; any thread may append.
    session : RemoteSession or None
        None until the thread has made one.
    shared : Camera or None
        Where the camera was that others were told of last; None: it is not shared.
    """

    def __init__(self, deliver: Callable[[Delivered], None]) -> None:
        self.deliver = deliver
        self.events: deque[Mapping[str, Any]] = deque()
        self.session: RemoteSession | None = None
        self.shared: Camera | None = None
        self.drawn_at = 0.0
        self.budget_ms = 0.0
        self._state: Mapping[str, Any] | None = None

    @property
    def is_moving(self) -> bool:
        """Whether a picture in motion is due: not for one who has not taken the last ones."""
        session = self.session
        return session is not None and session.is_due and session.is_moving

    def hear(self) -> None:
        """Let the session take what has come."""
        assert self.session is not None
        while self.events:
            self.session.handle(self.events.popleft())

    def tell(self) -> None:
        """Deliver the state if it is another one."""
        assert self.session is not None
        state = self.session.state
        clipboard = self.session.take_clipboard()
        if clipboard:
            self.deliver({"type": "clipboard", "text": clipboard})
        if state != self._state:
            self._state = state
            self.deliver({"type": "state", **state})


def _carried_out(task: Callable[[], None]) -> None:
    """Do what one viewer needs; its fault must not end the thread, which all others need."""
    try:
        task()
    except Exception as error:
        print(f"ssdo-gl: of a viewer: {fault_text(error)}", file=sys.stderr)


class RenderThread:
    """Makes the device, and draws for everybody who visits until it is stopped.

    Parameters
    ----------
    make_viewer : callable
        Returns a viewer that draws with a device and its shaders.
    backend : str
        auto, egl, osmesa or window.
    shares_camera : bool
        Whether everybody begins with one camera for all who share it.
    """

    def __init__(
        self,
        make_viewer: Callable[[Device, ShaderLibrary], Viewer],
        backend: str = "auto",
        *,
        shares_camera: bool = False,
    ) -> None:
        self._make_viewer = make_viewer
        self._backend = backend
        self._shares_camera = shares_camera
        # Where those who share a camera have moved it.
        self._flight: Flight | None = None
        self._visitors: list[Visitor] = []
        self._tasks: deque[Callable[[], None]] = deque()
        self._wakes = threading.Event()
        self._is_stopping = False
        self._ready: Future[None] = Future()
        self._thread = threading.Thread(target=self._run, name="rendering", daemon=True)

    def start(self) -> None:
        """Return when the device is there; raises ContextError if there is none."""
        try:
            self._thread.start()
            self._ready.result()
        except BaseException:  # Ctrl-C, too, while the device is made
            self.stop()
            raise

    def stop(self) -> None:
        """Free everything and end the thread."""
        self._is_stopping = True
        self._wakes.set()
        if self._thread.is_alive():  # not where Ctrl-C came before it began
            self._thread.join()

    def enter(self, visitor: Visitor, size: tuple[int, int]) -> None:
        """Begin to draw for `visitor`, in pictures of `size` pixels."""
        self._post(partial(self._enter, visitor, size))

    def leave(self, visitor: Visitor) -> None:
        """Free what a visitor held; one who has left already may leave."""
        self._post(partial(self._leave, visitor))

    def wake(self) -> None:
        """Look at events: some have come."""
        self._wakes.set()

    def _post(self, task: Callable[[], None]) -> None:
        self._tasks.append(task)
        self._wakes.set()

    # --- in the thread -------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._device = create_context(self._backend)
            self._shaders = ShaderLibrary(self._device.gl, computes=self._device.computes)
        except BaseException as error:
            self._ready.set_exception(error)
            return
        self._ready.set_result(None)
        try:
            while not self._is_stopping:
                self._wakes.clear()
                while self._tasks:
                    _carried_out(self._tasks.popleft())
                if not self._round():
                    is_moving = any(visitor.is_moving for visitor in self._visitors)
                    self._wakes.wait(PAUSE_SECONDS if is_moving else IDLE_SECONDS)
        finally:
            for visitor in list(self._visitors):
                self._leave(visitor)
            self._device.release()

    def _enter(self, visitor: Visitor, size: tuple[int, int]) -> None:
        try:
            viewer = self._make_viewer(self._device, self._shaders)
        # One who cannot be drawn for must not take the others along.
        except Exception as error:
            self._lose(visitor, error)
            return
        visitor.session = RemoteSession(viewer, size)
        visitor.session.shares_camera = self._shares_camera
        visitor.session.between_slices = lambda: self._others_wait(visitor)
        visitor.drawn_at = time.perf_counter()
        visitor.budget_ms = viewer.budget_ms
        self._visitors.append(visitor)
        self._share_camera(visitor)
        visitor.deliver({"type": "choices", **choices(viewer)})

    def _leave(self, visitor: Visitor) -> None:
        if visitor in self._visitors:
            self._visitors.remove(visitor)
        session, visitor.session = visitor.session, None
        if session is not None:
            self._device.activate()
            session.release()
            # Now, and not with the next picture, which may be long in coming.
            self._device.activate()
            if not self._visitors:
                give_back_memory()

    def _lose(self, visitor: Visitor, error: Exception) -> None:
        print(f"ssdo-gl: a viewer was lost: {fault_text(error)}", file=sys.stderr)
        self._leave(visitor)
        visitor.deliver(None)

    def _round(self) -> bool:
        """Draw what is due, motion before rest; return whether there was anything."""
        now = time.perf_counter()
        for visitor in list(self._visitors):
            self._guarded(visitor, visitor.hear)
        self._divide_time()
        due = [v for v in self._visitors if v.session is not None and v.session.is_due]
        moving = [v for v in due if v.is_moving]
        resting = [v for v in due if v not in moving]
        resting = [v for v in resting if not moving or now - v.drawn_at > PATIENCE_SECONDS]
        drew = False
        # Of those at rest only who has waited longest: somebody may begin to move meanwhile.
        # Who leads, before those who follow.
        moving.sort(key=lambda v: v.session is not None and not v.session.has_input)
        for visitor in [*moving, *sorted(resting, key=lambda v: v.drawn_at)[:1]]:
            drew |= self._guarded(visitor, partial(self._step, visitor))
        for visitor in list(self._visitors):
            self._guarded(visitor, visitor.tell)
        return drew

    def _step(self, visitor: Visitor) -> bool:
        assert visitor.session is not None
        count = visitor.session.viewer.presenter.draw_count
        visitor.session.perform()
        self._share_camera(visitor)
        visitor.tell()
        picture = visitor.session.step()
        self._share_camera(visitor)
        is_new = visitor.session.viewer.presenter.draw_count != count
        if is_new:
            visitor.drawn_at = time.perf_counter()
        if picture is not None:
            visitor.tell()
            visitor.deliver(picture)
        return is_new or picture is not None

    def _divide_time(self) -> None:
        sessions = [(v, v.session) for v in self._visitors if v.session is not None]
        share = 1.0 / max(1, sum(session.is_moving for _, session in sessions))
        for visitor, session in sessions:
            session.viewer.budget_ms = visitor.budget_ms * max(share, SMALLEST_SHARE)

    def _share_camera(self, visitor: Visitor) -> None:
        """Take over a shared camera on joining; tell the others where it was moved since."""
        session = visitor.session
        if session is None or not session.shares_camera:
            visitor.shared = None
            return
        if visitor.shared is None and self._flight is not None:
            session.follow(self._flight)
        elif session.viewer.camera != visitor.shared:
            self._flight = session.still_flight
            for other in self._visitors:
                if other is not visitor and other.session is not None and other.shared is not None:
                    other.session.follow(self._flight)
                    other.shared = other.session.viewer.camera
        visitor.shared = session.viewer.camera

    def _guarded(self, visitor: Visitor, act: Callable[[], bool | None]) -> bool:
        try:
            return bool(act())
        except Exception as error:
            # Between frames: this may be within one of somebody else.
            self._post(partial(self._lose, visitor, error))
            return False

    def _others_wait(self, visitor: Visitor) -> bool:
        """Hear of events within a long frame; return whether it is to be given up for others."""
        for other in list(self._visitors):
            self._guarded(other, other.hear)
        if self._is_stopping:
            return True
        is_patient = time.perf_counter() - visitor.drawn_at < PATIENCE_SECONDS
        others = [other for other in self._visitors if other is not visitor]
        return is_patient and (bool(self._tasks) or any(other.is_moving for other in others))
