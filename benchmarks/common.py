"""What several benchmarks need."""

from __future__ import annotations

import argparse
import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any


def command(name: str, doc: str | None) -> argparse.ArgumentParser:
    """Return the parser of ``python -m benchmarks.NAME``; `doc` is the script's docstring."""
    first, _, rest = (doc or "").partition("\n")
    return argparse.ArgumentParser(
        prog=f"python -m benchmarks.{name}",
        description=first,
        epilog=rest.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


@dataclass(frozen=True)
class FinishedBench:
    """What ``ssdo-gl SCENE --bench FOLDER`` wrote: its points and all else that it found."""

    rows: list[dict[str, str]]
    meta: dict[str, Any]

    @property
    def name(self) -> str:
        """Scene and size."""
        width, height = self.meta["size"]
        return f"{self.meta['scene']} {width}x{height}"


def read_bench(folder: Path) -> FinishedBench:
    """Return the bench that was written into `folder`; exits with a line if there is none."""
    try:
        with (folder / "points.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        meta = json.loads((folder / "bench.json").read_text(encoding="utf-8"))
    except (OSError, ValueError, csv.Error) as error:
        raise SystemExit(f"{folder}: holds no finished bench: {error}") from None
    return FinishedBench(rows, meta)
