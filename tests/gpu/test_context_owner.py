"""A context belongs to one thread of one process, and goes when nobody has it."""

from __future__ import annotations

import gc
import os
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from gpu.test_context import run_python

from ssdo_gl import Renderer, Settings, load_scene
from ssdo_gl.gpu import context_owner
from ssdo_gl.gpu.context import create_context

SMALL = Settings(size=(32, 18), samples=8)
USES: dict[str, Callable[[Renderer], object]] = {
    "render": lambda renderer: renderer.render(),
    "time_frame": lambda renderer: renderer.time_frame(["beauty"]),
    "use": lambda renderer: renderer.use(SMALL),
    "activate": lambda renderer: renderer.device.activate(),
}


@pytest.mark.parametrize("use", [*USES, "release"])
def test_another_thread_is_refused(use: str) -> None:
    with Renderer(load_scene("corner"), SMALL) as renderer:
        before = renderer.render().images["beauty"]
        with ThreadPoolExecutor(1, thread_name_prefix="worker") as pool:
            call = USES.get(use, Renderer.release)
            with pytest.raises(RuntimeError, match=r"'MainThread'.*'worker_0'"):
                pool.submit(call, renderer).result()
        assert np.array_equal(renderer.render().images["beauty"], before)


def test_each_thread_may_have_its_own() -> None:
    def mean() -> float:
        with Renderer(load_scene("corner"), SMALL) as renderer:
            return float(renderer.render().images["beauty"].mean())

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(mean).result() == mean() > 0.0


@pytest.mark.parametrize("use", list(USES))
def test_released_renderer_says_so(use: str) -> None:
    renderer = Renderer(load_scene("corner"), SMALL)
    renderer.release()
    with pytest.raises(RuntimeError, match="was released"):
        USES[use](renderer)
    renderer.release()


def test_released_renderer_of_a_shared_device_says_so(gl, device, shaders) -> None:
    renderer = Renderer(load_scene("corner"), SMALL, device=device, shaders=shaders)
    renderer.release()
    with pytest.raises(RuntimeError, match="was released"):
        renderer.render()
    device.activate()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_forked_process_is_refused() -> None:
    done = run_python(
        "-c",
        """if True:
        import os, signal
        from ssdo_gl import Renderer, Settings, load_scene
        scene, settings = load_scene("corner"), Settings(size=(32, 18), samples=8)
        renderer = Renderer(scene, settings)
        renderer.render()
        child = os.fork()
        if child == 0:
            signal.alarm(20)
            for use in (renderer.render, lambda: Renderer(scene, settings), renderer.release):
                try:
                    use()
                except RuntimeError as error:
                    print(error, flush=True)
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        renderer.release()
        """,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 3
    assert all("forked" in line and "spawn" in line for line in lines)


def test_dropped_renderer_is_freed_with_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    destroyed = []
    destroy = context_owner.destroy_context
    monkeypatch.setattr(
        context_owner,
        "destroy_context",
        lambda gl, close: (destroyed.append(gl), destroy(gl, close)),
    )
    renderer = Renderer(load_scene("corner"), SMALL)
    renderer.render()
    gl = renderer.device.gl
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        del renderer
        gc.collect()
    # Not at that moment, when another context may be at work, but with the next one's.
    assert destroyed == []
    create_context().release()
    assert destroyed[0] is gl
    assert [item.category for item in caught] == [ResourceWarning]
    assert "with Renderer" in str(caught[0].message)


def test_renderer_dropped_in_another_thread_goes_with_the_next_use() -> None:
    kept = [Renderer(load_scene("corner"), SMALL)]

    def drop() -> None:
        kept.clear()
        gc.collect()

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        thread = threading.Thread(target=drop)
        thread.start()
        thread.join()
    assert len(context_owner._dropped) == 1
    with Renderer(load_scene("corner"), SMALL) as renderer:
        renderer.render()
    assert context_owner._dropped == []
