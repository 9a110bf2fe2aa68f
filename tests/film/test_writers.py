"""Files of films: complete, in order, or not there at all."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ssdo_gl.film import writers as film_files
from ssdo_gl.film.writers import film_writer
from ssdo_gl.images.files import OutputError

SIZE = (31, 18)
RATE = 10.0


def frames(count: int) -> list[np.ndarray]:
    """Pictures of one brightness each, so that their order can be told."""
    return [np.full((18, 31, 3), 20 * i + 10, np.uint8) for i in range(count)]


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_animation_holds_all_frames_in_order(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"walk{suffix}"
    writer = film_writer(out, RATE)
    for frame in frames(5):
        writer.add(frame)
        assert not out.exists()
    writer.finish()
    with Image.open(out) as image:
        assert (image.size, image.n_frames, image.info["loop"]) == (SIZE, 5, 0)
        for i in range(5):
            image.seek(i)
            image.load()
            assert image.info["duration"] == 100
            # Lossy; a step between two frames is 20.
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - (20 * i + 10)).max() < 6


def test_without_imageio_ffmpeg_the_message_names_it_and_what_goes_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(OutputError, match=r"pip install 'ssdo_gl\[film\]'.*\.webp"):
        film_writer(tmp_path / "walk.mp4", RATE)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("suffix", "unit_ms", "rate"), [(".gif", 10, 30.0), (".webp", 1, 60.0)])
def test_an_animation_lasts_as_long_as_its_frames(
    tmp_path: Path, suffix: str, unit_ms: int, rate: float
) -> None:
    """Though its clock has no unit for a thirtieth of a second."""
    out = tmp_path / f"walk{suffix}"
    writer = film_writer(out, rate)
    for frame in frames(10):
        writer.add(frame)
    writer.finish()
    ends = [0]
    with Image.open(out) as image:
        for i in range(10):
            image.seek(i)
            image.load()
            ends.append(ends[-1] + image.info["duration"])
    assert np.abs(np.array(ends) - np.arange(11) * 1000.0 / rate).max() <= unit_ms / 2


@pytest.mark.parametrize(
    ("name", "rate", "said"),
    [
        ("a.gif", 60.0, r"\.gif shows 0\.0015 to 50 frames per second, not 60 \(--fps\)"),
        ("a.gif", 0.001, r"\.gif shows 0\.0015 to 50 frames"),
        ("a.webp", 120.0, r"\.webp shows 6e-05 to 90\.9 frames"),
    ],
)
def test_rates_that_no_browser_plays_are_refused(
    tmp_path: Path, name: str, rate: float, said: str
) -> None:
    with pytest.raises(OutputError, match=said):
        film_writer(tmp_path / name, rate)


def test_an_animation_of_frames_that_last_too_long_together_is_refused(tmp_path: Path) -> None:
    """Those that are equal become one."""
    writer = film_writer(tmp_path / "walk.gif", 0.002)
    for _ in range(2):
        writer.add(frames(1)[0])
    with pytest.raises(OutputError, match=r"walk\.gif: cannot be encoded"):
        writer.finish()
    assert list(tmp_path.iterdir()) == []


FULL = "echo '[out#0/mp4 @ 0x5] No room' >&2; exit 228"
ENCODERS = {
    "a part of it": (f"head -c 5000 >/dev/null; {FULL}", "No room"),
    "all of it": (f"cat >/dev/null; {FULL}", "No room"),
    "nothing": ("exit 0", "ffmpeg ended before the film"),
    "more than fits": ("trap '' XFSZ; ulimit -f 1; exec {ffmpeg} \"$@\"", "File too large"),
}


@pytest.mark.parametrize("takes", ENCODERS)
def test_what_is_not_encoded_whole_is_no_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, takes: str
) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    script, said = ENCODERS[takes]
    program = tmp_path / "encoder"
    program.write_text(f"#!/bin/sh\n{script.format(ffmpeg=ffmpeg)}\n")
    program.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(program))
    out = tmp_path / "walk.mp4"
    out.write_bytes(b"an older film")
    writer = film_writer(out, RATE)
    noise = np.random.default_rng(0)
    with pytest.raises(OutputError, match=rf"walk\.mp4: .*{said}"):
        for _ in range(32):  # more than a pipe holds
            writer.add(noise.integers(0, 255, (36, 64, 3), np.uint8))
        writer.finish()
    writer.discard()
    assert out.read_bytes() == b"an older film"
    assert {path.name for path in tmp_path.iterdir()} == {"encoder", "walk.mp4"}


# imageio-ffmpeg leaves the pipes to its process to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_film_holds_all_frames_in_order(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    out = tmp_path / "walk.mp4"
    writer = film_writer(out, RATE)
    for frame in frames(5):
        writer.add(frame)
    assert not out.exists()
    writer.finish()
    reader = ffmpeg.read_frames(str(out))
    meta = next(reader)
    # Odd sides lose a line.
    assert meta["size"] == (30, 18)
    assert meta["fps"] == RATE
    levels = [np.frombuffer(data, np.uint8).mean() for data in reader]
    assert np.abs(np.array(levels) - [10, 30, 50, 70, 90]).max() < 6
    assert list(tmp_path.iterdir()) == [out]


def test_sequence_is_a_folder_of_numbered_pictures(tmp_path: Path) -> None:
    writer = film_writer(tmp_path / "walk.png", RATE)
    for frame in frames(3):
        writer.add(frame)
    assert not (tmp_path / "walk").exists()
    writer.finish()
    names = sorted(p.name for p in (tmp_path / "walk").iterdir())
    assert names == ["0001.png", "0002.png", "0003.png"]
    with Image.open(tmp_path / "walk" / "0003.png") as image:
        assert np.asarray(image).max() == 50
    with pytest.raises(OutputError, match="walk: exists already"):
        film_writer(tmp_path / "walk.png", RATE)


@pytest.mark.parametrize("suffix", film_files.FILM_SUFFIXES)
def test_discarded_film_leaves_no_trace(tmp_path: Path, suffix: str) -> None:
    writer = film_writer(tmp_path / f"walk{suffix}", RATE)
    writer.add(frames(1)[0])
    writer.discard()
    assert list(tmp_path.iterdir()) == []


def test_impossible_films_are_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="suffix"):
        film_writer(tmp_path / "walk.avi", RATE)
    with pytest.raises(OutputError, match="does not exist"):
        film_writer(tmp_path / "nowhere" / "walk.webp", RATE)
