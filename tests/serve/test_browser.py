"""The page in headless Chromium, by real keys and mouse; needs playwright and Debian's chromium.

What is printed (``-s``) stands in docs/browser.md.
"""

from __future__ import annotations

import asyncio
import base64
import io
import json
import os
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as PillowImage

from ssdo_gl import cli

aiohttp = pytest.importorskip("aiohttp")
playwright = pytest.importorskip("playwright.sync_api", reason="drives the browser")
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
    # Playwright's own loop is another one than that of the event that it is in.
    pytest.mark.filterwarnings("default::ResourceWarning"),
]
SIZE = {"width": 640, "height": 360}
# Of a picture at rest against the same view by --snapshot: sums in float32 and float64.
ROUNDING = 1
# Notes what comes and what is shown, and when.
SPY = """
window.spy = { received: 0, shown: [], aov: "", seen: 0, since: 0, answers: [] };
window.WebSocket = class extends WebSocket {
  constructor(address) {
    super(address);
    this.addEventListener("message", ({ data }) => {
      if (typeof data !== "string") { spy.received = new DataView(data).getUint32(0); return; }
      const heard = JSON.parse(data);
      if (heard.type === "state") {
        if (spy.aov && heard.aov !== spy.aov) spy.seen = spy.received + 1;
        spy.aov = heard.aov;
        spy.frame_ms = heard.frame_ms;
      }
    });
  }
};
addEventListener("keydown", () => { spy.since = performance.now(); }, true);
addEventListener("pointermove", () => { spy.moved ??= performance.now(); }, true);
addEventListener("DOMContentLoaded", () => {
  const picture = document.getElementById("picture");
  new MutationObserver(() => requestAnimationFrame(() => {
    const frame = Number(picture.dataset.frame), now = performance.now();
    spy.shown.push(now);
    if (spy.seen && frame >= spy.seen) { spy.answers.push(now - spy.since); spy.seen = 0; }
  })).observe(picture, { attributeFilter: ["data-frame"] });
});
"""


class Served:
    """A server in a process of its own."""

    def __init__(self, scene: str, *flags: str) -> None:
        root = Path(__file__).parent.parent.parent
        self.process = subprocess.Popen(
            [sys.executable, "-m", "ssdo_gl", scene, "--serve", "--port", "0", *flags],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(root)},
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()

    @property
    def memory_mb(self) -> float:
        """Resident memory of the process; a software renderer's textures are in it."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        line = next(row for row in status.splitlines() if row.startswith("VmRSS"))
        return int(line.split()[1]) / 1024.0

    def end(self) -> str:
        """End it; return what it has complained about."""
        self.process.send_signal(2)
        return self.process.communicate(timeout=60)[1]


@pytest.fixture
def served() -> Iterator[Served]:
    served = Served("cornell_meso")
    try:
        yield served
    finally:
        assert served.end() == ""


@pytest.fixture
def page(served: Served) -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda line: faults.append(line.text))
        page.set_default_timeout(120_000)
        page.add_init_script(SPY)
        page.goto(served.address)
        rest(page)
        yield page
        assert faults == []
        browser.close()


def rest(page: Any) -> None:
    page.wait_for_selector("#picture[data-lossless=true]")


def wait(page: Any, condition: str) -> None:
    """Wait until it holds. Not by `wait_for_function`: the page's policy forbids its eval."""
    for _ in range(10_000):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(10)
    raise AssertionError(condition)


def canvas(page: Any) -> np.ndarray:
    data = page.evaluate("document.getElementById('picture').toDataURL('image/png')")
    file = io.BytesIO(base64.b64decode(data.partition(",")[2]))
    return np.asarray(PillowImage.open(file).convert("RGB")).astype(int)


def is_a_snapshot(page: Any, out: Path) -> bool:
    """Return whether what is shown at rest is what the command writes that the page copies."""
    # Without leave to use the clipboard, the page shows what it would put there.
    page.keyboard.press("KeyC")
    line = page.wait_for_selector("#lines p:has-text('ssdo-gl')").inner_text()
    words = shlex.split(line[line.index("ssdo-gl ") :])[1:]
    words[words.index("--snapshot") + 1] = str(out)
    assert cli.main([*words, "--quiet"]) == 0
    wanted = np.asarray(PillowImage.open(out).convert("RGB")).astype(int)
    shown = canvas(page)
    assert shown.shape == wanted.shape
    return bool(np.abs(shown - wanted).max() <= ROUNDING)


def test_picture_at_rest_is_that_of_a_snapshot_after_real_input(page, tmp_path):
    page.mouse.move(200, 200)
    page.mouse.down()
    page.mouse.move(230, 210)
    page.mouse.move(260, 205, steps=4)
    page.mouse.up()
    page.keyboard.down("KeyW")
    page.wait_for_timeout(300)
    page.keyboard.up("KeyW")
    page.mouse.wheel(0, -200)
    page.wait_for_selector("#picture[data-lossless=false]")
    page.wait_for_timeout(1000)
    rest(page)
    assert canvas(page).shape == (SIZE["height"], SIZE["width"], 3)
    assert is_a_snapshot(page, tmp_path / "snapshot.png")


