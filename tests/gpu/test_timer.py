"""The timer uses the clock that can be trusted; how long things take is not asserted."""

from __future__ import annotations

import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.gpu.timer import Timer


class FakeDevice:
    """A device that records in which order it is asked for what."""

    def __init__(self, is_software):
        self.is_software = is_software
        self.gl = self
        self.calls = []

    def finish(self):
        self.calls.append("finish")

    def query(self, *, time):
        assert time
        device = self

        class Query:
            elapsed = 2_500_000  # ns

            def __enter__(self):
                device.calls.append("begin")

            def __exit__(self, *_):
                device.calls.append("end")

        return Query()


def test_software_is_bracketed_by_finish_and_asks_for_no_query():
    device = FakeDevice(is_software=True)
    timer = Timer(device)
    assert timer.kind == "finish_wall"
    with timer:
        device.calls.append("draw")
    assert device.calls == ["finish", "draw", "finish"]
    assert timer.elapsed_ms >= 0.0


def test_waiting_is_measured_by_the_clock_that_was_chosen():
    timer = Timer(FakeDevice(is_software=True))
    timer.clock = iter([3.0, 3.25]).__next__
    with timer:
        pass
    assert timer.elapsed_ms == 250.0


def test_hardware_is_asked_by_a_query_without_waiting():
    device = FakeDevice(is_software=False)
    timer = Timer(device)
    assert timer.kind == "gl_query"
    with timer:
        device.calls.append("draw")
    assert device.calls == ["begin", "draw", "end"]
    assert timer.elapsed_ms == 2.5


def test_timer_measures_again_and_again(device, gl, shaders):
    program = fullscreen_source(
        shaders,
        "#version 330 core\nlayout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = vec4(1.0); }\n",
    )
    target = make_framebuffer(gl, [make_texture(gl, (64, 64), 4, "f4")])
    timer = Timer(device)
    assert timer.kind == ("finish_wall" if device.is_software else "gl_query")
    for _ in range(2):
        with timer as entered:
            draw_fullscreen(gl, program, target, {}, {})
        assert entered is timer
        assert np.isfinite(timer.elapsed_ms) and timer.elapsed_ms >= 0.0


def test_exception_inside_the_block_ends_it():
    timer = Timer(FakeDevice(is_software=True))
    with pytest.raises(KeyError), timer:
        raise KeyError
    with timer:
        pass
    assert timer.elapsed_ms >= 0.0
