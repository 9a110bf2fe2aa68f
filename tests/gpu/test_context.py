"""Contexts: every backend draws the same, and what cannot work says why in one line."""

from __future__ import annotations

import shutil
import sys
from ctypes.util import find_library
from pathlib import Path

import numpy as np
import pytest
from gpu.triangle import COLOR, CORNERS_NDC, SIZE, draw_triangle
from python_process import run_python

from ssdo_gl.gpu import context
from ssdo_gl.gpu.context import BACKENDS, ContextError, Device, create_context, describe

NEEDS_OSMESA = pytest.mark.skipif(
    find_library("OSMesa") is None, reason="libOSMesa is not installed (Debian: libosmesa6)"
)
NEEDS_XVFB = pytest.mark.skipif(
    shutil.which("xvfb-run") is None, reason="xvfb-run is not installed (Debian: xvfb)"
)


def expected_triangle() -> np.ndarray:
    """Which pixel centres lie inside, by the signs of three edge functions."""
    x, y = np.meshgrid(
        2 * (np.arange(SIZE[0]) + 0.5) / SIZE[0] - 1, 1 - 2 * (np.arange(SIZE[1]) + 0.5) / SIZE[1]
    )
    inside = np.ones_like(x, dtype=bool)
    for i in range(3):
        (ax, ay), (bx, by) = CORNERS_NDC[i], CORNERS_NDC[(i + 1) % 3]
        inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0
    return inside[..., None] * np.array(COLOR, np.float32)


def test_triangle_covers_the_pixel_centres_inside_it(device):
    np.testing.assert_array_equal(draw_triangle(device), expected_triangle())


@pytest.mark.parametrize(
    ("backend", "prefix"),
    [
        pytest.param("osmesa", (), marks=NEEDS_OSMESA),
        pytest.param("window", ("xvfb-run", "-a"), marks=NEEDS_XVFB),
    ],
)
def test_other_backends_draw_the_same_triangle(backend, prefix, tmp_path):
    script = Path(__file__).with_name("triangle.py")
    answer = run_python(str(script), backend, str(tmp_path / "out.npy"), prefix=prefix)
    assert answer.returncode == 0, answer.stderr
    np.testing.assert_array_equal(np.load(tmp_path / "out.npy"), expected_triangle())


def test_device_says_what_it_is(device):
    assert device.backend in BACKENDS[1:]
    report = describe(device)
    assert report["renderer"] == device.renderer != ""
    assert report["gl_version"] == device.version
    # The least that OpenGL 3.3 allows.
    assert report["limits"]["texture_size"] >= 1024
    assert report["limits"]["texture_units"] >= 16
    assert report["limits"]["color_attachments"] >= 8


@pytest.mark.parametrize(
    ("renderer", "is_software"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("softpipe", True),
        ("Google SwiftShader", True),
        ("Apple Software Renderer", True),
        ("NVIDIA H200/PCIe/SSE2", False),
        ("AMD Radeon RX 7900 XTX (radeonsi, navi31)", False),
        ("Mesa Intel(R) UHD Graphics 630 (CFL GT2)", False),
        ("Apple M2", False),
    ],
)
def test_software_renderers_are_known_by_name(renderer, is_software):
    class Context:
        info = {"GL_RENDERER": renderer, "GL_VERSION": "4.5", "GL_VENDOR": ""}  # noqa: RUF012
        gc_mode = None

    assert Device(Context(), "egl").is_software == is_software


def test_unknown_backend_names_the_known_ones():
    with pytest.raises(ContextError, match=r"'vulkan': choose auto, egl, osmesa, window"):
        create_context("vulkan")


IMPOSSIBLE = {
    "egl": {"GLCONTEXT_LINUX_LIBEGL": "/nonexistent/libEGL.so"},
    "egl-no-driver": {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"},
    "egl-old": {"MESA_GL_VERSION_OVERRIDE": "2.1"},
    "window": {"DISPLAY": "", "WAYLAND_DISPLAY": "", "XDG_SESSION_TYPE": ""},
}


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="breaks EGL the Linux way")
@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_impossible_backend_is_one_readable_line(device, case):
    if case == "egl-old" and not device.is_software:
        pytest.skip("only Mesa can be told to be old")
    backend = case.partition("-")[0]
    code = (
        "from ssdo_gl.gpu.context import ContextError, create_context\n"
        f"try:\n    create_context({backend!r})\n"
        "except ContextError as error:\n    print(error)\n"
    )
    answer = run_python("-c", code, **IMPOSSIBLE[case])
    assert answer.returncode == 0, answer.stderr
    # Mesa may have its say there, but neither Python nor GLFW's warnings.
    assert "Traceback" not in answer.stderr and "GLFWError" not in answer.stderr
    lines = answer.stdout.splitlines()
    assert len(lines) == 1, answer.stdout
    assert f"({backend}: " in lines[0]
    for package in ("libegl1", "libgl1", "libgl1-mesa-dri", "libosmesa6"):
        assert package in lines[0]


def failing(message):
    def make():
        raise OSError(message)

    return make


