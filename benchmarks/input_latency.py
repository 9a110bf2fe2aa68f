"""From input to photon: how long the window takes to answer keys and mouse.

Opens the real window on a virtual screen (Xvfb), presses keys and moves the mouse by
xdotool, and looks at the screen's memory until the answer is there. Input comes at random
moments of refinement, when a frame at full quality is in the making, of `gi` and of a
reference. ``make bench-input`` prints median and worst of each kind, for a window of many
samples; then, of the same frames, what of them cannot be interrupted: milliseconds that the
program computes, of all processors together, from one look for input to the next. Other
work on the machine lengthens answers, but not these.
"""

from __future__ import annotations

import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.common import answering, check_scenes, command, positive, size_of
from ssdo_gl.gpu.context import create_context
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.viewer import Viewer

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from window.x_server import App, XServer  # type: ignore[import-not-found]

# A part of the screen that differs by this much in the mean, steps of 255, shows another view
# or setting. Pixels are averaged in blocks first: then pictures that refine the same view, of a
# path tracer, too, differ by less than that, as `unasked` finds.
ANOTHER = 1.0
BLOCK = 8
# Who looks must not take the processor from who draws: one pixel in so many, each way.
GLANCE = 7
# The slowest answer that is waited for.
GIVE_UP_S = 10.0
LOOK_S = 0.001
# From the end of a motion to where pictures of full size refine one another.
REFINING_S = 3.2
# Shaders are compiled, levels of quality are tried.
SETTLING_S = 15.0
ROUNDS = 6
METHODS = ("gi", "reference-gi")
# What is pressed, and comes back with the next round.
KEYS = {"arrow key": ("Left", "Right"), "flight key": ("w", "s")}
OTHERS = ("mouse drag", "panel", "slider")
# Of a section of the panel that is open at first: from the right edge to where the slider of
# the budget begins, and from the top to its middle.
SLIDER = (303, 332)
# Frames whose slices count, and those before them, in which shaders are compiled.
WARM_FRAMES, SLICED_FRAMES = 4, 6


# Left, top, width, height of a part of the screen, pixels.
Part = tuple[int, int, int, int]


