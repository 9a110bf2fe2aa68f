"""Files are written whole or not at all, and are the same bytes every time."""

from __future__ import annotations

import json
import os

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from ssdo_gl.images.files import (
    OutputError,
    check_output,
    exr_bytes,
    npz_bytes,
    png_bytes,
    write_atomically,
)


def some_images():
    rng = np.random.default_rng(5)
    return {
        "beauty": rng.random((3, 5, 4)).astype(np.float32) * 1e6,
        "depth": rng.random((3, 5, 1)).astype(np.float32),
        "normal_ws": rng.random((3, 5, 3)).astype(np.float32) - 0.5,
    }


def test_npz_holds_float32_arrays_and_meta(tmp_path):
    path = tmp_path / "a.npz"
    path.write_bytes(npz_bytes(some_images(), {"size": [5, 3]}))
    with np.load(path) as file:
        assert json.loads(str(file["meta"])) == {"size": [5, 3]}
        for name, image in some_images().items():
            assert file[name].dtype == np.float32
            np.testing.assert_array_equal(file[name], image)


def test_npz_bytes_are_reproducible():
    assert npz_bytes(some_images(), {"a": 1}) == npz_bytes(some_images(), {"a": 1})


def test_exr_layers_round_trip(tmp_path):
    path = tmp_path / "a.exr"
    path.write_bytes(exr_bytes(some_images(), {"size": [5, 3]}))
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        for key, expected in {
            "R": some_images()["beauty"][:, :, 0],
            "A": some_images()["beauty"][:, :, 3],
            "depth.V": some_images()["depth"][:, :, 0],
            "normal_ws.Z": some_images()["normal_ws"][:, :, 2],
        }.items():
            np.testing.assert_array_equal(channels[key].pixels, expected)


def test_png_keeps_row_zero_at_the_top(tmp_path):
    pixels = np.zeros((4, 2, 3), np.uint8)
    pixels[0] = (255, 10, 0)
    path = tmp_path / "a.png"
    path.write_bytes(png_bytes(pixels))
    with Image.open(path) as image:
        assert image.size == (2, 4)
        assert image.getpixel((0, 0)) == (255, 10, 0)
        assert image.getpixel((0, 3)) == (0, 0, 0)


def test_a_failing_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "kept.png"
    path.write_bytes(b"old")
    monkeypatch.setattr(
        "pathlib.Path.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left"))
    )
    with pytest.raises(OutputError, match="No space left"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["kept.png"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("a.tif", "suffix must be one of .png, .jpg, .jpeg, .webp, .exr, .npz"),
        ("nowhere/a.png", "does not exist"),
        ("file.png/a", "file.png is a file, no folder"),
        ("file.png/a.png", "file.png is a file, no folder"),
        ("folder.png", "is a folder"),
        ("a" * 252 + ".png", "cannot be written: File name too long"),
        ("a" * 256 + "/a.png", "does not exist"),
    ],
)
def test_outputs_that_cannot_be_written_are_refused_before_rendering(tmp_path, name, said):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file.png").touch()
    with pytest.raises(OutputError, match=said):
        check_output(tmp_path / name)


def test_the_longest_name_is_written(tmp_path):
    path = tmp_path / ("a" * 251 + ".png")
    check_output(path)
    write_atomically(path, b"new")
    assert [p.read_bytes() for p in tmp_path.iterdir()] == [b"new"]


def test_a_link_stays_and_its_target_is_written(tmp_path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "a.png", tmp_path / "b.png"
    for content in (None, b"old"):
        if content is not None:
            target.write_bytes(content)
        if not link.is_symlink():
            link.symlink_to(target)
        check_output(link)
        write_atomically(link, b"new")
        assert link.is_symlink() and target.read_bytes() == b"new"


@pytest.mark.parametrize("name", ["pipe.png", "link.png"])
def test_pipes_and_devices_are_neither_replaced_nor_waited_for(tmp_path, name):
    """A link to /dev/null made a picture of /dev/null, for everything on the machine."""
    pipe, path = tmp_path / "pipe.png", tmp_path / name
    os.mkfifo(pipe)
    if path != pipe:
        path.symlink_to(pipe)
    for write in (check_output, lambda output: write_atomically(output, b"new")):
        with pytest.raises(OutputError, match="is a pipe or a device"):
            write(path)
    assert pipe.is_fifo()
    assert len(list(tmp_path.iterdir())) == 1 + (path != pipe)


def test_a_link_into_a_folder_that_is_missing_is_refused(tmp_path):
    link = tmp_path / "b.png"
    link.symlink_to(tmp_path / "nowhere" / "a.png")
    with pytest.raises(OutputError, match="does not exist"):
        check_output(link)
