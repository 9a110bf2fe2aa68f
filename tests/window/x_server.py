"""A virtual X server, its screen as an array, and real key and mouse events on it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

# What a picture of the screen must be: Xvfb keeps it in a file in XWD format.
_XWD_FIELDS = 25
NEEDED = ("Xvfb", "xdotool")
# The longest wait for anything: a machine that is busy with other work only makes the
# tests slower, and one that is not never waits this long.
DEADLINE_SECONDS = 240.0
# The program wakes up twice a second at rest; in this long one sees that it does no more.
STILL_SECONDS = 0.6
_LOOK_SECONDS = 0.02
# How much of that time a thread of it may want a processor: to look for changed shaders.
STILL_SHARE = 0.15


def missing_tools() -> list[str]:
    """Return which of the needed programs are not installed."""
    return [name for name in NEEDED if shutil.which(name) is None]


def wait_for(what: str, condition: Callable[[], bool], seconds: float = DEADLINE_SECONDS) -> None:
    """Wait until `condition` holds; a slow machine only makes it take longer."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited {seconds:g} s in vain until {what}")
        time.sleep(0.1)


class XServer:
    """Xvfb on a display number of its own.

    Parameters
    ----------
    folder : Path
        For the file that holds the screen.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (1000, 640)) -> None:
        self.screen_file = folder / "Xvfb_screen0"
        read, write = os.pipe()
        width, height = size
        self._process = subprocess.Popen(
            [
                "Xvfb",
                "-displayfd",
                str(write),
                *("-screen", "0", f"{width}x{height}x24", "-fbdir", str(folder)),
                # When the last program leaves, a server starts anew and lets nobody in
                # meanwhile, unless it is told not to.
                *("-nolisten", "tcp", "-nocursor", "-noreset"),
            ],
            pass_fds=[write],
            stderr=subprocess.DEVNULL,
        )
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        if not number:
            self.close()
            raise RuntimeError("Xvfb does not start")
        self.environment = {**os.environ, "DISPLAY": f":{number}"}
        self.environment.pop("WAYLAND_DISPLAY", None)
        # Not among the files of who runs the tests.
        self.environment["XDG_STATE_HOME"] = str(folder)

    def close(self) -> None:
        """Stop the server."""
        self._process.terminate()
        self._process.wait(DEADLINE_SECONDS)

    def screen(self) -> np.ndarray:
        """Return the screen, (height, width, 3) uint8, row 0 at the top."""
        data = self.screen_file.read_bytes()
        header = np.frombuffer(data, ">u4", _XWD_FIELDS)
        width, height, stride = int(header[4]), int(header[5]), int(header[12])
        offset = int(header[0]) + 12 * int(header[19])
        rows = np.frombuffer(data, np.uint8, stride * height, offset).reshape(height, stride)
        # Blue, green, red, unused.
        return rows[:, : 4 * width].reshape(height, width, 4)[:, :, 2::-1].copy()

    def do(self, *words: str) -> str:
        """Run one xdotool command; return what it prints."""
        done = subprocess.run(
            ["xdotool", *words],
            env=self.environment,
            check=True,
            capture_output=True,
            text=True,
            timeout=DEADLINE_SECONDS,
        )
        return done.stdout.strip()


class App:
    """The program in a window on a virtual screen."""

    def __init__(
        self,
        server: XServer,
        command: list[str],
        folder: Path,
        environment: dict[str, str] | None = None,
    ) -> None:
        self.server = server
        self._log = folder / "log.txt"
        with self._log.open("w") as log:
            self.process = subprocess.Popen(
                command,
                env={**server.environment, **(environment or {})},
                cwd=folder,
                stdout=log,
                stderr=log,
            )
        try:
            wait_for("the window opens", lambda: bool(self._windows()))
            self.window = self._windows()[0]
            # Out of the window, whatever the program before this one has left: where nobody
            # has the keyboard, keys go to the window under the pointer.
            server.do("mousemove", "900", "600")
            # Without a window manager nobody gives the keyboard to a window.
            server.do("windowfocus", "--sync", self.window)
        except BaseException:
            self.kill()
            raise

    def _windows(self) -> list[str]:
        if self.process.poll() is not None:
            raise AssertionError(f"the program ended: {self.said()}")
        done = subprocess.run(
            # One that is not on the screen yet cannot be given the keyboard.
            ["xdotool", "search", "--onlyvisible", "--name", "ssdo_gl"],
            env=self.server.environment,
            capture_output=True,
            text=True,
        )
        return done.stdout.split()

    def said(self) -> str:
        """Return what the program has printed."""
        return self._log.read_text()

    def key(self, *names: str) -> None:
        """Press and let go of keys, one after the other."""
        self.server.do("key", "--delay", "60", *names)

    def hold(self, name: str, seconds: float) -> None:
        """Hold a key for a while."""
        self.server.do("keydown", name)
        time.sleep(seconds)
        self.server.do("keyup", name)

    def seen(self, what: str, condition: Callable[[np.ndarray], bool]) -> None:
        """Wait until `condition` holds for a moment: what goes by itself need not last longer.

        Parameters
        ----------
        what, condition
            Of `settled`.
        """
        wait_for(what, lambda: condition(self.server.screen()))

    def settled(
        self, what: str = "", condition: Callable[[np.ndarray], bool] = lambda screen: True
    ) -> np.ndarray:
        """Wait until the program sleeps, the screen stands still and `condition` holds.

        Parameters
        ----------
        what : str
            What the condition means, for the message if it never holds.
        condition : callable
            Takes the screen. Input may take its time to get through: a screen that stands
            still does not mean that it has arrived.

        Returns
        -------
        ndarray
            The screen.
        """
        end = time.monotonic() + DEADLINE_SECONDS
        before = self.server.screen()
        while True:
            share = self._busy_share()
            now = self.server.screen()
            is_still = share < STILL_SHARE and np.array_equal(now, before)
            if is_still and condition(now):
                return now
            before = now
            fault = f"not {what}" if is_still else "the picture does not come to rest"
            assert time.monotonic() < end, f"after {DEADLINE_SECONDS:g} s: {fault}"

    def _busy_share(self) -> float:
        """Return for how much of `STILL_SECONDS` a thread of the program wanted to run.

        Not the processor time: others may leave it none for a while.
        """
        looks = round(STILL_SECONDS / _LOOK_SECONDS)
        wanted = 0
        for _ in range(looks):
            time.sleep(_LOOK_SECONDS)
            if self.process.poll() is not None:
                raise AssertionError(f"the program ended: {self.said()}")
            wanted += any(state != "S" for state in self._thread_states())
        return wanted / looks

    def _thread_states(self) -> list[str]:
        states = []
        for path in Path(f"/proc/{self.process.pid}/task").glob("*/stat"):
            try:
                states.append(path.read_text().rsplit(")", 1)[1].split()[0])
            except OSError:
                continue  # the thread has ended
        return states

    def without_messages(self) -> np.ndarray:
        """Wait until what was said so far is shown no more; return the screen."""
        self.settled()
        # A line goes after 4 s; it is looked for twice a second.
        time.sleep(5.0)
        return self.settled()

    def drop(self, path: Path) -> None:
        """Drop a file on the window."""
        command = [sys.executable, str(Path(__file__).with_name("x_drop.py"))]
        subprocess.run([*command, self.window, str(path)], env=self.server.environment, check=True)

    def cpu_seconds(self) -> float:
        """Return the processor time that the program has used."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def close(self) -> int:
        """Close the window as its key does; return the exit code."""
        if self.process.poll() is None:
            self.key("ctrl+q")
        return self.process.wait(DEADLINE_SECONDS)

    def kill(self) -> None:
        """End the program if it has not ended by itself."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(30)
