"""Files in the real window: opened by keys, read again, saved, edits undone."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from window.test_window import ANOTHER, COMMAND, SAME, difference, server
from window.x_server import App, XServer, missing_tools, wait_for

__all__ = ["server"]

pytestmark = pytest.mark.skipif(
    bool(missing_tools()) and os.environ.get("CI") != "true",
    reason=f"not installed: {', '.join(missing_tools())}",
)
SCENE = 'base = "cornell_meso"\n[camera]\nexposure = {}\n'


def typed(app: App, text: str) -> None:
    app.server.do("type", "--delay", "40", text)
    app.key("Return")


def test_a_visit_with_files(server: XServer, tmp_path: Path) -> None:
    app = App(server, COMMAND, tmp_path, {"PATH": os.path.dirname(COMMAND[0])})
    try:
        start = app.without_messages()

        def another(what: str) -> np.ndarray:
            return app.settled(what, lambda screen: difference(start, screen) > ANOTHER)

        def as_before(what: str) -> np.ndarray:
            return app.settled(what, lambda screen: difference(start, screen) < SAME)

        # Without the system's dialog there is a line to type a path into.
        (tmp_path / "mine.toml").write_text(SCENE.format(-2.0))
        app.key("ctrl+o")
        another("a line for a path is shown")
        typed(app, "mine.toml")
        dark = another("the scene of the path is shown")
        wait_for("the title follows", lambda: "mine" in server.do("getwindowname", app.window))
        (tmp_path / "mine.toml").write_text(SCENE.format(0.0))
        as_before("the changed file is read again")
        (tmp_path / "mine.toml").write_text("base = 3")
        app.seen("the fault is told", lambda screen: difference(start, screen) > SAME)
        as_before("the message is gone, the last good scene stays")

        app.key("Left", "Left", "Left", "Left")
        another("the view has turned")
        app.key("ctrl+z")
        as_before("the walk is undone")
        app.key("ctrl+s")
        wait_for("a scene is saved", (tmp_path / "mine-001.toml").exists)
        assert 'base = "mine.toml"' in (tmp_path / "mine-001.toml").read_text()
        assert np.abs(dark.astype(int) - start).mean() > ANOTHER
        assert app.close() == 0, app.said()
    finally:
        app.kill()
