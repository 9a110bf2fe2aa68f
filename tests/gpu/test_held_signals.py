"""Signals that arrive while the driver works are answered afterwards, not lost."""

from __future__ import annotations

import signal
import threading

import pytest
from python_process import run_python

from ssdo_gl.gpu.held_signals import held_signals, whole_before_ctrl_c

# Signals at random moments of linking, which takes most of each round. Without holding
# them, the process of the first interrupted link dies of a segmentation fault.
INTERRUPTED_LINKS = """
import random, signal, time
from program_of_text import fullscreen_source
from ssdo_gl.gpu.context import create_context
from ssdo_gl.gpu.shader import ShaderLibrary

device = create_context()
library = ShaderLibrary(device.gl)
uniforms = "".join(f"uniform float u_{i};\\n" for i in range(40))
total = " + ".join(f"u_{i}" for i in range(40))

def link(number):
    fullscreen_source(
        library,
        f"#version 330 core\\n{uniforms}layout(location = 0) out vec4 o_color;\\n"
        f"void main() {{ o_color = vec4({total} + {number}.0); }}\\n"
    )

link(0)
start = time.perf_counter()
link(1)
took = time.perf_counter() - start
signal.signal(signal.SIGALRM, signal.default_int_handler)
random.seed(3)
interrupted = 0
for number in range(2, 152):
    try:
        signal.setitimer(signal.ITIMER_REAL, random.uniform(0.05, 1.0) * took)
        link(number)
        time.sleep(2.0 * took)
    except KeyboardInterrupt:
        interrupted += 1
print(interrupted)
"""


def test_linking_may_be_interrupted() -> None:
    done = run_python("-c", INTERRUPTED_LINKS)
    assert done.returncode == 0, done.stderr
    # Python swallows an exception in a finalizer: not every one comes through.
    assert int(done.stdout) > 100


def test_signal_is_answered_at_the_end_and_the_handler_is_back() -> None:
    seen = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    try:
        handler = signal.getsignal(signal.SIGINT)
        with held_signals():
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            assert seen == []
        assert seen == [signal.SIGINT]
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_interrupt_ends_the_block_as_ever() -> None:
    # Where a shell started the tests in the background, interrupts are ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), held_signals():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("fault", [None, OSError("full")])
def test_interrupt_tells_what_is_done_only_if_it_is(fault: OSError | None) -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt) as told, whole_before_ctrl_c("all is there"):
            signal.raise_signal(signal.SIGINT)
            if fault:
                raise fault
    finally:
        signal.signal(signal.SIGINT, before)
    assert str(told.value) == ("" if fault else "all is there")


def test_other_threads_hold_nothing() -> None:
    faults: list[BaseException] = []

    def run() -> None:
        try:
            with held_signals():
                pass
        except BaseException as error:
            faults.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert faults == []
