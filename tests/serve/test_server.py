"""The server: page, websocket, and those who mean no good."""

from __future__ import annotations

import asyncio
import io
import json
import struct
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from aiohttp.test_utils import TestClient, TestServer
from PIL import Image as PillowImage

from ssdo_gl.gpu.context import ContextError
from ssdo_gl.scene.load import load_scene
from ssdo_gl.serve import render_thread
from ssdo_gl.serve import server as server_module
from ssdo_gl.serve.delivery import MOST_IN_FLIGHT
from ssdo_gl.serve.render_thread import RenderThread
from ssdo_gl.serve.server import MAX_MESSAGE_BYTES, Outbox, Server
from ssdo_gl.settings import Settings
from ssdo_gl.window.viewer import Viewer

aiohttp = pytest.importorskip("aiohttp")


PATIENCE_S = 120.0
SIZE = {"type": "size", "width": 48, "height": 27, "scale": 1}


@pytest.fixture(scope="module")
def renderer(request: pytest.FixtureRequest) -> Iterator[RenderThread]:
    scene, faults = load_scene("corner"), []

    def make(device: Any, shaders: Any) -> Any:
        if faults:
            raise faults.pop()
        settings = Settings(samples=4, steps=2, method="ssao")
        return Viewer(device, scene, settings, shaders=shaders, source="corner")

    thread = RenderThread(make, request.config.getoption("--backend"))
    thread.start()
    thread.faults = faults  # type: ignore[attr-defined]
    yield thread
    thread.stop()


def with_client(
    renderer: RenderThread, act: Callable[..., Awaitable[None]], *, has_token: bool = False
) -> None:
    """Run `act` with a client of a server of its own."""

    async def run() -> None:
        idle: Future[None] = Future()
        renderer._post(partial(idle.set_result, None))
        await asyncio.wrap_future(idle)
        server = Server(renderer, "127.0.0.1", has_token=has_token)
        async with asyncio.timeout(PATIENCE_S), TestClient(TestServer(server.app)) as client:
            client.root = server.address(0).split("/", 3)[3]
            await act(client)

    asyncio.run(run())


async def visit(client: Any) -> Any:
    """Return a websocket that has said how large its page is."""
    socket = await client.ws_connect(f"/{client.root}socket")
    await socket.send_json(SIZE)
    return socket


async def look(socket: Any, *, answers: bool = True, until_rest: bool = True) -> SimpleNamespace:
    """Hear what comes until the picture is at rest, or the first one."""
    seen = SimpleNamespace(pictures=[], lossless=[], states=[], choices=None)
    while True:
        message = await socket.receive()
        if message.type is aiohttp.WSMsgType.TEXT:
            heard = json.loads(message.data)
            if heard["type"] == "choices":
                seen.choices = heard
            else:
                seen.states.append(heard)
            continue
        assert message.type is aiohttp.WSMsgType.BINARY, message
        number, flags = struct.unpack(">II", message.data[:8])
        seen.pictures.append(np.asarray(PillowImage.open(io.BytesIO(message.data[8:]))))
        seen.lossless.append(bool(flags))
        if answers:
            await socket.send_json({"type": "ack", "frame": number})
        if flags or not until_rest:
            return seen


def test_page_comes_with_its_files_and_may_load_nothing_else(renderer):
    async def act(client):
        for path, kind in (
            ("/", "text/html"),
            ("/mouse.js", "text/javascript"),
            ("/page.js", "text/javascript"),
            ("/page.css", "text/css"),
        ):
            answer = await client.get(path)
            assert answer.status == 200 and answer.content_type == kind
            assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
            assert len(await answer.text()) > 500
        for path in ("/../pyproject.toml", "/page/page.js", "/%2e%2e/server.py", "/socket"):
            assert (await client.get(path)).status in (400, 404)

    with_client(renderer, act)


def test_page_counts_pixels_as_the_server_does(renderer):
    from ssdo_gl.serve.page_events import MAX_PIXELS, MAX_SIDE_PX

    page = Path(server_module.__file__).parent / "page"
    text = (page / "mouse.js").read_text() + (page / "page.js").read_text()
    assert f"const MAX_SIDE_PX = {MAX_SIDE_PX};" in text
    assert "const MAX_PIXELS = 3840 * 2160;" in text and MAX_PIXELS == 3840 * 2160


