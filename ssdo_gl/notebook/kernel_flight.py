"""A fly-through that a kernel draws for the pages of a widget."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from ssdo_gl.gpu.context import ContextError, Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.serve.delivery import SentPicture
from ssdo_gl.serve.page_events import PageEventError, checked_event
from ssdo_gl.serve.render_thread import MOST_EVENTS, Delivered, RenderThread, Visitor
from ssdo_gl.settings import Settings
from ssdo_gl.window.viewer import Viewer

Send = Callable[[Mapping[str, Any], list[bytes]], None]


class KernelFlight:
    """Draws in a thread with a device of its own while any page shows the widget.

    Parameters
    ----------
    camera : Camera
        Where it begins.
    size : (int, int)
        Of pictures until a page says another one, pixels.
    send : callable
        Takes a message for the pages, and files that belong to it.
    source : str
        What copied commands call the scene.
    backend : str
        auto, egl, osmesa or window.
    """

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        camera: Camera,
        size: tuple[int, int],
        send: Send,
        *,
        source: str,
        backend: str = "auto",
    ) -> None:
        self._scene, self._settings, self._camera = scene, settings, camera
        self._size, self._send = size, send
        self._source, self._backend = source, backend
        self._pages: set[str] = set()
        self._thread: RenderThread | None = None
        self._visitor: Visitor | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def is_running(self) -> bool:
        """Whether it draws."""
        return self._thread is not None

    @property
    def camera(self) -> Camera:
        """Where one has flown to."""
        session = None if self._visitor is None else self._visitor.session
        if session is not None:
            self._camera = session.viewer.camera
        return self._camera

    def hear(self, content: Any) -> None:
        """Take what a page says: an event of `page_events`, or that it opens or closes."""
        kind = content.get("type") if isinstance(content, dict) else None
        if kind == "open":
            self._pages.add(str(content.get("page")))
            self._start()
        elif kind == "close":
            self._pages.discard(str(content.get("page")))
            if not self._pages:
                self.stop()
        elif self._visitor is not None and self._thread is not None:
            try:
                event = checked_event(content)
            except PageEventError as error:
                self._send({"type": "fault", "text": str(error)}, [])
                return
            if len(self._visitor.events) < MOST_EVENTS:
                self._visitor.events.append(event)
                self._thread.wake()

    def stop(self) -> None:
        """Free the device; a page that opens begins again where one was."""
        self._camera = self.camera
        thread, self._thread, self._visitor = self._thread, None, None
        if thread is not None:
            thread.stop()

    def _start(self) -> None:
        try:
            self._loop = asyncio.get_running_loop()
        except RuntimeError:
            self._loop = None
        # A further page has to be told everything: all begin anew.
        self.stop()
        thread = RenderThread(self._make_viewer, self._backend)
        try:
            thread.start()
        except ContextError as error:
            self._send({"type": "fault", "text": str(error)}, [])
            return
        self._thread, self._visitor = thread, Visitor(self._deliver)
        thread.enter(self._visitor, self._size)

    def _make_viewer(self, device: Device, shaders: ShaderLibrary) -> Viewer:
        return Viewer(
            device,
            self._scene,
            self._settings,
            shaders=shaders,
            camera=self._camera,
            source=self._source,
        )

    def _deliver(self, item: Delivered) -> None:
        """Hand something to the kernel's thread: not every kernel lets others send."""
        if self._loop is None:
            self._tell(item)
        elif not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._tell, item)

    def _tell(self, item: Delivered) -> None:
        if isinstance(item, SentPicture):
            message = {"type": "picture", "frame": item.number, "lossless": item.is_lossless}
            self._send(message, [item.data])
        elif item is None:
            self._send({"type": "fault", "text": "drawing has ended: run the cell again"}, [])
        else:
            self._send(item, [])