def test_every_input_is_answered_in_motion_and_out_of_rest(page):
    """How soon is printed, not asserted: it is the machine's as much as the program's."""
    page.keyboard.down("ArrowLeft")
    page.wait_for_timeout(1500)
    page.evaluate("spy.shown.length = 0")
    page.wait_for_timeout(3000)
    times = np.diff(page.evaluate("spy.shown"))
    frame_ms = page.evaluate("spy.frame_ms")
    for count, key in enumerate(("Digit2", "Digit1") * 6, 1):
        page.keyboard.press(key)
        wait(page, f"spy.answers.length === {count}")
        page.wait_for_timeout(150)
    answers = page.evaluate("spy.answers")
    page.keyboard.up("ArrowLeft")
    rest(page)
    from_rest = []
    for _ in range(6):
        page.mouse.move(200, 200)
        page.mouse.down()
        page.wait_for_timeout(800)
        rest(page)
        page.evaluate("spy.shown.length = 0; spy.moved = undefined")
        page.mouse.move(240, 200)
        wait(page, "spy.shown.length > 0")
        from_rest.append(page.evaluate("spy.shown[0] - spy.moved"))
        page.mouse.up()
        page.wait_for_timeout(300)
        rest(page)
    gap_ms = np.median(times)
    print(f"\n{1000.0 / times.mean():.1f} pictures a second, median {gap_ms:.0f} ms apart")
    print(f"drawn in {frame_ms:.0f} ms")
    print(f"key to answer in motion, ms: {np.sort(answers).round()}")
    print(f"mouse to answer from rest, ms: {np.round(from_rest)}")


async def _visit(address: str, number: int) -> None:
    """Move a camera of one's own for some pictures, then leave while others are on their way."""
    async with aiohttp.ClientSession() as client, client.ws_connect(f"{address}socket") as socket:
        await socket.send_json({"type": "size", "width": 160, "height": 90, "scale": 1})
        seen = 0
        async for message in socket:
            if message.type is not aiohttp.WSMsgType.BINARY:
                continue
            seen += 1
            number = int.from_bytes(message.data[:4], "big")
            await socket.send_json({"type": "ack", "frame": number})
            await socket.send_json({"type": "wheel", "notches": 0.02 * (1 + number)})
            if seen == 12:
                return


def test_viewers_come_and_go_and_memory_stays(served):
    def crowd() -> float:
        async def come() -> None:
            await asyncio.gather(*(_visit(served.address, number) for number in range(20)))

        asyncio.run(come())
        time.sleep(1.0)
        return served.memory_mb

    minutes = float(os.environ.get("SERVE_MINUTES", "0"))
    readings = [crowd() for _ in range(6)]
    end = time.monotonic() + 60.0 * minutes
    while time.monotonic() < end:
        readings.append(crowd())
    print(f"\n{len(readings)} times 20 viewers, MB after each: {[round(r) for r in readings]}")
    # Each reading holds what the driver has not given back yet; the least of some does not.
    assert min(readings[-3:]) < 1.15 * min(readings[:3])
    assert served.process.poll() is None


def test_what_the_page_says_is_what_the_program_has(page):
    assert page.inner_text("#title").startswith("Cornell")
    begun = "update({...state, resting: false, scale: 1, samples: [], frame_ms: null})"
    assert page.evaluate(f"{begun}, document.getElementById('status').textContent") == "refining"
    page.keyboard.press("KeyH")
    assert "orbit around the point under the cursor" in page.inner_text("#keys")
    page.keyboard.press("Escape")
    page.select_option("#aov", "depth")
    wait(page, "spy.aov === 'depth'")
    page.keyboard.press("KeyV")
    page.wait_for_selector("#split[aria-pressed=true]")
    assert json.loads(page.evaluate("JSON.stringify(state.messages)"))[-1]["text"]


def turn(page: Any) -> None:
    page.evaluate("document.getElementById('picture').dataset.lossless = false")
    page.keyboard.down("ArrowLeft")
    page.wait_for_timeout(300)
    page.keyboard.up("ArrowLeft")
    page.wait_for_timeout(300)
    rest(page)


def test_two_pages_have_cameras_of_their_own_until_they_share_one(page, served, tmp_path):
    other = page.context.browser.new_page(viewport={"width": 320, "height": 180})
    other.set_default_timeout(120_000)
    other.goto(served.address)
    rest(other)
    page.set_viewport_size({"width": 320, "height": 180})
    turn(page)
    assert np.abs(canvas(page) - canvas(other)).max() > 20
    for number, either in enumerate((page, other)):
        assert is_a_snapshot(either, tmp_path / f"{number}.png")
        either.check("#shared_camera")
        either.wait_for_timeout(1000)
    rest(other)
    assert np.abs(canvas(page) - canvas(other)).max() <= ROUNDING
    turn(other)
    page.wait_for_timeout(500)
    rest(page)
    assert np.abs(canvas(page) - canvas(other)).max() <= ROUNDING
    assert is_a_snapshot(page, tmp_path / "shared.png")
    other.close()
