"""The GPU's script runs unattended: sections fail alone, differences are told apart."""

from __future__ import annotations

import csv
import json
import time

import numpy as np
import pytest

from benchmarks import gpu, gpu_passes
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings


@pytest.fixture
def few_images(monkeypatch):
    monkeypatch.setattr(gpu, "IMAGE_SCENES", ("corner",))
    monkeypatch.setattr(gpu, "IMAGE_METHODS", ("direct", "bounce"))
    monkeypatch.setattr(gpu, "IMAGE_SIZE", (32, 18))


@pytest.mark.usefixtures("few_images")
def test_images_are_compared_with_those_of_another_run(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    assert gpu.main([str(first), "--only", "images"]) == 0
    assert gpu.main([str(second), "--only", "images", "--compare", str(first)]) == 0
    with (second / "differences.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["image"] for row in rows] == ["corner.direct", "corner.bounce"]
    assert {row["looks_like"] for row in rows} == {"equal"}
    with np.load(second / "images.npz") as arrays:
        assert arrays["corner.direct"].shape == (18, 32, 4)
    assert (second / "differences.png").stat().st_size > 0


@pytest.mark.usefixtures("few_images")
def test_a_section_that_fails_says_so_and_the_next_one_runs(tmp_path, monkeypatch):
    monkeypatch.setitem(gpu.SECTIONS, "rays", lambda run: 1 / 0)
    assert gpu.main([str(tmp_path), "--only", "rays,images"]) == 1
    found = json.loads((tmp_path / "gpu.json").read_text())
    assert found["rays"]["result"]["failed"].startswith("ZeroDivisionError")
    assert found["images"]["result"]["images"] == ["corner.bounce", "corner.direct"]


def test_frames_are_timed_by_either_way_and_of_a_window(tmp_path):
    assert gpu.main([str(tmp_path), "--quick", "--only", "frames"]) == 0
    with (tmp_path / "triangles.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["way"] for row in rows] == ["compute shaders", "rasterizer"]
    with (tmp_path / "window.csv").open(newline="") as file:
        rows += list(csv.DictReader(file))
    kinds = [(row["method"], row["frame kind"]) for row in rows[2:]]
    assert kinds == [(m, k) for m in ("bounce", "gi") for k in ("camera moves", "refined")]
    assert all(float(row[name]) > 0.0 for row in rows for name in ("frame", "gbuffer", "direct"))


def test_an_unknown_section_is_named(tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        gpu.main([str(tmp_path), "--only", "ray"])
    assert "'ray'" in capsys.readouterr().err


FAULT = "a fault, or other random numbers"


def image(value: float = 0.5) -> np.ndarray:
    result = np.full((20, 20, 4), value, dtype=np.float32)
    result[:, :, 3] = 1.0
    return result


@pytest.mark.parametrize(
    ("change", "looks_like"),
    [
        (lambda x: x, "equal"),
        (lambda x: x * np.float32(1.000001), "rounding"),
        (lambda x: np.where(np.indices(x.shape).sum(axis=0) == 0, 0.9, x), "ties at edges"),
        (lambda x: 1.1 * x, FAULT),
        (lambda x: np.where(np.indices(x.shape).sum(axis=0) == 0, np.nan, x), FAULT),
    ],
)
def test_differences_are_told_apart(change, looks_like):
    found = gpu.difference("x", change(image()).astype(np.float32), image())
    assert found["looks_like"] == looks_like
    assert (found["max"] == 0.0) == (looks_like == "equal")


def test_a_pass_moves_at_least_what_it_reads_and_writes(device):
    settings = Settings(size=(64, 32), method="direct")
    with Renderer(load_scene("corner"), settings, device=device) as renderer:
        small = gpu_passes.bytes_of_passes(renderer)
    with Renderer(
        load_scene("corner"), Settings(size=(128, 64), method="direct"), device=device
    ) as r:
        large = gpu_passes.bytes_of_passes(r)
    assert small["gbuffer"] > 64 * 32 * 4, "view depth alone takes four bytes a pixel"
    # Half-size targets are rounded up, and everything else follows the frame.
    assert all(large[name] == pytest.approx(4 * small[name], rel=0.05) for name in small)


def test_a_command_that_takes_too_long_is_ended():
    begin = time.monotonic()
    done = gpu._child(["sleep", "60"], 0.2, None)
    assert done.returncode == 124
    assert time.monotonic() - begin < 30.0


def test_bandwidth_is_positive(device):
    assert gpu_passes.copy_bandwidth(device, 64) > 0.0
