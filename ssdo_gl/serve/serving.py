"""Serves the fly-through of a scene until somebody ends it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
from collections.abc import Awaitable
from types import FrameType
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.options.run_options import ServeOptions
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.serve.access import is_any
from ssdo_gl.serve.render_thread import RenderThread
from ssdo_gl.serve.server import run_server
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.shared_scene import SharedScene
from ssdo_gl.window.first_exposure import exposed
from ssdo_gl.window.viewer import Viewer


class _Viewers:
    """Makes viewers of one scene, which is exposed and uploaded for the first of them."""

    def __init__(
        self, scene: Scene, settings: Settings, camera: Camera | None, options: dict[str, Any]
    ) -> None:
        self._scene = scene
        self._settings, self._camera, self._options = settings, camera, options
        self._shared: SharedScene | None = None

    def __call__(self, device: Device, shaders: ShaderLibrary) -> Viewer:
        self._scene = exposed(self._scene, self._settings, self._camera, device, shaders)
        self._shared = self._shared or SharedScene(device.gl, self._scene)
        return Viewer(
            device,
            self._scene,
            self._settings,
            shaders=shaders,
            shared=self._shared,
            camera=self._camera,
            **self._options,
        )


def serve_scene(
    scene: Scene,
    settings: Settings,
    where: ServeOptions,
    *,
    camera: Camera | None = None,
    backend: str = "auto",
    **options: Any,
) -> None:
    """Serve until Ctrl-C; the address is printed once somebody may come.

    Parameters
    ----------
    camera : Camera or None
        Where every flight begins; None: the scene's.
    options
        Others of `Viewer`.

    Raises
    ------
    ContextError
        If there is no usable OpenGL.
    SettingError
        If host and port cannot be listened at.
    """
    try:
        (where.host or "").encode("idna")
    except UnicodeError:
        raise SettingError(f"--host {shown(where.host)}: no machine is called that") from None
    renderer = RenderThread(
        _Viewers(scene, settings, camera, options),
        backend,
        shares_camera=where.viewers == "shared",
    )
    renderer.start()

    def say(address: str) -> None:
        print(said_of(address, where.host), flush=True)

    try:
        # Ctrl-C is how one ends it.
        with contextlib.suppress(KeyboardInterrupt):
            asyncio.run(until_terminated(run_server(renderer, where.host, where.port, say)))
    except socket.gaierror as error:
        raise SettingError(f"--host {where.host}: {error.strerror}") from None
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
        host = where.host or "this machine"
        raise SettingError(f"--port {where.port} of {host}: {reason}") from None
    finally:
        renderer.stop()


async def until_terminated(work: Awaitable[None]) -> None:
    """Await `work`; SIGTERM cancels it, rather than raise in whichever task happens to run.

    Raises
    ------
    SystemExit
        With the exit code of SIGTERM, once `work` has ended for it.
    """
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    is_told = False

    def cancel(_number: int, _frame: FrameType | None) -> None:
        nonlocal is_told
        is_told = True
        loop.call_soon_threadsafe(task.cancel)

    try:
        before = signal.signal(signal.SIGTERM, cancel)
    except ValueError:  # only the main thread may
        await work
        return
    try:
        await work
    except asyncio.CancelledError:
        if not is_told:
            raise
        raise SystemExit(128 + signal.SIGTERM) from None
    finally:
        signal.signal(signal.SIGTERM, before)


def said_of(address: str, host: str | None) -> str:
    """Return what is said once somebody may come to `address`."""
    # What stands for every address is none that another machine could ask for.
    place = f", elsewhere with this machine's name for {host}" if is_any(host or "") else ""
    return f"{address}\nopen it in a browser{place}; Ctrl-C ends it"
