"""three.js in Chromium: its SSAO, GTAO and SSGI, on the same OpenGL as everybody else."""

from __future__ import annotations

import base64
import importlib
import io
import math
import os
import shutil
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from benchmarks.peer_room import INTENSITY, LAMP, SKY, NoPeerError, PeerTimes, Room

# A name that exists only in the page: whatever it asks for is a file.
HOST = "http://peer.invalid"
PAGE = """<!doctype html><script type="importmap">{"imports": {
"three": "/three/build/three.module.js", "three/webgpu": "/three/build/three.webgpu.js",
"three/tsl": "/three/build/three.tsl.js", "three/addons/": "/three/examples/jsm/"}}</script>"""
PREPARE = "async room => { window.peer = await import('/peer.js'); return peer.prepare(room); }"
# ANGLE over the system's EGL: Mesa or the driver, as for the others.
FLAGS = ("--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--no-sandbox")


def package_folder(folder: Path | None) -> Path:
    """Return the npm package `three` in or below `folder`; raises NoPeerError."""
    if folder is None:
        raise NoPeerError("no --three DIR: npm install three, and name its folder")
    for candidate in (folder, folder / "node_modules" / "three"):
        if (candidate / "build" / "three.webgpu.js").is_file():
            return candidate.resolve()
    raise NoPeerError(f"--three {folder}: holds no npm package three (build/three.webgpu.js)")


def children_ms(root: int) -> float:
    """Return processor time of all processes below `root`, ms; NaN where /proc has none."""
    parents, used = {}, {}
    try:
        for path in Path("/proc").glob("[0-9]*/stat"):
            try:
                text = path.read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue  # it ended meanwhile
            fields = text.rpartition(")")[2].split()
            parents[int(path.parent.name)] = int(fields[1])
            used[int(path.parent.name)] = int(fields[11]) + int(fields[12])
    except OSError:
        return math.nan
    below, found = {root}, -1
    while found != len(below):
        found = len(below)
        below |= {pid for pid, parent in parents.items() if parent in below}
    ticks = sum(used[pid] for pid in below - {root} if pid in used)
    return 1e3 * ticks / os.sysconf("SC_CLK_TCK") if parents else math.nan


class Three:
    """The room in a page of headless Chromium."""

    def __init__(self, room: Room, folder: Path | None) -> None:
        self._room = room
        package = package_folder(folder)
        chromium = shutil.which("chromium") or shutil.which("google-chrome")
        if chromium is None:
            raise NoPeerError("neither chromium nor google-chrome is installed")
        try:
            playwright = importlib.import_module("playwright.sync_api")
        except ImportError as error:
            raise NoPeerError(f"{error}: pip install playwright") from None
        with ExitStack() as stack:
            driver = stack.enter_context(playwright.sync_playwright())
            try:
                browser = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
                stack.callback(browser.close)
                self._page = browser.new_page()
                self._page.route(f"{HOST}/**", lambda route: _answer(route, package))
                self._page.goto(f"{HOST}/")
                found = self._page.evaluate(PREPARE, self._description())
            except playwright.Error as error:
                raise NoPeerError(str(error).splitlines()[0]) from None
            self._running = stack.pop_all()
        self.device: str = found["device"]
        faults = [found["fault"]] if found["fault"] else []
        self.notes: Sequence[str] = [f"three.js r{found['revision']}", *faults]
        self._names = {f"three.js {name}": name for name in found["variants"]}
        self.variants: Mapping[str, str] = {
            f"three.js {name}": draws for name, draws in found["variants"].items()
        }

    def _description(self) -> dict[str, Any]:
        room, camera = self._room, self._room.scene.camera
        return {
            "positions": room.positions.ravel().tolist(),
            "colors": np.repeat(room.albedo, 3, axis=0).ravel().tolist(),
            "eye": camera.position,
            "target": camera.target,
            "up": camera.up,
            "fov": camera.fov_y,
            "near": room.near,
            "far": room.far,
            "width": room.size[0],
            "height": room.size[1],
            "radius": room.radius,
            "lamp": LAMP,
            "intensity": INTENSITY,
            "sky": SKY,
        }

    def depth(self) -> NDArray[np.float64]:
        """Return distances along the view axis."""
        levels = _pixels(self._page.evaluate("() => peer.depth()"))
        depth = self._room.far * levels[:, :, :3] @ [1.0, 1.0 / 255.0, 1.0 / 65025.0]
        return np.asarray(depth, dtype=np.float64)

    def visibility(self, variant: str) -> NDArray[np.float64] | None:
        """Return the image that its occlusion is multiplied by."""
        url = self._page.evaluate("name => peer.visibility(name)", self._names[variant])
        return None if url is None else _pixels(url)[:, :, 0]

    def timed(self, variant: str, frames: int) -> PeerTimes:
        """Draw `frames` frames; return means."""
        call = "([name, frames]) => peer.timed(name, frames)"
        self._page.evaluate(call, [self._names[variant], 1])
        begin = children_ms(os.getpid())
        wall = self._page.evaluate(call, [self._names[variant], frames])
        return PeerTimes(wall, (children_ms(os.getpid()) - begin) / frames)

    def close(self) -> None:
        """End the browser."""
        self._running.close()


def _answer(route: Any, package: Path) -> None:
    """Answer the page's request: itself, its script, or a file of three.js."""
    name = route.request.url.removeprefix(f"{HOST}/")
    if name == "":
        route.fulfill(body=PAGE, content_type="text/html")
    elif name == "peer.js":
        script = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
        route.fulfill(body=script, content_type="text/javascript")
    elif name.startswith("three/") and (path := package / name.removeprefix("three/")).is_file():
        route.fulfill(path=path, content_type="text/javascript")
    else:
        route.fulfill(status=404)


def _pixels(url: str) -> NDArray[np.float64]:
    """Return the levels of a data URL's PNG, [0, 1]."""
    with Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2]))) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255.0
