"""Measured errors are remembered where they can be, and else used all the same."""

from __future__ import annotations

import dataclasses

import pytest

from ssdo_gl.bench.tuning.calibration import Calibrated, Calibration


def test_what_cannot_be_kept_is_said_once(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "file"))
    calibration = Calibration()
    assert calibration.load("key") == {}
    calibration.save("key", {"ms": 1.0})
    calibration.save("key", {"ms": 2.0})
    (line,) = capsys.readouterr().err.splitlines()
    assert "measured errors are not kept" in line and "SSDO_GL_CACHE" in line


def test_a_file_that_cannot_be_replaced_is_said_once(tmp_path, capsys):
    (tmp_path / "key.json").mkdir()
    calibration = Calibration(tmp_path)
    for _ in range(2):
        calibration.save("key", {"ms": 1.0})
    (line,) = capsys.readouterr().err.splitlines()
    assert "measured errors are not kept" in line


def test_what_can_be_kept_is_silent(tmp_path, capsys):
    calibration = Calibration(tmp_path)
    calibration.save("key", {"ms": 1.0})
    assert calibration.load("key") == {"ms": 1.0}
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "text",
    [
        "[1,", "[]", "{}", '{"values": 3}', '{"values": {}, "date": "x"}',
        '{"values": {"march": "x"}, "date": "x"}', '{"values": {"march": NaN}, "date": "x"}',
        '{"values": {"march": 0}, "date": "x"}', '{"values": {"march": 1}, "date": 2}',
    ],
)  # fmt: skip
def test_a_damaged_memory_counts_as_none(tmp_path, text):
    (tmp_path / "key.json").write_text(text)
    assert Calibrated.read(Calibration(tmp_path).load("key")) is None


def test_what_was_kept_is_known_again(tmp_path):
    calibration, known = Calibration(tmp_path), Calibrated.now({"march": 0.5})
    calibration.save("key", dataclasses.asdict(known))
    assert Calibrated.read(calibration.load("key")) == known
