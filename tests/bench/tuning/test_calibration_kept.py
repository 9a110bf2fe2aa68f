"""Measured times are remembered where they can be, and else used all the same."""

from __future__ import annotations

from ssdo_gl.bench.tuning.calibration import Calibration


def test_what_cannot_be_kept_is_said_once(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "file"))
    calibration = Calibration()
    assert calibration.load("key") == {}
    calibration.save("key", {"ms": 1.0})
    calibration.save("key", {"ms": 2.0})
    (line,) = capsys.readouterr().err.splitlines()
    assert "measured times and errors are not kept" in line and "SSDO_GL_CACHE" in line


def test_a_file_that_cannot_be_replaced_is_said_once(tmp_path, capsys):
    (tmp_path / "key.json").mkdir()
    calibration = Calibration(tmp_path)
    for _ in range(2):
        calibration.save("key", {"ms": 1.0})
    (line,) = capsys.readouterr().err.splitlines()
    assert "measured times and errors are not kept" in line


def test_what_can_be_kept_is_silent(tmp_path, capsys):
    calibration = Calibration(tmp_path)
    calibration.save("key", {"ms": 1.0})
    assert calibration.load("key") == {"ms": 1.0}
    assert capsys.readouterr().err == ""
