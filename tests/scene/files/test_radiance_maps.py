"""Reading of radiance maps: every value is kept, or mended and said."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from ssdo_gl.scene.environment.environment_kinds import MapEnvironment
from ssdo_gl.scene.files.images import MAX_TEXELS
from ssdo_gl.scene.files.radiance_hdr import decode_hdr
from ssdo_gl.scene.files.radiance_maps import read_radiance_map
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError


def encoded_row(rgbe: np.ndarray) -> bytes:
    """Return a run-length encoded scanline: runs for equal neighbours, else literals."""
    width = len(rgbe)
    data = bytes([2, 2, width >> 8, width & 255])
    for component in rgbe.T:
        column = 0
        while column < width:
            end = column
            while end < width and component[end] == component[column] and end - column < 127:
                end += 1
            data += bytes([128 + end - column, component[column]])
            column = end
    return data


HEADER = b"#?RADIANCE\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n"


@pytest.mark.parametrize("encoded", [True, False])
def test_hdr_round_trip(encoded: bool) -> None:
    rgbe = np.random.default_rng(2).integers(0, 256, (3, 20, 4), dtype=np.uint8)
    rgbe[:, 5:12] = rgbe[:, 5:6]
    rgbe[..., 3] = 130
    rgbe[0, 0] = (50, 60, 70, 0)  # exponent 0 is black
    rgbe[:, 0, 0] = 50  # not the mark of an encoded line
    body = b"".join(encoded_row(row) for row in rgbe) if encoded else rgbe.tobytes()
    image = decode_hdr(HEADER + b"-Y 3 +X 20\n" + body, lambda size: None)
    expected = rgbe[..., :3] / 256.0 * 2.0 ** (130 - 128)
    expected[0, 0] = 0.0
    assert image == pytest.approx(expected, rel=1e-7)
    assert not image[0, 0].any()


def test_literal_stretches_of_a_scanline() -> None:
    literal = bytes([8, 1, 2, 3, 4, 5, 6, 7, 8])
    body = bytes([2, 2, 0, 8]) + literal + bytes([136, 0, 136, 0, 136, 128])
    image = decode_hdr(HEADER + b"-Y 1 +X 8\n" + body, lambda size: None)
    assert image[0, :, 0] == pytest.approx(np.arange(1, 9) / 256.0)


def save_exr(path: Path, channels: dict[str, np.ndarray]) -> Path:
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels) as file:
        file.write(str(path))
    return path


def test_exr_values_are_exact_and_bad_ones_mended(tmp_path: Path) -> None:
    image = np.full((2, 3, 3), 1e6, dtype=np.float32)
    image[0, 0] = (np.nan, 1.0, 2.0)
    image[0, 1] = (np.inf, 1.0, 2.0)
    image[1, 2] = (-4.0, 1.0, 2.0)
    loaded, note = read_radiance_map(save_exr(tmp_path / "a.exr", {"RGB": image}), "here")
    assert loaded.dtype == np.float32
    assert loaded[0, 0].tolist() == [0.0, 1.0, 2.0]
    assert loaded[0, 1].tolist() == [1e6, 1.0, 2.0]
    assert loaded[1, 2].tolist() == [0.0, 1.0, 2.0]
    assert loaded[1, 0].tolist() == [1e6] * 3
    assert note.startswith("a.exr: 3 texels")


def test_exr_with_one_channel_is_grey(tmp_path: Path) -> None:
    path = save_exr(tmp_path / "y.exr", {"Y": np.full((2, 2), 0.25, dtype=np.float32)})
    loaded, note = read_radiance_map(path, "here")
    assert loaded.tolist() == [[[0.25] * 3] * 2] * 2
    assert note == ""


def test_the_same_limit_holds_for_skies(tmp_path: Path) -> None:
    path = tmp_path / "sky.hdr"
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\n")
    with pytest.raises(SceneError, match=f"at most {MAX_TEXELS} in all"):
        read_radiance_map(path, "here")


@pytest.mark.parametrize("scale", [1e15, 3.0])
def test_a_scaled_sky_stays_finite(scale: float, tmp_path: Path) -> None:
    path = tmp_path / "sky.exr"
    image = np.full((2, 4, 3), 0.5, dtype=np.float32)
    image[0, 0] = 3e29
    save_exr(path, {"RGB": image})
    sky, note = read_radiance_map(path, "here", scale)
    assert np.isfinite(sky).all()
    assert sky[1, 1] == pytest.approx(0.5 * scale)
    assert sky.max() <= 1e30
    assert ("1 texels" in note) == (scale == 1e15)


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_maps_that_are_no_files_are_called_what_they_are(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"sky{suffix}"
    with pytest.raises(SceneError, match="here: no such file"):
        read_radiance_map(path, "here")
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n")
    with pytest.raises(SceneError, match="git lfs pull"):
        read_radiance_map(path, "here")
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(SceneError, match="is a pipe or device"):
        read_radiance_map(path, "here")


def test_a_damaged_exr_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "sky.exr"
    image = np.full((64, 64, 3), 0.5, dtype=np.float32)
    save_exr(path, {"RGB": image})
    data = bytearray(path.read_bytes())
    data[-60:] = b"\xff" * 60
    path.write_bytes(data)
    with pytest.raises(SceneError, match=r"'sky\.exr' is not a readable EXR") as caught:
        read_radiance_map(path, "here")
    assert "\n" not in str(caught.value)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_a_scene_may_scale_its_sky(tmp_path: Path) -> None:
    image = np.full((2, 4, 3), 0.5, dtype=np.float32)
    save_exr(tmp_path / "sky.exr", {"RGB": image})
    scene = tmp_path / "a.toml"
    scene.write_text(
        "[environment]\nkind = 'map'\npath = 'sky.exr'\nscale = 4\n"
        "[[object]]\nshape = 'sphere'\nradius = 1\n"
    )
    environment = load_scene(scene).environment
    assert isinstance(environment, MapEnvironment)
    assert environment.image.tolist() == [[[2.0] * 3] * 4] * 2
