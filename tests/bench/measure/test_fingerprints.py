"""Hashes tell apart what differs and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from ssdo_gl.bench.measure.fingerprints import fingerprint, shader_fingerprint


@dataclass(frozen=True)
class Pair:
    a: object
    b: object = None


@dataclass(frozen=True)
class OtherPair:
    a: object
    b: object = None


DIFFERENT = [
    None, 0, 0.0, False, "0", b"0", "", (), {}, (0,), ((0,),), (0, 0), ("ab", "c"), ("a", "bc"),
    Pair(1), Pair(2), OtherPair(1), Pair(None, 1), {"a": 1}, {"a": 2}, {"b": 1},
    frozenset(), frozenset("a"), frozenset("ab"),
    np.zeros(2), np.zeros(2, dtype=np.float32), np.zeros((2, 1)), np.ones(2), np.zeros(3),
]  # fmt: skip


def test_different_values_have_different_hashes():
    hashes = [fingerprint(value) for value in DIFFERENT]
    assert len(set(hashes)) == len(hashes)


def test_equal_values_have_equal_hashes():
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})
    assert fingerprint(Pair(np.arange(3))) == fingerprint(Pair(np.arange(3)))
    assert fingerprint(frozenset("ab")) == fingerprint(frozenset("ba"))
    base = np.arange(12.0).reshape(3, 4)
    assert fingerprint(base[:, ::2]) == fingerprint(base[:, ::2].copy())


def test_what_is_not_data_is_refused():
    with pytest.raises(TypeError, match="not plain data"):
        fingerprint({"f": print})


def test_shader_files_count_by_prefix():
    assert shader_fingerprint(("gbuffer",)) != shader_fingerprint(("ssao",))
    assert shader_fingerprint(("gbuffer",)) == shader_fingerprint(("gbuffer",))


def test_all_shaders_can_be_hashed_those_that_are_made_included():
    assert shader_fingerprint(("",)) != shader_fingerprint(("effects/",))
    assert shader_fingerprint(("lights",)) == shader_fingerprint(("lights",))


def test_a_shader_file_counts_where_it_is_included(tmp_path, monkeypatch):
    (tmp_path / "lib").mkdir()
    (tmp_path / "a.frag").write_text('#include "lib/used.glsl"\n')
    (tmp_path / "lib" / "used.glsl").write_text('#include "lib/deep.glsl"\n')
    (tmp_path / "lib" / "deep.glsl").write_text("one\n")
    (tmp_path / "lib" / "other.glsl").write_text("one\n")
    monkeypatch.setattr(
        "ssdo_gl.bench.measure.fingerprints.resources.folder", lambda name: tmp_path
    )
    before = shader_fingerprint(("a",))
    (tmp_path / "lib" / "other.glsl").write_text("two\n")
    assert shader_fingerprint(("a",)) == before
    (tmp_path / "lib" / "deep.glsl").write_text("two\n")
    assert shader_fingerprint(("a",)) != before
