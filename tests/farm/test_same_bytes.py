"""Films and batches on workers have the bytes of one process."""

from __future__ import annotations

from pathlib import Path

import pytest
from farm.film_of_five import FILM, contents

from ssdo_gl.cli import main
from ssdo_gl.farm.scenes import CapturedWork
from ssdo_gl.gpu.warm_device import WarmDevice
from ssdo_gl.options.flags import CommandLine

pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
pytest.importorskip("cloudpickle")

# Dask's own threads and sockets end when it likes, after a test.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.mark.parametrize("out", ["turn", "turn%d.npz", "turn.gif"])
def test_films_have_the_bytes_of_one_process(address: str, tmp_path: Path, out: str) -> None:
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    assert main(["stairs", "--film", str(tmp_path / "here" / out), *FILM]) == 0
    flags = [*FILM, "--scheduler", address]
    assert main(["stairs", "--film", str(tmp_path / "there" / out), *flags]) == 0
    here, there = (tmp_path / name for name in ("here", "there"))
    if out == "turn":
        here, there = here / out, there / out
    assert contents(here) == contents(there)
    assert len(contents(here)) == (1 if out == "turn.gif" else 5)


def test_resume_renders_the_missing_frames(address: str, tmp_path: Path) -> None:
    words = ["stairs", "--film", str(tmp_path / "turn"), *FILM]
    assert main(words) == 0
    whole = contents(tmp_path / "turn")
    (tmp_path / "turn" / "frame_0002.png").unlink()
    (tmp_path / "turn" / "frame_0003.png").write_bytes(b"kept")
    assert main([*words, "--resume", "--scheduler", address]) == 0
    assert contents(tmp_path / "turn") == whole | {"frame_0003.png": b"kept"}


def test_a_batch_has_the_bytes_of_one_process(
    address: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.glb").write_text("junk")
    words = ["--batch", "corner", "*.glb", "stairs", "--size", "48x27", "--method", "direct"]
    assert main([*words, "--out", "here"]) == 2
    said = capsys.readouterr()
    assert main([*words, "--out", "there", "--scheduler", address]) == 2
    assert capsys.readouterr().err == said.err != ""
    whole = contents(tmp_path / "here")
    assert contents(tmp_path / "there") == whole and len(whole) == 2
    (tmp_path / "there" / "stairs.png").unlink()
    (tmp_path / "there" / "corner.png").write_bytes(b"kept")
    assert main([*words, "--out", "there", "--scheduler", address, "--resume"]) == 2
    assert contents(tmp_path / "there") == whole | {"corner.png": b"kept"}


def test_a_worker_draws_a_batch_on_one_device(tmp_path: Path) -> None:
    """Its shaders stay compiled, until a scene leaves it in an unknown state."""
    codes = iter([0, 4, 2, 0])
    seen = []

    def work(command: CommandLine, warm: WarmDevice) -> int:
        seen.append(warm.made("auto")[0])
        return next(codes)

    maker = CapturedWork((work, Path.cwd()))
    assert [maker.make(CommandLine(("x",))).code for _ in range(4)] == [0, 4, 2, 0]
    maker.close()
    assert seen[0] is seen[1] is seen[2] is not seen[3]
