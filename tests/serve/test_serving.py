"""The command that serves: addresses it cannot take, who may come in, signals that end it."""

from __future__ import annotations

import asyncio
import os
import signal
import socket as sockets
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from ssdo_gl import cli
from ssdo_gl.gpu.context import create_context
from ssdo_gl.process import signals_as_exceptions
from ssdo_gl.serve import render_thread, serving
from ssdo_gl.serve.access import Access
from ssdo_gl.serve.render_thread import RenderThread
from ssdo_gl.serve.serving import said_of, until_terminated

PATIENCE_S = 120.0


pytest.importorskip("aiohttp")


def test_missing_library_is_one_line(monkeypatch, capsys):
    monkeypatch.setattr(cli, "find_spec", lambda name: None)
    assert cli.main(["corner", "--serve"]) == 2
    assert capsys.readouterr().err == (
        "ssdo-gl: --serve needs aiohttp: pip install 'ssdo_gl[serve]'\n"
    )


def test_port_in_use_is_one_line(capsys):
    with sockets.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert cli.main(["corner", "--serve", "--port", str(port)]) == 2
    fault = capsys.readouterr().err
    assert fault == f"ssdo-gl: --port {port} of this machine: Address already in use\n"


@pytest.mark.parametrize(
    ("host", "said"),
    [
        ("x" * 300, "--host 'xxx"),
        ("a..b", "--host 'a..b': no machine is called that"),
        ("\xfc" * 100, "no machine is called that"),
    ],
)
def test_what_is_no_host_is_one_line(host: str, said: str, capfd: Any) -> None:
    assert cli.main(["corner", "--serve", "--port", "0", "--host", host]) == 2
    fault = capfd.readouterr().err
    assert said in fault and fault.count("\n") == 1


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_what_stands_for_all_addresses_is_not_what_one_types_elsewhere(host: str) -> None:
    assert f"elsewhere with this machine's name for {host};" in said_of("http://x/", host)
    assert said_of("http://x/", None) == "http://x/\nopen it in a browser; Ctrl-C ends it"
    assert said_of("http://x/", "box") == said_of("http://x/", None)


def test_an_unknown_host_is_one_line(monkeypatch, capfd):
    def unknown(*_: Any) -> None:
        raise sockets.gaierror(sockets.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr(serving, "run_server", unknown)
    assert cli.main(["corner", "--serve", "--port", "0", "--host", "nobody"]) == 2
    assert capfd.readouterr().err == "ssdo-gl: --host nobody: Name or service not known\n"


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_it_cleanly_after_what_is_no_http(number):
    command = [sys.executable, "-m", "ssdo_gl", "corner", "--serve", "--port", "0"]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent.parent.parent)}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        address = process.stdout.readline()
        assert address.startswith("http://127.0.0.1:")
        for request in (b"\x00\xff\r\n\r\n", b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"):
            with sockets.create_connection(
                ("127.0.0.1", int(address.split(":")[2][:-2]))
            ) as socket:
                socket.sendall(request)
                assert b" 400 " in socket.recv(400)
        process.send_signal(number)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert err == ""
    assert process.returncode == (0 if number == signal.SIGINT else 128 + number)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
def test_ctrl_c_while_the_device_is_made_ends_the_thread(monkeypatch, request):
    def interrupted(backend: str) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.2)
        return create_context(backend)

    monkeypatch.setattr(render_thread, "create_context", interrupted)
    thread = RenderThread(lambda device, shaders: None, request.config.getoption("--backend"))
    # Were it to wait for a thread that nobody has told to end, this would free the test.
    rescue = threading.Timer(PATIENCE_S, os.kill, (os.getpid(), signal.SIGINT))
    rescue.start()
    with signals_as_exceptions(), pytest.raises(KeyboardInterrupt):
        thread.start()
    rescue.cancel()
    assert "rendering" not in [other.name for other in threading.enumerate()]


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
def test_sigterm_raises_in_no_task_that_happens_to_run(caplog):
    async def answer():
        signal.raise_signal(signal.SIGTERM)

    async def work():
        answers.append(asyncio.create_task(answer()))
        await asyncio.Event().wait()

    answers = []
    with signals_as_exceptions(), pytest.raises(SystemExit, match="143"):
        asyncio.run(until_terminated(work()))
    assert answers[0].exception() is None
    assert not caplog.messages


@pytest.mark.parametrize(
    ("listens", "token", "host", "origin", "path", "refused"),
    [
        ("127.0.0.1", "", "127.0.0.1:8765", None, "/", ""),
        ("127.0.0.1", "", "localhost:9000", "http://localhost:9000", "/socket", ""),
        ("::1", "", "[::1]:8765", "http://[::1]:8765", "/socket", ""),
        ("127.0.0.1", "", "evil.example:8765", None, "/", "not at that address"),
        ("127.0.0.1", "", "localhost.evil.example", None, "/", "not at that address"),
        ("127.0.0.1", "", "", None, "/", "not at that address"),
        ("127.0.0.1", "", "[::1", None, "/", "not at that address"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://evil.example", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://127.0.0.1:1", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "null", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://[::1", "/socket", "its own page"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/secret/", ""),
        ("0.0.0.0", "secret", "box.example:8765", None, "/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/secret2/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/s\u00e9cret/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "*", "no valid token"),
        ("box.example", "secret", "other.example", None, "/secret/", "not at that address"),
        ("box.example", "secret", "BOX.example:80", "http://box.example:80", "/secret/", ""),
    ],
)
def test_only_those_who_know_the_address_come_in(listens, token, host, origin, path, refused):
    refusal = Access(listens, token).refusal(host, origin, path)
    assert (refused in refusal) if refused else refusal == ""
