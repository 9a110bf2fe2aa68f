"""The same seed gives the same bytes: again, in another process, through another backend."""

from __future__ import annotations

from ctypes.util import find_library

import numpy as np
import pytest
from hard_cases.backend_images import draw
from hard_cases.hard_scene import room
from hard_cases.methods import METHODS, label, render
from python_process import run_python

# What libraries need to be there for a backend.
NEEDED = {"egl": "EGL", "osmesa": "OSMesa"}


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_the_same_seed_gives_the_same_bytes(device, shaders, record, method):
    first = render(device, shaders, room(), method, seed=7)
    again = render(device, shaders, room(), method, seed=7)
    changed = sum(first[name].tobytes() != again[name].tobytes() for name in first)
    record("same seed: same bytes", label(method), changed, 0, "images changed")


@pytest.mark.parametrize("method", [m for m in METHODS if m[0] in ("ssdo", "bounce")], ids=label)
def test_another_seed_changes_noise_only(device, shaders, record, method):
    first = render(device, shaders, room(), method, seed=1)["beauty"]
    other = render(device, shaders, room(), method, seed=2)["beauty"]
    assert not np.array_equal(first, other)
    gap = abs(float(first.mean() - other.mean())) / float(first.mean())
    # 3072 pixels of 4 directions: three standard deviations of the mean.
    record("another seed", label(method), gap, 0.005, "rel. mean")


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Return a function: backend -> arrays that a process of its own drew."""
    folder = tmp_path_factory.mktemp("backends")

    def arrays(backend):
        if find_library(NEEDED[backend]) is None:
            pytest.skip(f"lib{NEEDED[backend]} is not installed")
        path = folder / f"{backend}.npz"
        if not path.exists():
            answer = run_python("-m", "hard_cases.backend_images", backend, str(path))
            assert answer.returncode == 0, answer.stderr
        with np.load(path) as file:
            return {name: file[name] for name in file.files}

    return arrays


def compare(record, case, a, b):
    """Record how many images of each method differ between two sets of arrays."""
    assert a.keys() == b.keys()
    for method in METHODS:
        names = [name for name in a if name.startswith(f"{label(method)}/")]
        assert names
        changed = sum(a[name].tobytes() != b[name].tobytes() for name in names)
        record(case, label(method), changed, 0, "images changed")


def test_processes_agree(device, shaders, drawn, record):
    """Nothing hangs on addresses, on Python's hash seed or on what ran before."""
    if device.backend not in NEEDED:
        pytest.skip("draws with a window")
    compare(record, "processes agree", draw(device, shaders), drawn(device.backend))


def test_egl_and_osmesa_agree(drawn, record):
    egl, osmesa = drawn("egl"), drawn("osmesa")
    if egl["renderer"] != osmesa["renderer"]:
        pytest.skip("EGL and OSMesa draw with different drivers")
    compare(record, "EGL and OSMesa agree", egl, osmesa)
