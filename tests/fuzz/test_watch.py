"""The fuzz notices what it is there to notice, and does the same twice."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fuzz.damage import damaged
from fuzz.originals import KINDS, of_kind
from fuzz.watch import HangError, address_space, watched


def test_files_outside_the_folder_are_noticed(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    for path in (inside / "a", tmp_path / "b"):
        path.write_text("x")
    (inside / "link").symlink_to(tmp_path / "b")
    with watched(inside, 5.0) as seen:
        (inside / "a").read_text()
        assert seen == []
        (inside / ".." / "b").read_text()
        (inside / "link").read_text()
    assert seen == [f"opened {(tmp_path / 'b').resolve()}"] * 2


def test_programs_are_noticed(tmp_path: Path) -> None:
    with watched(tmp_path, 5.0) as seen:
        subprocess.run([sys.executable, "-c", ""], check=True)
    assert any(fault.startswith("subprocess.Popen") for fault in seen)


def test_hangs_and_hunger_end(tmp_path: Path) -> None:
    with pytest.raises(HangError), watched(tmp_path, 0.05):
        time.sleep(5.0)
    with pytest.raises(MemoryError), address_space(1 << 28):
        bytearray(1 << 29)
    bytearray(1 << 29)


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_says_all(kind: str, tmp_path: Path) -> None:
    originals = of_kind(kind, tmp_path)
    first, again, other = (
        [damaged(originals[0], random.Random(seed)) for seed in range(start, start + 20)]
        for start in (0, 0, 100)
    )
    assert first == again
    assert first != other
    assert sum(files != originals[0] for files in first) >= 15
