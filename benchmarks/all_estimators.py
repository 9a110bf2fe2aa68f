"""Error against time of every estimator, averaged over five scenes.

``make bench-estimators`` runs ``python -m benchmarks.all_estimators OUTDIR``, which writes
what ``ssdo-gl SCENE --bench OUTDIR --estimators`` writes of one scene.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.common import answering, command
from ssdo_gl.bench.estimators import estimator_table
from ssdo_gl.bench.estimators.estimator_views import QUICK as QUICK_PLAN
from ssdo_gl.bench.estimators.estimator_views import TablePlan
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.progress import stage_progress
from ssdo_gl.scene.load import load_scene

SCENES = ("cornell_meso", "stairs", "courtyard", "colonnade", "carousel")
SIZE = (192, 108)


@dataclass(frozen=True)
class ScenesPlan(TablePlan):
    """Built-in scenes, their size, and how much is measured."""

    scenes: Sequence[str] = SCENES
    size: tuple[int, int] = SIZE


QUICK = ScenesPlan(SCENES[:1], (160, 90), **dataclasses.asdict(QUICK_PLAN))


def write(outdir: Path, plan: ScenesPlan, device: Device) -> list[dict[str, Any]]:
    """Measure, write the files of the table and return the rows of its CSV."""
    scenes = {name: load_scene(name) for name in plan.scenes}
    subjects = {
        name: (s, settings_for(s.render, {"size": plan.size})) for name, s in scenes.items()
    }
    with stage_progress(quiet=False) as progress:
        return estimator_table.write(outdir, subjects, plan, device, progress)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and write."""
    parser = command("all_estimators", __doc__)
    parser.add_argument("outdir", type=Path, metavar="OUTDIR")
    parser.add_argument("--quick", action="store_true", help="one scene, one budget: a minute")
    options = parser.parse_args(argv)
    options.outdir.mkdir(parents=True, exist_ok=True)
    device = create_context()
    write(options.outdir, QUICK if options.quick else ScenesPlan(), device)
    device.release()
    print((options.outdir / "estimators.md").read_text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
