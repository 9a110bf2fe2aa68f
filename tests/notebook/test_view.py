"""The notebook's widget, by the messages of a page, and the example notebook as a whole."""

from __future__ import annotations

import builtins
import io
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ssdo_gl
from ssdo_gl.render_result import RenderResult

ROOT = Path(__file__).parents[2]
SIZE = (64, 36)
SETTINGS = {"size": SIZE, "samples": 8, "steps": 4}
# Of the widget at rest against a picture of as many frames: sums in float32 and float64.
ROUNDING = 1
PATIENCE_S = 60.0


class Page:
    """What a page of the widget sends and sees."""

    def __init__(self, widget, page: str = "a") -> None:
        self.flight, self.heard = widget._flight, []
        self.flight._send = self.take
        self.tell("open", page=page)
        self.tell("size", width=SIZE[0], height=SIZE[1], scale=1)

    def tell(self, kind: str, **fields) -> None:
        self.flight.hear({"type": kind, **fields})

    def take(self, message, buffers) -> None:
        self.heard.append((message, buffers))
        if message["type"] == "picture":
            self.tell("ack", frame=message["frame"])

    def wait(self, wanted) -> tuple:
        """Return the first message from now on that is wanted."""
        first, end = len(self.heard), time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            for message, buffers in self.heard[first:]:
                if wanted(message):
                    return message, buffers
            time.sleep(0.01)
        raise AssertionError([message for message, _ in self.heard])

    def picture_at_rest(self) -> np.ndarray:
        _, (data,) = self.wait(lambda m: m["type"] == "picture" and m["lossless"])
        with Image.open(io.BytesIO(data)) as image:
            return np.asarray(image.convert("RGB")).astype(int)


@pytest.fixture
def widget():
    pytest.importorskip("anywidget")
    made = ssdo_gl.view("corner", **SETTINGS)
    yield made
    made.close()
    assert not made._flight.is_running


def test_at_rest_it_shows_what_a_picture_of_its_camera_shows(widget):
    page = Page(widget)
    shown = page.picture_at_rest()
    page.tell("button", button=0, down=True, x=10, y=10)
    for x in range(12, 40, 4):
        page.tell("cursor", x=x, y=14)
    page.tell("button", button=0, down=False, x=40, y=14)
    moved = page.picture_at_rest()
    assert np.abs(moved - shown).max() > 40
    assert any(m["type"] == "picture" and not m["lossless"] for m, _ in page.heard)
    camera = widget.camera
    assert camera != ssdo_gl.load_scene("corner").camera
    page.tell("close", page="a")
    # The flight goes on where it ended.
    assert widget.camera == camera and not widget._flight.is_running
    again = Page(widget, "b").picture_at_rest()
    assert np.abs(again - moved).max() <= ROUNDING


def test_what_is_no_event_is_refused_and_harms_nothing(widget):
    page = Page(widget)
    page.tell("size", width=1e9, height=2, scale=1)
    assert page.heard[-1][0]["type"] == "fault"
    page.tell("choose", what="method", value="direct")
    page.wait(lambda m: m["type"] == "state" and m["method"] == "direct")


def test_it_ends_with_the_last_page(widget):
    for name in ("a", "b"):
        page = Page(widget, name)
    page.picture_at_rest()
    thread = widget._flight._thread
    page.tell("close", page="b")
    assert widget._flight._thread is thread
    page.tell("close", page="a")
    assert not widget._flight.is_running and not thread._thread.is_alive()


def test_readers_without_widgets_see_a_picture(widget):
    bundle = widget._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    with Image.open(io.BytesIO(data["image/png"])) as image:
        assert image.size == SIZE
    assert "application/vnd.jupyter.widget-view+json" in data


def test_without_the_extra_there_is_a_still_picture(monkeypatch, capsys):
    actual = builtins.__import__

    def without(name, *arguments, **named):
        if name.partition(".")[0] == "anywidget":
            raise ImportError(name=name)
        return actual(name, *arguments, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.delitem(__import__("sys").modules, "ssdo_gl.notebook.fly_widget", raising=False)
    still = ssdo_gl.view("corner", **SETTINGS)
    assert isinstance(still, RenderResult)
    assert capsys.readouterr().out == (
        "ssdo_gl.view: a still picture; pip install 'ssdo_gl[notebook]' to turn it\n"
    )


def test_the_example_notebook_runs(tmp_path):
    nbclient = pytest.importorskip("nbclient", reason="executes the notebook")
    pytest.importorskip("ipykernel", reason="the notebook's kernel")
    import nbformat

    notebook = nbformat.read(ROOT / "docs" / "notebook.ipynb", as_version=4)
    nbformat.validate(notebook)
    # Stored without results: those of another machine would be other bytes.
    assert all(not cell.get("outputs") for cell in notebook.cells)
    nbclient.NotebookClient(
        notebook, timeout=120, resources={"metadata": {"path": tmp_path}}
    ).execute()
    shown = [
        out.data for cell in notebook.cells for out in cell.get("outputs", ()) if "data" in out
    ]
    assert sum("image/png" in data for data in shown) >= 3
    assert any("application/vnd.jupyter.widget-view+json" in data for data in shown)
