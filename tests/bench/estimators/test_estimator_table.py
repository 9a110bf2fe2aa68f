"""Every estimator's table: what is compared, and how the best is told."""

from __future__ import annotations

import csv
import dataclasses

import numpy as np
import pytest

from ssdo_gl.bench.estimators import estimator_table, estimator_views
from ssdo_gl.bench.estimators.estimator_table import Averaged, best_splits, table
from ssdo_gl.bench.estimators.estimator_views import QUANTITIES, TablePlan, points_of
from ssdo_gl.bench.measure.points import Point
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.cli import main
from ssdo_gl.settings.estimators import ESTIMATORS, LIGHT_ESTIMATORS


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.aov)
def test_every_estimator_is_measured_with_every_budget_once(quantity):
    points = points_of(TablePlan(budgets=(4, 16), steps=(2, 8)), quantity)
    assert len({point.key for point in points}) == len(points)
    members = list(ESTIMATORS) if quantity.aov == "visibility" else list(LIGHT_ESTIMATORS)
    assert {p.estimator for p in points} == set(members)
    for name in members:
        budgets = {(p.samples, p.filter) for p in points if p.estimator == name}
        assert budgets == {(n, f) for n in (4, 16) for f in ("none", "edge")}
    # Of a slice, 4 reads are 2 each way, however many steps are asked for.
    assert len([p for p in points if p.estimator == "bitmask" and p.samples == 4]) == 2


def row(estimator: str, samples: int, steps: int, error: float, time: float) -> Averaged:
    point = Point("visibility", estimator, "ssao", estimator, samples, steps)
    flat = np.full(8, 1.0)
    return Averaged(point, error, error * flat, 0.1, 0.2, 0.0, time, time * flat)


def test_the_best_split_of_each_budget_is_kept_and_the_front_is_bold():
    rows = [
        row("march", 16, 4, 0.2, 1.0),
        row("march", 16, 8, 0.1, 1.0),
        row("gtao", 16, 4, 0.3, 2.0),
        row("sao", 16, 1, 0.4, 0.5),
    ]
    best = best_splits(rows)
    assert [r.point.steps for r in best] == [8, 4, 1]
    lines = list(table(best))[2:]
    assert [line.split("`")[1] for line in lines] == ["sao", "march", "gtao"]
    assert ["**" in line for line in lines] == [True, True, False]


def test_a_small_table_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(estimator_views, "REFERENCE_SPP", 4)
    quick = dataclasses.replace(estimator_table.QUICK, radii_px=(40.0,), reference_seconds=0.5)
    monkeypatch.setattr(estimator_table, "QUICK", quick)
    size = ["--size", "32x18", "--quick"]
    assert main(["corner", "--bench", str(tmp_path), "--estimators", *size]) == 0
    with (tmp_path / "estimators.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {r["estimator"] for r in rows} == set(ESTIMATORS)
    assert {r["radius_px"] for r in rows} == {"40.0"}
    for r in rows:
        # A fault that the reference's own noise drowns is 0.
        parts = float(r["noise"]) ** 2 + float(r["fault"]) ** 2
        if float(r["fault"]) > 0.0:
            assert parts == pytest.approx(float(r["error"]) ** 2, rel=1e-2, abs=1e-6)
    text = (tmp_path / "estimators.md").read_text()
    # The scene has no light that arrives through open directions.
    assert [text.count(f"### {name}, R of") for name in ("Visibility", "Bounce")] == [2, 2]
    assert text.count("### ") == 4
    lights = [r for r in rows if r["quantity"] == "bounce"]
    assert {r["estimator"] for r in lights} == set(LIGHT_ESTIMATORS)
    assert "32x18; corner; 2 seeds" in text
    assert text in capsys.readouterr().out
    assert (tmp_path / "estimators.png").stat().st_size > 0


def test_light_is_a_multiple_of_the_mean_of_its_reference():
    mask = np.array([[True, True, False]])
    image = np.array([[[2.0] * 3, [6.0] * 3, [99.0] * 3]], np.float32)
    reference = Reference({"bounce": image}, {"bounce": 16.0 * np.ones_like(image)}, 2, 8, 0.0)
    quantity = next(q for q in QUANTITIES if q.aov == "bounce")
    found = estimator_views._normalised(quantity, reference, mask)
    assert found is not None
    relative, level = found
    assert level == 4.0
    assert relative.images["bounce"][0, :2, 0].tolist() == [0.5, 1.5]
    assert np.all(relative.variance["bounce"] == 1.0)
    black = dataclasses.replace(reference, images={"bounce": 0.0 * image})
    assert estimator_views._normalised(quantity, black, mask) is None


@pytest.mark.parametrize(
    "given, words",
    [(["--camera", "0,0,9 0,0,99"], "sees no surface"), (["--radius", "0.1"], "--radius has no")],
)
def test_what_cannot_be_measured_is_refused(given, words, tmp_path, capsys):
    rest = ["--quick", "--quiet", "--size", "32x18"]
    assert main(["corner", "--bench", str(tmp_path), "--estimators", *given, *rest]) == 2
    assert words in capsys.readouterr().err


# Nothing can stand before a point of a body that is convex and alone.
CORNERS = "".join(f"v {x} {y} {z}\n" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
BOX = CORNERS + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


def test_what_blocks_nothing_has_no_table_of_visibility(tmp_path, capsys):
    """No pass runs, so that there is no time; light through open directions is estimated."""
    scene = tmp_path / "box.obj"
    scene.write_text(BOX)
    rest = ["--ground", "off", "--estimators", "--quick", "--quiet", "--size", "32x18"]
    lit, unlit = tmp_path / "lit", tmp_path / "unlit"
    assert main([str(scene), "--bench", str(lit), *rest]) == 0
    table = (lit / "estimators.md").read_text()
    assert "Visibility" not in table and "### Directional" in table
    assert main([str(scene), "--bench", str(unlit), "--light", "file", *rest]) == 2
    assert "nothing in view blocks anything" in capsys.readouterr().err
