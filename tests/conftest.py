"""Fixtures that every test may use: an OpenGL device and the shipped shaders."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hypothesis
import moderngl
import pytest

from ssdo_gl.frame_loop import FrameLoop
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.shader import ShaderLibrary

HERE = Path(__file__).parent
# Folders whose tests look at pictures, not at devices; those of hard cases name the device.
PICTURES = {"effects", "passes", "properties", "scene"}
pytest_plugins = ["hard_cases.table"]

# A deadline would be a timing assertion, on machines that others use as well. The same
# examples every time: a failure can be repeated, and a success means the same tomorrow.
hypothesis.settings.register_profile("repeatable", deadline=None, derandomize=True)
hypothesis.settings.load_profile("repeatable")
# Examples would hold constants of whichever local modules are loaded: an edit anywhere, and which
# tests run before a test, would change them. Versions before 6.131 do not look for any.
with contextlib.suppress(ImportError, AttributeError):
    from hypothesis.internal.conjecture import providers

    NO_CONSTANTS = type(providers._local_constants)()
    providers._get_local_constants = lambda: NO_CONSTANTS


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--backend",
        default="auto",
        choices=("auto", "egl", "osmesa", "window"),
        help="which OpenGL backend the tests draw with",
    )
    parser.addoption(
        "--computes",
        action="store_true",
        help="run full-screen shaders as compute shaders, whichever way is faster",
    )
    parser.addoption("--fuzz-seed", type=int, default=0, help="which files tests/fuzz damages how")
    parser.addoption("--fuzz-count", type=int, default=1000, help="how many files of each kind")


@pytest.fixture(scope="session")
def device(request: pytest.FixtureRequest) -> Iterator[Device]:
    """The one OpenGL context of the test run."""
    device = create_context(request.config.getoption("--backend"))
    if request.config.getoption("--computes"):
        device.computes = True
    yield device
    device.release()


@pytest.fixture(autouse=True)
def _device_is_current(request: pytest.FixtureRequest) -> None:
    """Let tests that draw with the one device find it current, whatever others made since."""
    if "device" in request.fixturenames:
        request.getfixturevalue("device").activate()


@pytest.fixture(scope="session")
def shaders(device: Device) -> ShaderLibrary:
    """The shipped shaders; programs stay compiled for the whole run."""
    return ShaderLibrary(device.gl, computes=device.computes)


@pytest.fixture(scope="module")
def _picture_device(request: pytest.FixtureRequest) -> Iterator[dict[str, Device | ShaderLibrary]]:
    """A context for the pictures of a file, and its programs; released, so that memory is."""
    device = create_context(request.config.getoption("--backend"))
    if request.config.getoption("--computes"):
        device.computes = True
    yield {"device": device, "shaders": ShaderLibrary(device.gl, computes=device.computes)}
    device.release()


@pytest.fixture(autouse=True)
def _renderers_share_a_device(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Give renderers `device` and `shaders` of their file, where a test gives neither.

    Here, and not in each test, because `ssdo_gl.render` and helpers make renderers, too. One
    device for a whole run would keep the programs of all files.
    """
    if request.path.relative_to(HERE).parts[0] not in PICTURES:
        return
    begin = FrameLoop.__init__

    def shared(self: FrameLoop, *arguments: Any, **options: Any) -> None:
        is_plain = not options.get("device") and not options.get("shaders")
        if is_plain and options.get("backend", "auto") == "auto":
            options |= request.getfixturevalue("_picture_device")
        begin(self, *arguments, **options)

    monkeypatch.setattr(FrameLoop, "__init__", shared)


@pytest.fixture
def computing(device: Device) -> ShaderLibrary:
    """Shaders of a device that runs compute shaders the faster."""
    if device.gl.version_code < 450:
        pytest.skip("this driver has no compute shaders")
    return ShaderLibrary(device.gl, computes=True)


@pytest.fixture(params=["rasterizer", "compute shaders"])
def shaders_either_way(request: pytest.FixtureRequest, device: Device) -> ShaderLibrary:
    """Of a device that is the faster for the one, and for the other."""
    if request.param == "rasterizer":
        return ShaderLibrary(device.gl)
    return request.getfixturevalue("computing")


@pytest.fixture
def gl(device: Device) -> Iterator[moderngl.Context]:
    """The context in its first state, with no OpenGL error pending before or after the test."""
    # Another test may have made, and released, a context of its own.
    device.activate()
    device.gl.enable_only(moderngl.NOTHING)
    device.gl.depth_func = "<"
    device.gl.cull_face = "back"
    device.gl.front_face = "ccw"
    device.gl.wireframe = False
    assert device.gl.error == "GL_NO_ERROR", "an earlier test left an OpenGL error"
    yield device.gl
    assert device.gl.error == "GL_NO_ERROR", "this test caused an OpenGL error"
