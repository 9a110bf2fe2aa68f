"""Files of a bench survive interruptions."""

from __future__ import annotations

import hashlib
import io
import os
import random
import sys

import numpy as np
import pytest

from ssdo_gl.bench import storage


def test_lines_are_appended_and_read_back(tmp_path):
    path = tmp_path / "rows.csv"
    assert storage.whole_lines(path) == []
    storage.append_line(path, "a,1")
    storage.append_line(path, "b,2")
    assert storage.whole_lines(path) == ["a,1", "b,2"]


def test_a_torn_last_line_is_cut_off_for_good(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_bytes(b"a,1\nb,2\nc,")
    assert storage.whole_lines(path) == ["a,1", "b,2"]
    storage.append_line(path, "d,4")
    assert storage.whole_lines(path) == ["a,1", "b,2", "d,4"]


def test_a_failed_replacement_keeps_the_old_file(tmp_path):
    path = tmp_path / "report.html"
    storage.replace_file(path, b"old")
    with pytest.raises(storage.BenchError, match=r"no-such"):
        storage.replace_file(tmp_path / "no-such" / "x", b"new")
    storage.replace_file(path, b"new")
    assert path.read_bytes() == b"new"
    assert [item.name for item in tmp_path.iterdir()] == ["report.html"]


def test_the_cache_folder_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "here"))
    assert storage.cache_folder("reference") == tmp_path / "here" / "reference"
    assert (tmp_path / "here" / "reference").is_dir()
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("SSDO_GL_CACHE", str(blocked))
    with pytest.raises(storage.BenchError, match="SSDO_GL_CACHE"):
        storage.cache_folder("reference")


@pytest.mark.skipif(sys.platform == "win32", reason="pwd is of Unix")
def test_a_user_without_a_home_is_told_what_to_set(tmp_path, monkeypatch):
    for name in ("HOME", "SSDO_GL_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)
    with pytest.raises(storage.BenchError, match="set SSDO_GL_CACHE"):
        storage.cache_folder("reference")
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path))
    assert storage.cache_folder("reference") == tmp_path / "reference"


def test_a_folder_becomes_a_bench_once(tmp_path):
    storage.claim_folder(tmp_path / "new" / "bench")
    storage.claim_folder(tmp_path / "new" / "bench")
    assert [item.name for item in (tmp_path / "new" / "bench").iterdir()] == [storage.MARKER]


def test_a_file_is_no_folder_of_a_bench(tmp_path):
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(storage.BenchError, match="notes is a file: name a folder"):
        storage.claim_folder(tmp_path / "notes")


def test_other_files_of_the_user_do_not_matter(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / ".probe").mkdir()
    storage.claim_folder(tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / ".probe").is_dir()


@pytest.mark.parametrize("name", storage.BENCH_FILES)
def test_a_folder_with_files_of_a_bench_s_names_is_refused(tmp_path, name):
    (tmp_path / name).mkdir()
    with pytest.raises(storage.BenchError, match=f"holds {name}, which no bench made"):
        storage.claim_folder(tmp_path)
    assert [item.name for item in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", [storage.MARKER, *storage.BENCH_FILES])
def test_links_are_never_followed(tmp_path, name):
    (tmp_path / "bench").mkdir()
    storage.claim_folder(tmp_path / "bench")
    (tmp_path / "bench" / name).unlink(missing_ok=True)
    (tmp_path / "bench" / name).symlink_to(tmp_path / "theirs")
    with pytest.raises(storage.BenchError, match=name):
        storage.claim_folder(tmp_path / "bench")
    assert not (tmp_path / "theirs").exists()


ARRAYS = {"a": np.arange(6.0).reshape(2, 3), "b": np.ones(4, dtype=np.float32)}


def test_arrays_come_back_as_they_were(tmp_path):
    path = tmp_path / "x.npz"
    storage.save_arrays(path, {"count": 2}, ARRAYS)
    meta, arrays = storage.load_arrays(path)
    assert meta == {"count": 2}
    assert arrays.keys() == ARRAYS.keys()
    assert all((arrays[name] == ARRAYS[name]).all() for name in ARRAYS)


def test_no_damage_goes_unseen(tmp_path):
    path = tmp_path / "x.npz"
    assert storage.load_arrays(path) is None
    storage.save_arrays(path, {"count": 2}, ARRAYS)
    data, rng = path.read_bytes(), random.Random(0)
    for _ in range(300):
        damaged = bytearray(data)
        damaged[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged[: rng.choice((len(data), rng.randrange(len(data))))])
        assert storage.load_arrays(path) is None


class Malicious:
    def __reduce__(self):
        return (open, (self.path, "w"))


def test_nothing_in_a_cache_can_run_code(tmp_path):
    Malicious.path = str(tmp_path / "ran")
    buffer = io.BytesIO()
    np.savez(buffer, meta=np.array("{}"), a=np.array([Malicious()], dtype=object))
    data = buffer.getvalue()
    (tmp_path / "x.npz").write_bytes(data + hashlib.sha256(data).digest())
    assert storage.load_arrays(tmp_path / "x.npz") is None
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("text", ["", "[1,", "[" * 100_000, "\ud800"])
def test_damaged_json_counts_as_none(tmp_path, text):
    (tmp_path / "x.json").write_bytes(text.encode(errors="surrogatepass"))
    assert storage.read_json(tmp_path / "x.json") is None


def test_a_line_that_does_not_fit_is_said_and_taken_back(tmp_path, monkeypatch):
    """A disk that has room for a part of a line takes that part and says nothing."""
    path = tmp_path / "rows.csv"
    storage.append_line(path, "a,1")
    with monkeypatch.context() as full:
        write = os.write
        full.setattr(os, "write", lambda handle, data: write(handle, data[:2]))
        with pytest.raises(storage.BenchError, match=r"rows\.csv: cannot be written: No space"):
            storage.append_line(path, "b,2")
    assert path.read_text() == "a,1\n"
    storage.append_line(path, "c,3")
    assert storage.whole_lines(path) == ["a,1", "c,3"]
