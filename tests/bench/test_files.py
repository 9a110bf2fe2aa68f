"""Files of a bench survive interruptions."""

from __future__ import annotations

import pytest

from ssdo_gl.bench import files


def test_lines_are_appended_and_read_back(tmp_path):
    path = tmp_path / "rows.csv"
    assert files.whole_lines(path) == []
    files.append_line(path, "a,1")
    files.append_line(path, "b,2")
    assert files.whole_lines(path) == ["a,1", "b,2"]
    with pytest.raises(ValueError, match="line break"):
        files.append_line(path, "a\nb")


def test_a_torn_last_line_is_cut_off_for_good(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_bytes(b"a,1\nb,2\nc,")
    assert files.whole_lines(path) == ["a,1", "b,2"]
    files.append_line(path, "d,4")
    assert files.whole_lines(path) == ["a,1", "b,2", "d,4"]


def test_a_failed_replacement_keeps_the_old_file(tmp_path):
    path = tmp_path / "report.html"
    files.replace_file(path, b"old")
    with pytest.raises(files.BenchError, match=r"no-such"):
        files.replace_file(tmp_path / "no-such" / "x", b"new")
    files.replace_file(path, b"new")
    assert path.read_bytes() == b"new"
    assert [item.name for item in tmp_path.iterdir()] == ["report.html"]


def test_the_cache_folder_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "here"))
    assert files.cache_folder("truth") == tmp_path / "here" / "truth"
    assert (tmp_path / "here" / "truth").is_dir()
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("SSDO_GL_CACHE", str(blocked))
    with pytest.raises(files.BenchError, match="SSDO_GL_CACHE"):
        files.cache_folder("truth")
