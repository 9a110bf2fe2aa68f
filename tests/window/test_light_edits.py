"""A light in the real window: dragged, put back, dragged again, saved."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from scene_text import body, camera, light
from window.test_window import ANOTHER, COMMAND, SAME, server
from window.x_server import App, XServer, missing_tools, wait_for

__all__ = ["server"]

pytestmark = pytest.mark.skipif(
    bool(missing_tools()) and os.environ.get("CI") != "true",
    reason=f"not installed: {', '.join(missing_tools())}",
)
WIDTH, HEIGHT = 900, 600
SCENE = (
    camera([0, 0, 6], [0, 0, 0])
    + light("point", position=[0, 1, 0.5], intensity=[0.5, 0.5, 0.5], shadow="none")
    + body("plane", point=[0, 0, 0], normal=[0, 0, 1], size=12)
)
# Where the panel begins, its row of the lights, that of the first one, and of its buttons.
PANEL_X, LIGHTS_Y, LIGHT_Y, BUTTONS_Y = 532, 177, 223, 343
# What lies around the lamp, clear of panel and texts.
PART = np.s_[70:400, 200:PANEL_X]
DRAG_PX = 60


def click(app: App, x: int, y: int) -> None:
    """Let the cursor arrive, then press."""
    app.server.do("mousemove", str(x), str(y))
    time.sleep(0.3)
    app.server.do("click", "1")


def arrow(screen: np.ndarray) -> tuple[int, int]:
    """Return the middle of the red arrow, which points to the right of the lamp."""
    # The red of no surface: there is neither green nor blue in it.
    is_arrow = (screen[:, 455:PANEL_X] == (170, 0, 0)).all(axis=2)
    rows, columns = np.nonzero(is_arrow)
    return (int(np.median(columns)) + 455, int(np.median(rows))) if len(rows) else (0, 0)


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a[PART].astype(int) - b[PART]).mean())


def test_a_light_is_dragged_and_that_is_one_step(server: XServer, tmp_path: Path) -> None:
    (tmp_path / "lamp.toml").write_text(SCENE)
    command = [*COMMAND[:3], "lamp.toml", "--size", f"{WIDTH}x{HEIGHT}", "--method", "direct"]
    app = App(server, command, tmp_path)
    try:
        app.settled()
        click(app, PANEL_X + 60, LIGHTS_Y)
        click(app, PANEL_X + 48, LIGHT_Y)
        click(app, PANEL_X + 45, BUTTONS_Y)
        start = app.settled("arrows are shown", lambda screen: arrow(screen)[0] > 0)
        x, y = arrow(start)
        app.server.do("mousemove", str(x), str(y))
        time.sleep(0.5)
        app.server.do("mousedown", "1")
        for _ in range(3):
            app.server.do("mousemove_relative", "--", str(-DRAG_PX // 3), "0")
            time.sleep(0.2)
        app.server.do("mouseup", "1", "mousemove", "100", str(HEIGHT - 100))
        moved = app.settled("the lamp has moved", lambda s: difference(start, s) > ANOTHER)
        app.key("ctrl+z")
        app.settled("the lamp is back at once", lambda s: difference(start, s) < SAME)
        app.key("ctrl+y")
        app.settled("the lamp is moved again", lambda s: difference(moved, s) < SAME)
        app.key("ctrl+s")
        saved = tmp_path / "lamp-001.toml"
        wait_for("a scene is saved", saved.exists)
        text = saved.read_text()
        assert "light = 1\nplace = [-" in text
        assert "camera" not in text.split("[[edit]]")[1]
        assert app.close() == 0, app.said()
    finally:
        app.kill()