def test_auto_tries_egl_then_osmesa_then_a_window(monkeypatch):
    monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
    monkeypatch.setattr(context, "_create_egl", failing("no\n  EGL"))
    monkeypatch.setattr(context, "_create_osmesa", failing("no OSMesa"))
    monkeypatch.setattr(context, "_create_hidden_window", failing("no display"))
    with pytest.raises(ContextError, match=r"\(egl: no EGL; osmesa: no OSMesa; window: no disp"):
        create_context()


def test_auto_falls_back_where_egl_does_not_work(monkeypatch, device):
    monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
    monkeypatch.setattr(context, "_create_egl", failing("no EGL"))
    monkeypatch.setattr(context, "_create_osmesa", lambda: Device(device.gl, "osmesa"))
    made = create_context("auto")
    assert made.backend == "osmesa"


def test_a_chosen_egl_device_is_never_replaced_by_another_backend(monkeypatch):
    monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", "97")
    monkeypatch.setattr(context, "_create_osmesa", lambda: pytest.fail("fell back"))
    with pytest.raises(ContextError, match="egl"):
        create_context("auto")


def test_device_index_reaches_egl():
    if find_library("EGL") is None or find_library("GL") is None:
        pytest.skip("EGL is not installed")
    code = (
        "from ssdo_gl.gpu.context import ContextError, create_context\n"
        "try:\n    create_context('egl')\n"
        "except ContextError as error:\n    print(error)\n"
    )
    answer = run_python("-c", code, GLCONTEXT_DEVICE_INDEX="97")
    assert "device index 97" in answer.stdout


TWO_DEVICES = """
import sys
import numpy as np
from gpu.triangle import draw_triangle
from ssdo_gl.gpu.context import create_context
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.gpu.texture import make_texture

first, second = create_context(sys.argv[1]), create_context(sys.argv[1])
pictures = []
for device in (first, second, first):
    device.activate()
    pictures.append(draw_triangle(device))
assert all((picture == pictures[0]).all() and picture.any() for picture in pictures)

# Both drivers count names from 1, so the two textures bear the same name.
first.activate()
dropped = make_texture(first.gl, (1, 1), 1, "f4", [[[1.0]]])
second.activate()
kept = make_texture(second.gl, (1, 1), 1, "f4", [[[2.0]]])
del dropped
assert read_texture(kept) == 2.0 and second.gl.error == "GL_NO_ERROR"
first.activate()
first.release()
second.activate()
assert read_texture(kept) == 2.0 and second.gl.error == "GL_NO_ERROR"
second.release()
"""


@pytest.mark.parametrize("backend", ["egl", pytest.param("osmesa", marks=NEEDS_OSMESA)])
def test_two_devices_live_side_by_side(backend):
    if backend == "egl" and find_library("EGL") is None:
        pytest.skip("EGL is not installed")
    answer = run_python("-W", "error", "-c", TWO_DEVICES, backend)
    assert answer.returncode == 0, answer.stderr


@NEEDS_OSMESA
@NEEDS_XVFB
@pytest.mark.parametrize(
    ("first", "second", "kind"), [("osmesa", "window", "without"), ("window", "osmesa", "with")]
)
def test_glfw_serves_one_kind_of_platform_at_a_time(first, second, kind):
    code = (
        "from ssdo_gl.gpu.context import ContextError, create_context\n"
        f"device = create_context({first!r})\n"
        f"try:\n    create_context({second!r})\n"
        "except ContextError as error:\n    print(error)\n"
        "device.activate()\n"
        "device.release()\n"
        f"create_context({second!r}).release()\n"  # free again once the other is gone
    )
    answer = run_python("-W", "error", "-c", code, prefix=("xvfb-run", "-a"))
    assert answer.returncode == 0, answer.stderr
    assert f"GLFW is already in use {kind} a display" in answer.stdout


def test_dropped_objects_are_freed_by_activate(device, gl):
    texture = gl.texture((4, 4), 4)
    buffer = gl.buffer(reserve=4)
    buffer.release()
    del texture, buffer
    assert len(gl.objects) == 2, "one to free, one that was freed already"
    device.activate()
    assert len(gl.objects) == 0


def test_second_release_does_nothing():
    class Context:
        info = {"GL_RENDERER": "", "GL_VERSION": "", "GL_VENDOR": ""}  # noqa: RUF012
        gc_mode = None

        def release(self):
            calls.append("context")

    calls = []
    device = Device(Context(), "window", lambda: calls.append("window"))
    device.release()
    device.release()
    assert calls == ["context", "window"]


def test_objects_may_outlive_the_context():
    code = (
        "from ssdo_gl.gpu.context import create_context\n"
        "for _ in range(2):\n"
        "    device = create_context()\n"
        "    texture = device.gl.texture((4, 4), 4)\n"
        "    device.release()\n"
        "    del texture\n"  # must not call into the dead context
        "print('alive')\n"
    )
    answer = run_python("-W", "error", "-c", code)
    assert answer.stdout.strip() == "alive", answer.stderr
