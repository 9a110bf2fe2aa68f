"""The session of a viewer far away: events in, pictures out."""

from __future__ import annotations

import dataclasses
import io
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as PillowImage
from window.driven_viewer import Clock

from ssdo_gl import cli
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.load import load_scene
from ssdo_gl.serve.delivery import MOST_IN_FLIGHT, QUALITIES, Delivery, SentPicture
from ssdo_gl.serve.page_events import MAX_PIXELS, PageEventError, checked_event, read_event
from ssdo_gl.serve.remote_session import RemoteSession
from ssdo_gl.settings import Settings
from ssdo_gl.window.viewer import Viewer

SIZE = (64, 36)
FRAME_S = 1.0 / 30.0


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def session(
    gl: object, device: Device, shaders: ShaderLibrary, tmp_path: Path, clock: Clock
) -> Iterator[RemoteSession]:
    viewer = Viewer(
        device,
        load_scene("corner"),
        Settings("bounce", samples=8, steps=4),
        source="corner",
        folder=tmp_path,
        presets={"fast": {"samples": 4}},
        shaders=shaders,
    )
    session = RemoteSession(viewer, SIZE, clock)
    yield session
    session.release()


def tell(session: RemoteSession, kind: str, **fields: Any) -> None:
    session.handle(checked_event({"type": kind, **fields}))


def press(session: RemoteSession, code: str, mods: int = 0) -> None:
    for down in (True, False):
        tell(session, "key", code=code, down=down, repeat=False, mods=mods)


def answer(session: RemoteSession, picture: SentPicture | None) -> None:
    if picture is not None:
        tell(session, "ack", frame=picture.number)


def rest(session: RemoteSession, clock: Clock) -> list[SentPicture]:
    """Let time pass until nothing is left to do; return what was sent."""
    pictures = []
    for _ in range(300):
        if not session.is_due:
            return pictures
        clock.seconds += FRAME_S
        picture = session.step()
        answer(session, picture)
        pictures += [] if picture is None else [picture]
    raise AssertionError("the picture does not come to rest")


def pixels(picture: SentPicture) -> np.ndarray:
    return np.asarray(PillowImage.open(io.BytesIO(picture.data)).convert("RGB")).astype(int)


@pytest.mark.parametrize("method", ["bounce", "gi"])
def test_motion_is_lossy_and_rest_is_what_a_snapshot_gives(session, clock, tmp_path, method):
    tell(session, "choose", what="method", value=method)
    pictures = rest(session, clock)
    assert [item.is_lossless for item in pictures] == [False] * (len(pictures) - 1) + [True]
    press(session, "KeyC")
    rest(session, clock)
    command = shlex.split(session.take_clipboard())
    assert command[0] == "ssdo-gl"
    out = tmp_path / "snapshot.png"
    command[command.index("--snapshot") + 1] = str(out)
    assert cli.main([*command[1:], "--quiet"]) == 0
    session.viewer.device.activate()
    wanted = np.asarray(PillowImage.open(out).convert("RGB")).astype(int)
    assert np.abs(pixels(pictures[-1]) - wanted).max() <= 1


def leaves(item: Any) -> Iterator[Any]:
    if isinstance(item, (dict, list, tuple)):
        for part in item.values() if isinstance(item, dict) else item:
            yield from leaves(part)
    else:
        yield item


def test_state_is_of_plain_types(session, clock):
    # A method, and rays of a reference, that nobody has chosen.
    method = type(Settings().method)("reference-ao")
    session.viewer.settings = Settings()
    session.viewer.view = dataclasses.replace(session.viewer.view, method=method)
    session.step()
    kinds = {type(leaf) for leaf in leaves(session.state)}
    assert kinds <= {str, int, float, bool, type(None)}


