"""The widget's page in headless Chromium, against a flight in this process."""

from __future__ import annotations

import base64
import io
import json
import shutil
import time

import numpy as np
import pytest
from PIL import Image

import ssdo_gl

playwright = pytest.importorskip("playwright.sync_api", reason="drives the browser")
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
    pytest.mark.filterwarnings("default::ResourceWarning"),
]
SIZE = (160, 90)
PATIENCE_S = 60.0
# What anywidget gives to `render`.
MODEL = """
window.hearers = [];
window.model = {
  get: (name) => ({ width: %d, height: %d })[name],
  send: (message) => kernel(JSON.stringify(message)),
  on: (_, hear) => hearers.push(hear),
  off: (_, hear) => { hearers = hearers.filter((other) => other !== hear); },
};
window.deliver = (message, file) => {
  const bytes = Uint8Array.from(atob(file), (c) => c.charCodeAt(0));
  for (const hear of hearers) hear(message, [new DataView(bytes.buffer)]);
};
null;
"""


@pytest.fixture
def page():
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.set_content("<body style='margin:0'><div id=here></div></body>")
        yield page
        browser.close()


def test_a_page_shows_what_is_sent_and_sends_what_is_done(page):
    widget = ssdo_gl.view("corner", size=SIZE, samples=8, steps=4)
    flight, outbox = widget._flight, []
    flight._send = lambda message, files: outbox.append((dict(message), files))

    def pump(done) -> None:
        end = time.monotonic() + PATIENCE_S
        while not done():
            assert time.monotonic() < end, page.inner_text("body")
            while outbox:
                message, files = outbox.pop(0)
                file = base64.b64encode(files[0]).decode() if files else ""
                page.evaluate("([message, file]) => deliver(message, file)", [message, file])
                seen.extend(f for f in files if message.get("lossless"))
            page.wait_for_timeout(20)

    def is_at_rest() -> bool:
        return page.eval_on_selector("canvas", "c => c.dataset.lossless") == "true" and not outbox

    def canvas() -> np.ndarray:
        data = page.eval_on_selector("canvas", "c => c.toDataURL('image/png')")
        with Image.open(io.BytesIO(base64.b64decode(data.partition(",")[2]))) as image:
            return np.asarray(image.convert("RGB"))

    seen: list[bytes] = []
    page.expose_function("kernel", lambda text: flight.hear(json.loads(text)))
    page.evaluate(MODEL % SIZE)
    page.evaluate(
        """async (code) => {
          const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
          const { default: widget } = await import(url);
          window.leave = widget.render({ model, el: document.getElementById("here") });
        }""",
        widget._esm,
    )
    pump(is_at_rest)
    with Image.open(io.BytesIO(seen[-1])) as image:
        np.testing.assert_array_equal(canvas(), np.asarray(image.convert("RGB")))
    before, camera = canvas().astype(int), widget.camera
    page.mouse.move(40, 40)
    page.mouse.down()
    page.mouse.move(90, 45, steps=5)
    page.mouse.up()
    pump(lambda: widget.camera != camera)
    page.eval_on_selector("canvas", "c => { c.dataset.lossless = 'false'; }")
    pump(is_at_rest)
    assert np.abs(canvas().astype(int) - before).max() > 40
    page.select_option("select[name=method]", "direct")
    pump(lambda: flight._visitor.session.viewer.view.method == "direct")
    page.evaluate("leave()")
    pump(lambda: not flight.is_running)
    widget.close()
