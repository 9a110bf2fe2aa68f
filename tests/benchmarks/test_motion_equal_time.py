"""The bench of equal time in motion: its errors and times are those that were put in."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import motion_equal_time as bench
from benchmarks.motion_errors import CASES

EXTENT = bench.Extent((32, 18), 3, 1)


def test_rows_are_relative_to_averages(monkeypatch) -> None:
    rng = np.random.default_rng(1)
    true = rng.uniform(0.5, 1.5, (3, 18, 32, 3)).astype(np.float32)
    wrong = rng.normal(0.0, 0.05, true.shape).astype(np.float32)
    factors = dict(zip(bench.KINDS, (1.0, 2.0, 4.0, 0.5), strict=True))
    found = {kind: (true + f * wrong, [f, f, 9.0 * f]) for kind, f in factors.items()}
    monkeypatch.setattr(bench, "references", lambda *_: true)
    monkeypatch.setattr(bench, "live", lambda *_: found)
    cells = [[c.strip() for c in row.split("|")] for row in bench.rows(None, "dolly", EXTENT)]
    assert [row[2] for row in cells] == list(bench.KINDS)
    for row, factor in zip(cells, factors.values(), strict=True):
        time, error, share = map(float, row[3:6])
        assert time == pytest.approx(factor, abs=0.01)
        assert error == pytest.approx(0.05 * factor, rel=0.1)
        assert share == pytest.approx(1.0 / factor, abs=0.01)


def test_each_kind_is_the_first_in_turn() -> None:
    orders = [bench.turned(["a", "b", "c"], number) for number in range(3)]
    assert orders == [["a", "b", "c"], ["b", "c", "a"], ["c", "a", "b"]]


def test_only_averages_know_the_frames_before(device, monkeypatch) -> None:
    """In the first judged frame they are those of fewer frames, or of more."""

    def frames(lead):
        monkeypatch.setattr(bench, "LEAD", lead)
        found = bench.live(device, CASES["pan, 1/8 px"], EXTENT)
        assert all(len(spent) == len(images) == 3 for images, spent in found.values())
        return {kind: images for kind, (images, _) in found.items()}

    few, many = frames(2), frames(3)
    # The second judged frame of the one shows what the first of the other does.
    gaps = {kind: np.abs(few[kind][1] - many[kind][0]).max() for kind in bench.KINDS}
    assert all(few[kind].shape == (3, 18, 32, 3) for kind in bench.KINDS)
    assert gaps["single"] == 0.0 and gaps["single, 160 samples"] == 0.0
    gap = np.abs(few[bench.AVERAGED] - few["single, the same rays"]).max()
    assert gap > 0.0