def test_keys_mouse_and_wheel_do_what_they_do_in_the_window(session, clock):
    rest(session, clock)
    start = session.viewer.camera
    tell(session, "key", code="KeyW", down=True, repeat=False, mods=0)
    clock.seconds += 0.5
    answer(session, session.step())
    tell(session, "key", code="KeyW", down=False, repeat=False, mods=0)
    rest(session, clock)
    flown = session.viewer.camera
    ahead = np.subtract(start.target, start.position)
    assert np.dot(np.subtract(flown.position, start.position), ahead) > 0
    # To the right with the left button: the camera goes round its pivot, as far as before.
    tell(session, "button", button=0, down=True, x=32, y=20)
    rest(session, clock)
    pivot = session.viewer.flight.pivot
    tell(session, "cursor", x=50, y=20)
    tell(session, "button", button=0, down=False, x=50, y=20)
    rest(session, clock)
    turned = session.viewer.camera
    distance = [np.linalg.norm(np.subtract(c.position, pivot)) for c in (flown, turned)]
    assert turned.position != flown.position
    assert distance[0] == pytest.approx(distance[1], rel=1e-6)
    tell(session, "wheel", notches=2)
    rest(session, clock)
    assert np.linalg.norm(np.subtract(session.viewer.camera.position, pivot)) != pytest.approx(
        distance[0], rel=1e-2
    )
    # The right button looks around from where one stands.
    place = session.viewer.camera.position
    tell(session, "button", button=2, down=True, x=32, y=20)
    assert session.state["looking"]
    tell(session, "cursor", x=10, y=20)
    tell(session, "button", button=2, down=False, x=10, y=20)
    rest(session, clock)
    assert session.viewer.camera.position == pytest.approx(place)
    press(session, "Home")
    rest(session, clock)
    assert session.viewer.camera == start


def test_digits_methods_and_comparison_follow_keys_and_panel(session, clock):
    rest(session, clock)
    press(session, "Digit2")
    press(session, "KeyV")
    rest(session, clock)
    state = session.state
    assert state["aov"] != "beauty" and state["split"] and len(session.viewer._sides) == 2
    for what, value in (("aov", "beauty"), ("method", "ssao"), ("error", True), ("preset", "fast")):
        tell(session, "choose", what=what, value=value)
    tell(session, "choose", what="other_method", value="direct")
    tell(session, "choose", what="exposure", value=1.5)
    rest(session, clock)
    state = session.state
    assert (state["aov"], state["method"], state["other_method"]) == ("beauty", "ssao", "direct")
    assert state["error"] and not state["split"] and state["exposure"] == 1.5
    assert state["relative_error"] > 0 and session.viewer.settings.samples == 4
    assert state["resting"] and state["samples"] == [(16, 16), (16, 16)]


@pytest.mark.parametrize(
    ("what", "value"),
    [("method", "magic"), ("aov", 3), ("split", 1), ("exposure", 1e9), ("preset", True), ("x", 1)],
)
def test_choice_that_does_not_exist_is_a_message(session, clock, what, value):
    rest(session, clock)
    before = session.viewer.view, session.viewer.settings
    tell(session, "choose", what=what, value=value)
    rest(session, clock)
    assert (session.viewer.view, session.viewer.settings) == before
    assert session.state["messages"][-1]["is_fault"]


@pytest.mark.parametrize(
    ("code", "mods"), [("KeyS", 2), ("F12", 0), ("KeyO", 2), ("KeyL", 0), ("KeyR", 0), ("F5", 0)]
)
def test_a_page_reaches_no_file_of_the_machine(session, clock, tmp_path, code, mods):
    rest(session, clock)
    press(session, code, mods)
    rest(session, clock)
    assert session.state["messages"][-1]["text"].startswith("only in a window:")
    assert list(tmp_path.iterdir()) == []


def test_slow_reader_gets_no_more_than_two_pictures_and_then_the_last_one(session, clock):
    rest(session, clock)
    sent = []
    for _ in range(20):
        tell(session, "key", code="ArrowLeft", down=True, repeat=False, mods=0)
        clock.seconds += FRAME_S
        if session.is_due and (picture := session.step()) is not None:
            sent.append(picture)
    assert len(sent) == MOST_IN_FLIGHT and not session.is_due
    tell(session, "key", code="ArrowLeft", down=False, repeat=False, mods=0)
    tell(session, "ack", frame=10**6)  # of nothing that was sent
    assert not session.is_due
    answer(session, sent[-1])
    last = rest(session, clock)[-1]
    assert last.is_lossless and last.number > sent[-1].number


