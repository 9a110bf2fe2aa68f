"""The whole renderer through every backend: where the same driver draws, the same bytes."""

from __future__ import annotations

import shutil
from ctypes.util import find_library

import numpy as np
import pytest
from python_process import run_python

BACKENDS = [
    pytest.param(
        "osmesa",
        (),
        marks=pytest.mark.skipif(
            find_library("OSMesa") is None, reason="libOSMesa is not installed (libosmesa6)"
        ),
    ),
    pytest.param(
        "window",
        ("xvfb-run", "-a"),
        marks=pytest.mark.skipif(
            shutil.which("xvfb-run") is None, reason="xvfb-run is not installed (xvfb)"
        ),
    ),
]


def arrays(backend, prefix, folder):
    """Return every array that a snapshot through `backend` holds, and its renderer's name."""
    out, stats = folder / f"{backend}.npz", folder / f"{backend}.json"
    command = ["-m", "ssdo_gl", "cornell_meso", "--quiet", "--size", "64x36", "--aov", "all"]
    command += ["--snapshot", str(out), "--stats", str(stats), "--backend", backend]
    answer = run_python(*command, prefix=prefix)
    assert answer.returncode == 0, answer.stderr
    with np.load(out) as file:
        content = {name: file[name] for name in file.files if name != "meta"}
    return content, stats.read_text(encoding="utf-8")


@pytest.mark.parametrize(("backend", "prefix"), BACKENDS)
def test_every_array_is_the_same_through_another_backend(backend, prefix, device, tmp_path):
    if device.backend != "egl":
        pytest.skip("compares with EGL")
    expected, _ = arrays("egl", (), tmp_path)
    result, stats = arrays(backend, prefix, tmp_path)
    if device.renderer not in stats:
        pytest.skip(f"{backend} draws with another driver than {device.renderer}")
    assert result.keys() == expected.keys() and len(result) > 1
    for name, image in expected.items():
        np.testing.assert_array_equal(result[name], image, err_msg=name)