def test_viewer_sees_the_scene_and_moves_in_it(renderer):
    async def act(client):
        socket = await visit(client)
        seen = await look(socket)
        assert "gi" in seen.choices["methods"] and "depth" in seen.choices["aovs"]
        assert seen.pictures[-1].shape == (27, 48, 3) and seen.pictures[-1].std() > 10
        assert seen.lossless == [False] * (len(seen.lossless) - 1) + [True]
        assert seen.states[-1]["resting"] and seen.states[-1]["method"] == "ssao"
        await socket.send_json({"type": "choose", "what": "aov", "value": "depth"})
        other = await look(socket)
        assert other.states[-1]["aov"] == "depth"
        assert np.abs(other.pictures[-1].astype(int) - seen.pictures[-1]).mean() > 5
        await socket.close()

    with_client(renderer, act)


def test_each_viewer_has_a_camera_of_their_own(renderer):
    async def act(client):
        first, second = await visit(client), await visit(client)
        before = (await look(first)).pictures[-1]
        assert np.array_equal((await look(second)).pictures[-1], before)
        for down in (True, False):
            await first.send_json(key("ArrowLeft", down=down))
        assert not np.array_equal((await look(first)).pictures[-1], before)
        cameras = [visitor.session.viewer.camera for visitor in renderer._visitors]
        assert len(cameras) == 2 and cameras[1] == load_scene("corner").camera != cameras[0]
        await first.close()
        await second.close()

    with_client(renderer, act)


def key(code: str, *, down: bool) -> dict[str, Any]:
    return {"type": "key", "code": code, "down": down, "repeat": False, "mods": 0}


def test_who_shares_a_camera_sees_where_others_have_gone(renderer, monkeypatch):
    monkeypatch.setattr(renderer, "_shares_camera", True)
    home = load_scene("corner").camera

    async def act(client):
        first, second = await visit(client), await visit(client)
        for socket in (first, second):
            assert (await look(socket)).states[-1]["shared_camera"]
        for down in (True, False):
            await first.send_json(key("ArrowLeft", down=down))
        moved = [(await look(socket)).pictures[-1] for socket in (first, second)]
        assert np.array_equal(*moved)
        third = await visit(client)
        assert np.array_equal((await look(third)).pictures[-1], moved[0])
        cameras = [visitor.session.viewer.camera for visitor in renderer._visitors]
        assert cameras == [cameras[0]] * 3 and cameras[0] != home
        # One goes a way of their own, and comes back to the others.
        await second.send_json({"type": "choose", "what": "shared_camera", "value": False})
        await second.send_json(key("Home", down=True))
        assert np.abs((await look(second)).pictures[-1].astype(int) - moved[1]).max() > 0
        assert [v.session.viewer.camera == cameras[0] for v in renderer._visitors] == [1, 0, 1]
        await second.send_json({"type": "choose", "what": "shared_camera", "value": True})
        assert np.array_equal((await look(second)).pictures[-1], moved[0])
        for socket in (first, second, third):
            await socket.close()

    with_client(renderer, act)
    renderer._flight = None


def test_who_moves_shares_the_time_of_a_frame(renderer):
    async def act(client):
        first, second = await visit(client), await visit(client)
        for socket in (first, second):
            await look(socket)
        viewers = [visitor.session.viewer for visitor in renderer._visitors]
        whole = renderer._visitors[0].budget_ms
        for socket in (first, second):
            await socket.send_json(key("ArrowLeft", down=True))
        while [viewer.budget_ms for viewer in viewers] != [0.5 * whole] * 2:
            await asyncio.gather(*(look(s, until_rest=False) for s in (first, second)))
        for socket in (first, second):
            await socket.send_json(key("ArrowLeft", down=False))
            await look(socket)
        while viewers[0].budget_ms != whole:
            await asyncio.sleep(0.01)
        await first.close()
        await second.close()

    with_client(renderer, act)


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("garbage", 1008),
        (b"\x00\x01", 1008),
        ('{"type": "cursor", "x": 1, "y": 1}', 1008),
        (json.dumps({**SIZE, "width": 8000, "height": 8000}), 1008),
        (json.dumps({**SIZE, "width": 10**400}), 1008),
        ("x" * (MAX_MESSAGE_BYTES + 1), 1009),
    ],
)
def test_who_sends_garbage_is_sent_away_and_nobody_else(renderer, message, code):
    async def act(client):
        good = await visit(client)
        await look(good, until_rest=False)
        bad = await client.ws_connect("/socket")
        send = bad.send_bytes if isinstance(message, bytes) else bad.send_str
        await send(message)
        assert (await bad.receive()).type is aiohttp.WSMsgType.CLOSE and bad.close_code == code
        assert (await look(good)).lossless[-1]
        await good.close()

    with_client(renderer, act)


def test_who_says_nothing_takes_nobodys_place(renderer, monkeypatch):
    monkeypatch.setattr(server_module, "FIRST_EVENT_SECONDS", 0.05)

    async def act(client):
        silent = await client.ws_connect("/socket")
        assert (await silent.receive()).type is aiohttp.WSMsgType.CLOSE
        good = await visit(client)
        assert (await look(good)).lossless[-1]
        await good.close()

    with_client(renderer, act)


