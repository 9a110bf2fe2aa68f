"""Fixtures that every test may use: an OpenGL device and the shipped shaders."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import pytest

from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.shader import ShaderLibrary


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--backend",
        default="auto",
        choices=("auto", "egl", "osmesa", "window"),
        help="which OpenGL backend the tests draw with",
    )


@pytest.fixture(scope="session")
def device(request: pytest.FixtureRequest) -> Iterator[Device]:
    """The one OpenGL context of the test run."""
    device = create_context(request.config.getoption("--backend"))
    yield device
    device.release()


@pytest.fixture(scope="session")
def shaders(device: Device) -> ShaderLibrary:
    """The shipped shaders; programs stay compiled for the whole run."""
    return ShaderLibrary(device.gl)


@pytest.fixture
def gl(device: Device) -> Iterator[moderngl.Context]:
    """The context, with no OpenGL error pending before the test nor left by it."""
    assert device.gl.error == "GL_NO_ERROR", "an earlier test left an OpenGL error"
    yield device.gl
    assert device.gl.error == "GL_NO_ERROR", "this test caused an OpenGL error"