class Screen:
    """The virtual screen's memory, and a process that sends input without delay."""

    def __init__(self, server: XServer) -> None:
        self._map = np.memmap(server.screen_file, np.uint8, "r")
        header = np.frombuffer(self._map[:100].tobytes(), ">u4")
        self._width, self._height, self._stride = (int(header[i]) for i in (4, 5, 12))
        self._offset = int(header[0]) + 12 * int(header[19])
        self._xdotool = subprocess.Popen(
            ["xdotool", "-"], stdin=subprocess.PIPE, env=server.environment, text=True
        )

    def send(self, *lines: str) -> None:
        """Send xdotool commands."""
        assert self._xdotool.stdin is not None
        self._xdotool.stdin.write("\n".join(lines) + "\n")
        self._xdotool.stdin.flush()

    def _pixels(self, part: Part, step: int) -> np.ndarray:
        x, y, width, height = part
        rows = self._map[self._offset : self._offset + self._stride * self._height]
        rows = rows.reshape(self._height, self._stride)[:, : 4 * self._width]
        pixels = rows.reshape(self._height, self._width, 4)
        return np.asarray(pixels[y : y + height : step, x : x + width : step, :3])

    def trace(self, part: Part) -> bytes:
        """Return what tells, for next to no processor time, whether a part may be another."""
        return self._pixels(part, GLANCE).tobytes()

    def patch(self, part: Part) -> np.ndarray:
        """Return every other pixel of a part of the screen, averaged in blocks."""
        seen = self._pixels(part, 2).astype(np.float32)
        rows, columns = (n // BLOCK for n in seen.shape[:2])
        blocks = seen[: rows * BLOCK, : columns * BLOCK]
        return np.asarray(blocks.reshape(rows, BLOCK, columns, BLOCK, 3).mean((1, 3)))

    def close(self) -> None:
        """End the process."""
        self._xdotool.communicate(timeout=GIVE_UP_S)


def answered_ms(screen: Screen, part: Part, act: Callable[[], None], least: float) -> float:
    """Return after how many milliseconds `part` of the screen is another."""
    before, glance = screen.patch(part), screen.trace(part)
    act()
    start = time.perf_counter()
    while (now := time.perf_counter()) < start + GIVE_UP_S:
        last, glance = glance, screen.trace(part)
        if last != glance and np.abs(screen.patch(part) - before).mean() > least:
            return (now - start) * 1e3
        time.sleep(LOOK_S)
    return float("inf")


def measure(screen: Screen, size: tuple[int, int]) -> dict[str, list[float]]:
    """Return the milliseconds of each kind of input."""
    width, height = size
    picture = (40, 60, width // 3, height - 120)
    # The first headers of the panel, which light up under the cursor, and its slider.
    headers = (width - 340, 60, 320, 160)
    slider = (width - SLIDER[0], SLIDER[1] - 12, 120, 24)
    dice = random.Random(1)
    results: dict[str, list[float]] = {name: [] for name in (*KEYS, *OTHERS)}

    def drag(start: tuple[int, int], way: int, part: Part) -> None:
        """Press the button, wait for refinement to go on, and move."""
        screen.send(f"mousemove {start[0]} {start[1]}", "mousedown 1")
        time.sleep(0.3 + dice.random())
        act = lambda: screen.send(f"mousemove {start[0] + way} {start[1]}")  # noqa: E731
        results[name].append(answered_ms(screen, part, act, ANOTHER))
        screen.send("mouseup 1")

    for number in range(ROUNDS):
        sign = (-1) ** number
        for name in results:
            screen.send(f"mousemove {width // 4} {height // 2}")
            # Into the refinement: the picture is at rest for a while, and not finished.
            time.sleep(REFINING_S + dice.random())
            if name in KEYS:
                key = KEYS[name][number % 2]
                act = lambda key=key: screen.send(f"keydown {key}")  # noqa: E731
                results[name].append(answered_ms(screen, picture, act, ANOTHER))
                screen.send(f"keyup {key}")
            elif name == "mouse drag":
                drag((width // 4, height // 2), 40 * sign, picture)
            elif name == "slider":
                drag((width - SLIDER[0] + 60, SLIDER[1]), 30 * sign, slider)
            else:
                y = 125 + 26 * (number % 3)
                act = lambda y=y: screen.send(f"mousemove {width - 180} {y}")  # noqa: E731
                results[name].append(answered_ms(screen, headers, act, 0.2))
    return results


def unasked(screen: Screen, size: tuple[int, int]) -> float:
    """Return by how much the picture differs, at most, in a second without input."""
    part = (40, 60, size[0] // 3, size[1] - 120)
    screen.send(f"mousemove {size[0] // 4} {size[1] // 2}")
    time.sleep(REFINING_S)
    before, most, start = screen.patch(part), 0.0, time.perf_counter()
    while time.perf_counter() < start + 1.0:
        most = max(most, float(np.abs(screen.patch(part) - before).mean()))
        time.sleep(LOOK_S)
    return most


def slices_ms(scene: str, settings: Settings) -> list[float]:
    """Return what is computed between two looks for input while frames are refined."""
    device = create_context("auto")
    viewer = Viewer(device, load_scene(scene), settings, source=scene, budget_ms=None)
    found: list[float] = []
    since = time.process_time()

    def look(*_: object) -> None:
        nonlocal since
        now = time.process_time()
        found.append(1e3 * (now - since))
        since = time.process_time()

    for number in range(WARM_FRAMES + SLICED_FRAMES):
        if number == WARM_FRAMES:
            found.clear()
        viewer.frame(Controls(), 1.0, settings.size, look)
        device.gl.finish()
        look()
    viewer.release()
    device.release()
    return found


@answering
def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the median and the worst of each kind."""
    parser = command("input_latency", __doc__)
    parser.add_argument("scene", nargs="?", default="cornell_meso")
    parser.add_argument("--size", type=size_of, default=(1280, 800), metavar="WxH")
    parser.add_argument("--samples", type=positive, default=256, metavar="N")
    options = parser.parse_args(arguments)
    check_scenes([options.scene])
    width, height = options.size
    for method in METHODS:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            server = XServer(folder, (width, height))
            words = [sys.executable, "-m", "ssdo_gl", options.scene]
            words += ["--size", f"{width}x{height}", "--samples", str(options.samples)]
            words += ["--method", method, "--spp", "4096"]
            app = App(server, words, folder)
            screen = Screen(server)
            try:
                time.sleep(SETTLING_S)
                most = unasked(screen, (width, height))
                print(f"{method:13} no input    differs by {most:.2f} of {ANOTHER:g}", flush=True)
                for kind, times in measure(screen, (width, height)).items():
                    middle, worst = statistics.median(times), max(times)
                    said = f"median {middle:6.1f} ms   worst {worst:6.1f} ms"
                    print(f"{method:13} {kind:11} {said}", flush=True)
            finally:
                screen.close()
                app.kill()
                server.close()
    for method in METHODS:
        settings = Settings(method, size=(width, height), samples=options.samples, spp=4096)
        median, most, worst = np.percentile(slices_ms(options.scene, settings), [50, 95, 100])
        said = f"median {median:.1f}, 95 % below {most:.1f}, longest {worst:.1f} ms computed"
        print(f"{method:13} slices      {said}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