def test_slow_reader_holds_two_pictures_and_nobody_up(renderer):
    async def act(client):
        slow = await visit(client)
        await look(slow, answers=False, until_rest=False)
        for _ in range(20):
            await slow.send_json({"type": "wheel", "notches": 0.1})
        good = await visit(client)
        assert (await look(good)).lossless[-1]
        delivery = renderer._visitors[0].session._delivery
        assert delivery._number == MOST_IN_FLIGHT and not delivery.has_room
        await good.close()
        await slow.close()

    with_client(renderer, act)


def test_who_leaves_frees_what_they_held(renderer, monkeypatch):
    given_back = []
    monkeypatch.setattr(render_thread, "give_back_memory", lambda: given_back.append(1))

    async def act(client):
        socket = await visit(client)
        await look(socket)
        (visitor,) = renderer._visitors
        viewer = visitor.session.viewer
        assert viewer.presenter.picture is not None and viewer._sides
        given_back.clear()  # those of a test before may have left late
        # As somebody leaves whose machine is switched off.
        socket._response.close()
        while visitor.session is not None or renderer._visitors or not given_back:
            await asyncio.sleep(0.01)
        assert viewer.presenter.picture is None and not viewer._sides
        assert given_back == [1]

    with_client(renderer, act)


def test_fault_while_one_is_freed_leaves_the_others_their_renderer(renderer, monkeypatch, capsys):
    async def act(client):
        bad = await visit(client)
        await look(bad)
        session = renderer._visitors[0].session
        release = session.release

        def fail() -> None:
            release()
            raise OSError("the driver is gone")

        monkeypatch.setattr(session, "release", fail)
        await bad.close()
        good = await visit(client)
        assert (await look(good)).lossless[-1]
        await good.close()

    with_client(renderer, act)
    assert capsys.readouterr().err == "ssdo-gl: of a viewer: the driver is gone\n"


def test_only_so_many_look_at_once(renderer, monkeypatch):
    monkeypatch.setattr(server_module, "MOST_VISITORS", 1)

    async def act(client):
        first = await visit(client)
        with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
            await visit(client)
        assert caught.value.status == 503
        await first.close()
        while True:  # who was refused is told again once there is room
            try:
                second = await visit(client)
                break
            except aiohttp.WSServerHandshakeError:
                await asyncio.sleep(0.01)
        await second.close()

    with_client(renderer, act)


def test_viewer_that_cannot_be_made_is_told(renderer, capsys):
    async def act(client):
        renderer.faults.append(ValueError("no such thing"))
        bad = await visit(client)
        assert (await bad.receive()).type is aiohttp.WSMsgType.CLOSE and bad.close_code == 1011
        good = await visit(client)
        assert (await look(good)).lossless[-1]
        await good.close()

    with_client(renderer, act)
    assert capsys.readouterr().err == "ssdo-gl: a viewer was lost: no such thing\n"


@pytest.mark.parametrize(
    ("headers", "said"),
    [
        ({"Host": "evil.example"}, "not at that address"),
        ({"Origin": "http://evil.example"}, "only its own page"),
    ],
)
def test_pages_of_others_are_refused(renderer, headers, said):
    async def act(client):
        answer = await client.get("/", headers=headers)
        assert answer.status == 403 and said in await answer.text()
        with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
            await client.ws_connect("/socket", headers=headers)
        assert caught.value.status == 403

    with_client(renderer, act)


def test_token_opens_the_page_and_nothing_else_does(renderer):
    async def act(client):
        assert len(client.root) > 20
        assert (await client.get(f"/{client.root}page.js")).status == 200
        for path in ("/", "/page.js", "/socket", "/wrong/", f"/{client.root[:-2]}/"):
            assert (await client.get(path)).status == 403
        socket = await visit(client)
        assert (await look(socket)).lossless[-1]
        await socket.close()

    with_client(renderer, act, has_token=True)


def test_of_what_waits_only_the_latest_state_is_sent():
    async def act():
        outbox = Outbox()
        for item in (
            {"type": "choices"},
            {"type": "state", "n": 1},
            {"type": "state", "n": 2},
            None,
        ):
            outbox.put(item)
        return [await outbox.take() for _ in range(3)]

    assert asyncio.run(act()) == [{"type": "choices"}, {"type": "state", "n": 2}, None]


def test_thread_without_opengl_says_so():
    with pytest.raises(ContextError, match="no backend is called"):
        RenderThread(lambda device, shaders: None, "gles").start()
