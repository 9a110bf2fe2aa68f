"""The table of pass times holds medians and ratios of what was measured."""

from __future__ import annotations

from benchmarks import pass_times
from ssdo_gl.scene.load import load_scene


def test_ratios_and_gaps():
    times = {
        pass_times.BASELINE: {"frame": 40.0, "gbuffer": 5.0, "bounce": 20.0},
        "direct": {"frame": 10.0, "gbuffer": 5.5},
    }
    lines = pass_times.table(times).splitlines()
    assert lines[2] == "| `gbuffer` | 5.0 | 5.5 |"
    assert lines[3] == "| `bounce` | 20.0 |  |"
    assert lines[-2] == "| whole frame | **40.0** | **10.0** |"
    assert lines[-1] == "| over the baseline | 1.00 | 0.25 |"


def test_every_column_is_measured(monkeypatch):
    monkeypatch.setattr(pass_times, "SIZE", (16, 9))
    scene = load_scene("corner")
    times = pass_times.measure(scene, 1)
    assert list(times) == [name for name, _ in pass_times.columns(scene)]
    assert all(row["frame"] > 0.0 and row["gbuffer"] > 0.0 for row in times.values())
    assert "bounce" in times["bounce"]
    assert "far_probes" in times["gi, the default"]
    assert "bounce" not in times["direct"]
