"""The real window on a virtual screen: real keys, a real mouse, looked at as pixels."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from window.x_server import DEADLINE_SECONDS, App, XServer, missing_tools, wait_for

# In CI a missing tool is a fault, elsewhere a reason to leave these tests out.
pytestmark = pytest.mark.skipif(
    bool(missing_tools()) and os.environ.get("CI") != "true",
    reason=f"not installed: {', '.join(missing_tools())}",
)
# Small and coarse: what is tested is the window, and a software rasterizer draws it.
WIDTH, HEIGHT = 320, 200
COMMAND = [
    *(sys.executable, "-m", "ssdo_gl", "cornell_meso"),
    *("--size", f"{WIDTH}x{HEIGHT}", "--samples", "8", "--steps", "4"),
    *("--resolution-scale", "0.5"),
]
# Mean differences of two screens, steps of 255: two averages of the same frames differ
# by rounding; another view, image or method by more than 3.
SAME, ANOTHER = 0.1, 3.0
DIVIDER_COLOR = (255, 217, 76)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[XServer]:
    server = XServer(tmp_path_factory.mktemp("screen"))
    yield server
    server.close()


@pytest.fixture
def app(server: XServer, tmp_path: Path) -> Iterator[App]:
    app = App(server, COMMAND, tmp_path)
    yield app
    app.kill()


def picture(screen: np.ndarray) -> np.ndarray:
    """Return the window's part of the screen, as signed numbers."""
    return screen[:HEIGHT, :WIDTH].astype(int)


def difference(a: np.ndarray, b: np.ndarray) -> float:
    """Compare below the line of text, which says how long a frame took."""
    return float(np.abs(picture(a)[40:] - picture(b)[40:]).mean())


def test_a_visit(app: App, tmp_path: Path) -> None:
    """Walk, look, switch images, split, resize, take a picture, leave."""
    start = app.without_messages()

    def another(what: str) -> np.ndarray:
        return app.settled(what, lambda screen: difference(start, screen) > ANOTHER)

    def as_before(what: str) -> np.ndarray:
        return app.settled(what, lambda screen: difference(start, screen) < SAME)

    assert picture(start).std() > 20.0, "the window is empty"
    # A window as narrow as this one begins without the panel.
    app.key("Tab")
    another("the panel is shown")
    app.key("Tab")
    as_before("the panel is gone")

    app.hold("w", 0.6)
    another("the view has moved")
    app.key("Home")
    as_before("the view is back")

    bad = tmp_path / "bad.obj"
    bad.write_text("v nonsense")
    app.drop(bad)
    app.seen("a message is shown", lambda screen: difference(start, screen) > SAME)
    as_before("the message is gone, the scene the same")

    do = app.server.do
    do("mousemove", "100", "100", "mousedown", "3")
    for _ in range(6):
        do("mousemove_relative", "--", "20", "0")
    do("mouseup", "3")
    another("the view has turned")
    app.key("Home")
    as_before("the view is back")

    seen = [start]
    for digit in "567890":
        app.key(digit)
        is_new = lambda screen: all(difference(screen, old) > ANOTHER for old in seen)  # noqa: E731
        seen.append(app.settled(f"image {digit} is another", is_new))
    app.key("1")

    # SSDO with bounce on the left, and with one press direct light on the right.
    app.key("v", "y")

    def has_divider(screen: np.ndarray, column: int) -> bool:
        row = picture(screen)[HEIGHT // 2]
        near = np.abs(row[column - 3 : column + 3] - DIVIDER_COLOR).max(axis=1)
        return bool(near.min() < 12)

    # What is to be dragged must be there, as it is for who drags it.
    app.settled("two are compared", lambda screen: has_divider(screen, WIDTH // 2))
    do("mousemove", str(WIDTH // 2), "100", "mousedown", "1")
    do("mousemove", str(WIDTH // 4), "100", "mouseup", "1")
    app.settled("the divider is dragged along", lambda screen: has_divider(screen, WIDTH // 4))
    app.key("v")

    do("windowsize", app.window, "240", "160")
    app.settled(
        "the smaller window is filled, and no more",
        lambda screen: screen[:160, :240].std() > 20.0 and not screen[170:, 250:].any(),
    )
    do("windowsize", app.window, str(WIDTH), str(HEIGHT))
    as_before("the window is as large as before")

    good = tmp_path / "good one.obj"
    good.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    app.drop(good)
    another("the dropped model is shown")
    wait_for("the title follows", lambda: "good one" in do("getwindowname", app.window))

    app.key("F12")
    wait_for("the screenshot is there", (tmp_path / "good one-001.png").exists)
    assert (tmp_path / "good one-001.json").exists()
    assert app.close() == 0, app.said()
    assert app.said() == ""


def test_at_rest_it_sleeps_and_without_focus_it_stops(app: App) -> None:
    app.settled()
    before = app.cpu_seconds()
    time.sleep(3.0)
    used = app.cpu_seconds() - before
    # Awake twice a second to look for changed shaders; a busy loop would use all of it.
    assert used < 0.6, f"{used:.2f} s of processor time in 3 s of rest"

    app.server.do("keydown", "w")
    app.server.do("windowfocus", "0x1")
    # Without the release of the key, the camera would fly on and never come to rest.
    app.settled()
    app.server.do("keyup", "w")
    app.server.do("windowfocus", "--sync", app.window)
    assert app.close() == 0


def test_without_imgui_bundle_the_window_still_works(server: XServer, tmp_path: Path) -> None:
    hides = "import sys\nsys.modules['imgui_bundle'] = None\n"
    (tmp_path / "sitecustomize.py").write_text(hides)
    paths = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
    app = App(server, COMMAND, tmp_path, {"PYTHONPATH": os.pathsep.join(paths)})
    try:
        start = app.settled()
        assert picture(start).std() > 20.0
        app.hold("w", 0.5)
        app.settled("the view has moved", lambda screen: difference(start, screen) > ANOTHER)
        assert app.close() == 0
        assert "pip install 'ssdo_gl[window]'" in app.said()
    finally:
        app.kill()


# With a bound or a budget: before 10 s are taken to choose a setting by it.
@pytest.mark.parametrize("flags", [[], ["--max-error", "0.05"], ["--budget-ms", "9"]])
def test_no_display_is_exit_code_3_with_a_hint(tmp_path: Path, flags: list[str]) -> None:
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR")
    environment = {k: v for k, v in os.environ.items() if k not in hidden}
    done = subprocess.run(
        [sys.executable, "-m", "ssdo_gl", "corner", *flags],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=DEADLINE_SECONDS,
    )
    assert done.returncode == 3
    assert not done.stdout
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert "--snapshot" in lines[0]
