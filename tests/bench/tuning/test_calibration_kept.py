"""Measured errors are remembered where they can be, and else used all the same."""

from __future__ import annotations

import json

import pytest

from ssdo_gl.bench.presets import PresetRung
from ssdo_gl.bench.tuning.error_bound import _keep_errors, _kept_errors, candidates

CHOSEN = candidates(("bounce",), [PresetRung("march", 8, 8, 1.0, "none", 1.0, 0.1)])
ERRORS = {CHOSEN[0].label: 0.5}


def test_what_can_be_kept_is_known_again(tmp_path, capsys):
    _keep_errors(tmp_path / "key.json", ERRORS)
    assert _kept_errors(tmp_path / "key.json", CHOSEN) == ERRORS
    assert capsys.readouterr().err == ""


def test_a_file_that_cannot_be_replaced_is_said(tmp_path, capsys):
    (tmp_path / "key.json").mkdir()
    _keep_errors(tmp_path / "key.json", ERRORS)
    (line,) = capsys.readouterr().err.splitlines()
    assert "measured errors are not kept" in line


def test_nothing_is_known_where_nothing_can_be_kept():
    _keep_errors(None, ERRORS)
    assert _kept_errors(None, CHOSEN) is None


@pytest.mark.parametrize("value", ["x", float("nan"), 0.0, True, None])
def test_a_damaged_memory_counts_as_none(tmp_path, value):
    (tmp_path / "key.json").write_text(json.dumps({CHOSEN[0].label: value}))
    assert _kept_errors(tmp_path / "key.json", CHOSEN) is None


@pytest.mark.parametrize("text", ["[1,", "[]", "{}", '{"another": 0.5}'])
def test_a_memory_of_something_else_counts_as_none(tmp_path, text):
    (tmp_path / "key.json").write_text(text)
    assert _kept_errors(tmp_path / "key.json", CHOSEN) is None
