"""The page and its websocket: what comes over the network, checked, to and from the renderer."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import secrets
import struct
import time
from collections.abc import Awaitable, Callable, Mapping
from importlib.resources import files
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web
from aiohttp.http_exceptions import HttpProcessingError

from ssdo_gl.serve.access import Access
from ssdo_gl.serve.delivery import SentPicture
from ssdo_gl.serve.page_events import PageEventError, pixels_of, read_event
from ssdo_gl.serve.render_thread import MOST_EVENTS, Delivered, RenderThread, Visitor

MOST_VISITORS = 32
# The longest event is one of a key, of about 100 bytes.
MAX_MESSAGE_BYTES = 1024
# A viewer whose line is dead is noticed, and freed, after one and a half of these.
HEARTBEAT_SECONDS = 20.0
_FILES = {"": "index.html"} | {name: name for name in ("mouse.js", "page.js", "page.css")}
_TYPES = {"html": "text/html", "js": "text/javascript", "css": "text/css"}
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'",
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
# Who says nothing for so long takes the place of somebody who would look.
FIRST_EVENT_SECONDS = 10.0
_IS_LOSSLESS = 1
# Faults of this program are logged; a request that is no HTTP is one of somebody else.
_LOG = logging.getLogger(__name__)
_LOG.addFilter(lambda r: not (r.exc_info and isinstance(r.exc_info[1], HttpProcessingError)))
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def picture_message(picture: SentPicture) -> bytes:
    """Return a picture as the page takes it: number, flags, and the file."""
    flags = _IS_LOSSLESS if picture.is_lossless else 0
    return struct.pack(">II", picture.number, flags) + picture.data


class Outbox:
    """What is to be sent to one viewer: of states only the latest, of pictures those in flight."""

    def __init__(self) -> None:
        self._items: dict[object, Delivered] = {}
        self._is_filled = asyncio.Event()

    def put(self, item: Delivered) -> None:
        """Add an item behind all others; an earlier state goes."""
        key = item.number if isinstance(item, SentPicture) else item and item["type"]
        self._items.pop(key, None)
        self._items[key] = item
        self._is_filled.set()

    async def take(self) -> Delivered:
        """Return the first item, once there is one."""
        while not self._items:
            self._is_filled.clear()
            await self._is_filled.wait()
        return self._items.pop(next(iter(self._items)))


class Server:
    """Serves the page of a renderer.

    Parameters
    ----------
    renderer : RenderThread
        Started.
    host : str
        What to listen at.
    has_token : bool
        Whether the address holds a secret, without which nothing is answered.
    """

    def __init__(self, renderer: RenderThread, host: str, *, has_token: bool = False) -> None:
        token = secrets.token_urlsafe(16) if has_token else ""
        self._renderer = renderer
        self._host = host
        self._access = Access(host, token)
        self._sockets: set[web.WebSocketResponse] = set()
        # Names of the page's files are relative: the token is in front of all of them.
        self._root = f"/{token}/" if token else "/"
        self.app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE_BYTES)
        self.app.router.add_get(f"{self._root}socket", self._socket)
        for path in _FILES:
            self.app.router.add_get(f"{self._root}{path}", self._file)
        self.app.on_shutdown.append(self._close_sockets)

    def address(self, port: int) -> str:
        """Return what one types into a browser."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{port}{self._root}"

    @web.middleware
    async def _guard(self, request: web.Request, handler: _Handler) -> web.StreamResponse:
        origin = request.headers.get("Origin")
        refusal = self._access.refusal(request.headers.get("Host", ""), origin, request.path)
        if refusal:
            return web.Response(status=403, text=f"{refusal}\n", headers=_HEADERS)
        try:
            response = await handler(request)
        except web.HTTPException as error:
            error.headers.update(_HEADERS)
            raise
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    async def _file(self, request: web.Request) -> web.Response:
        name = _FILES[request.path.removeprefix(self._root)]
        text = files("ssdo_gl.serve").joinpath("page", name).read_text(encoding="utf-8")
        return web.Response(text=text, content_type=_TYPES[name.rpartition(".")[2]])

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if len(self._sockets) >= MOST_VISITORS:
            return web.Response(status=503, text=f"{MOST_VISITORS} look already\n")
        socket = web.WebSocketResponse(
            max_msg_size=MAX_MESSAGE_BYTES, heartbeat=HEARTBEAT_SECONDS, compress=False
        )
        # Before anything waits: two that come at once are two.
        self._sockets.add(socket)
        try:
            await socket.prepare(request)
            await self._converse(socket)
        finally:
            self._sockets.discard(socket)
        return socket

    async def _converse(self, socket: web.WebSocketResponse) -> None:
        loop = asyncio.get_running_loop()
        outbox = Outbox()

        def deliver(item: Delivered) -> None:
            # The loop may have ended while a frame was drawn.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(outbox.put, item)

        visitor = Visitor(deliver)
        sending = asyncio.create_task(_send(socket, outbox))
        try:
            await self._listen(socket, visitor)
        finally:
            self._renderer.leave(visitor)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    async def _listen(self, socket: web.WebSocketResponse, visitor: Visitor) -> None:
        has_entered = False
        silent = asyncio.get_running_loop().call_later(
            FIRST_EVENT_SECONDS, lambda: asyncio.ensure_future(socket.close())
        )
        async for message in socket:
            silent.cancel()
            try:
                if message.type is not WSMsgType.TEXT:
                    raise PageEventError("a message is text")
                event = read_event(message.data)
                if not has_entered:
                    self._enter(visitor, event)
                    has_entered = True
                visitor.events.append({**event, "at": time.perf_counter()})
            except PageEventError as error:
                reason = str(error).encode()[:100]
                await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=reason)
                return
            if len(visitor.events) > MOST_EVENTS:
                await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"too many events")
                return
            self._renderer.wake()

    def _enter(self, visitor: Visitor, event: Mapping[str, Any]) -> None:
        """Begin with a picture as large as the page, which says that first."""
        if event["type"] != "size":
            raise PageEventError("the first event is one of size")
        self._renderer.enter(visitor, pixels_of(event))

    async def _close_sockets(self, app: web.Application) -> None:
        for socket in list(self._sockets):
            await socket.close(code=WSCloseCode.GOING_AWAY, message=b"the server has ended")


async def _send(socket: web.WebSocketResponse, outbox: Outbox) -> None:
    """Send what is delivered, in its order, for as long as somebody takes it."""
    while True:
        item = await outbox.take()
        try:
            if item is None:
                await socket.close(code=WSCloseCode.INTERNAL_ERROR, message=b"cannot be drawn")
                return
            if isinstance(item, SentPicture):
                await socket.send_bytes(picture_message(item))
            else:
                await socket.send_str(json.dumps(item, allow_nan=False))
        except (ConnectionError, RuntimeError):
            return  # they have left


async def run_server(
    renderer: RenderThread, host: str | None, port: int, say: Callable[[str], None]
) -> None:
    """Serve until cancelled; `say` is told the address once somebody may come.

    Raises
    ------
    OSError
        If host and port cannot be listened at.
    """
    listens_at = host or "127.0.0.1"
    server = Server(renderer, listens_at, has_token=host is not None)
    runner = web.AppRunner(server.app, access_log=None, logger=_LOG, shutdown_timeout=2.0)
    await runner.setup()
    try:
        await web.TCPSite(runner, listens_at, port).start()
        say(server.address(runner.addresses[0][1]))
        await asyncio.Event().wait()
    finally:
        await runner.cleanup()