def test_key_moves_by_when_it_was_held_not_by_how_long_frames_take(session, clock):
    rest(session, clock)
    start = session.viewer.camera.position
    ways = []
    for frame_s in (0.02, 0.2):
        clock.seconds += 1.0
        for down, at in ((True, 0.0), (False, 0.15)):
            event = {"type": "key", "code": "KeyW", "down": down, "repeat": False, "mods": 0}
            session.handle({**checked_event(event), "at": clock.seconds + at})
        while session.is_due:
            clock.seconds += frame_s
            answer(session, session.step())
        ways.append(np.linalg.norm(np.subtract(session.viewer.camera.position, start)))
        press(session, "Home")
        rest(session, clock)
    assert ways[0] == pytest.approx(ways[1], rel=0.05)


def test_picture_has_the_size_of_the_page(session, clock):
    rest(session, clock)
    tell(session, "size", width=40, height=30, scale=2.0)
    assert pixels(rest(session, clock)[-1]).shape == (60, 80, 3)


def test_others_interrupt_a_frame_at_rest_but_not_one_in_motion(session, clock):
    given_up = []

    def waits() -> bool:
        if len(given_up) < 4 and session.viewer.can_be_given_up:
            given_up.append(session.viewer.left.image.sample_count)
            return True
        return not session.viewer.can_be_given_up

    session.between_slices = waits
    assert rest(session, clock)[-1].is_lossless
    assert len(given_up) == 4


def test_delivery_that_lags_lowers_quality_and_one_that_does_not_raises_it(clock):
    delivery = Delivery(clock)
    noise = np.random.default_rng(1).integers(0, 256, (36, 64, 3), dtype=np.uint8)

    def deliver(seconds: float) -> int:
        for _ in range(60):
            picture = delivery.pack(noise, is_lossless=False)
            clock.seconds += seconds
            delivery.acknowledge(picture.number)
        return QUALITIES.index(delivery.quality)

    # A long way alone lowers nothing, nor does what is looked at for long.
    assert deliver(0.3) <= 1
    resting = delivery.pack(noise, is_lossless=False, is_resting=True)
    clock.seconds += 5.0
    delivery.acknowledge(resting.number)
    low = deliver(1.0)
    assert low > 1
    assert deliver(0.3) < low
    sizes = [len(Delivery(clock).pack(noise, is_lossless=True).data)]
    for quality in range(len(QUALITIES)):
        delivery._governor.level = quality
        sizes.append(len(delivery.pack(noise, is_lossless=False).data))
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "garbage",
        "[" * 100_000,
        '{"type": "exec"}',
        '{"type": []}',
        '{"type": "focus"}',
        '{"type": "focus", "has": 1}',
        '{"type": "focus", "has": true, "more": 1}',
        '{"type": "cursor", "x": NaN, "y": 0}',
        '{"type": "cursor", "x": 1e999, "y": 0}',
        '{"type": "cursor", "x": ' + "9" * 4000 + ', "y": 0}',
        '{"type": "wheel", "notches": "1"}',
        '{"type": "size", "width": 0, "height": 9, "scale": 1}',
        '{"type": "size", "width": 8000, "height": 8000, "scale": 1}',
        '{"type": "size", "width": 4000, "height": 1, "scale": 4}',
        '{"type": "key", "code": "' + "A" * 99 + '", "down": true, "repeat": false, "mods": 0}',
        '{"type": "ack", "frame": true}',
    ],
)
def test_garbage_is_no_event(text):
    with pytest.raises(PageEventError) as caught:
        read_event(text)
    assert len(str(caught.value)) < 200


def test_largest_picture_is_taken():
    width, height = 3840, MAX_PIXELS // 3840
    checked_event({"type": "size", "width": width, "height": height, "scale": 1})
