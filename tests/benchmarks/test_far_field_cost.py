"""What `gi` takes beside `bounce`: more time once, and more memory."""

from __future__ import annotations

import sys

import pytest

from benchmarks import far_field_cost
from benchmarks.far_field_cost import Cost, cells, nudged, prepared_s
from ssdo_gl.raytracing.content_digest import content_key
from ssdo_gl.scene.load import load_scene


def test_what_is_made_once_is_the_difference_and_memory_is_beyond_the_near_field():
    near, far = Cost(0.25, 100.0, 120.0), Cost(1.5, 160.4, 150.0)
    assert cells(near, far) == ["1.5", "0.2", "+60", "+30"]


def test_the_scene_that_compiles_programs_is_none_of_which_anything_is_kept():
    scene = load_scene("corner")
    other = nudged(scene)
    assert content_key(other) != content_key(scene)
    assert other.bounds()[0] == pytest.approx(scene.bounds()[0])


def test_preparing_all_light_takes_longer_than_the_near_field():
    seconds = {method: prepared_s("corner", method, (32, 18)) for method in ("direct", "gi")}
    assert seconds["gi"] > seconds["direct"] + 0.02


@pytest.mark.skipif(sys.platform == "win32", reason="the system does not tell")
def test_it_prints_a_row_for_each_scene(capsys):
    assert far_field_cost.main(["corner", "--size", "48x27"]) == 0
    out = capsys.readouterr().out
    assert "corner" in out and "prepared, s" in out and "48x27" in out
