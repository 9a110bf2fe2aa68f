"""A steady frame calls no more functions than it needs: what it costs on a GPU."""

from __future__ import annotations

import pytest

from benchmarks import python_time
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene

SCENE = load_scene("cornell_meso")
SETTINGS = dict(python_time.rows(SCENE))
# Functions that a frame calls, and methods of moderngl's objects: a tenth more than CPython
# 3.11 with fragment shaders. Before they were looked for it was 2743 and 139, 4285 and 164.
MOST = {"still": (1160, 80), "moving": (1770, 107)}


@pytest.mark.parametrize("motion", MOST)
def test_a_steady_frame_calls_few_functions(device, motion):
    if device.computes:
        pytest.skip("compute shaders bind images where fragment shaders have a target")
    with Renderer(SCENE, SETTINGS["bounce, preset balanced"], device=device) as renderer:
        cost = python_time.measure(renderer, motion, 1)
    assert cost.calls <= MOST[motion][0]
    assert cost.gl_calls <= MOST[motion][1]
    assert cost.python_ms > 0.0 and cost.driver_ms > 0.0


def test_every_row_is_measured_and_printed(monkeypatch, capsys):
    monkeypatch.setattr(python_time, "WARM_UP", 2)
    monkeypatch.setattr(python_time, "rows", lambda scene: [("direct", SETTINGS["direct"])])
    assert python_time.main(["corner", "--frames", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    found = [line.strip("| ").split(" | ")[:2] for line in lines[2:-2]]
    assert found == [["direct", motion] for motion in python_time.MOTIONS]
    assert lines[-1].startswith("corner, medians of 1 frames; ")


class Waste:
    """A cycle of references whose end calls functions."""

    def __init__(self) -> None:
        self.own = self

    def __del__(self) -> None:
        repr(self.own.own)


def test_what_others_have_left_is_not_counted():
    def frame(number: int) -> list[list[int]]:
        return [[i] for i in range(5000)]

    alone = python_time._calls(frame, 0)
    for _ in range(300):
        Waste()
    assert python_time._calls(frame, 0) == alone


def test_what_the_context_frees_of_others_is_not_counted(device):
    def frame(number: int) -> None:
        device.activate()

    alone = python_time._calls(frame, 0)
    left = [device.gl.buffer(reserve=4) for _ in range(30)]
    left.append(left)  # ends only by a collection
    del left
    assert python_time._calls(frame, 0) == alone
