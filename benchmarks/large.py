"""What models of millions of triangles take until the first picture, and the hierarchy for rays.

``make bench-large`` runs ``python -m benchmarks.large [COUNT ...]``: a displaced grid of so many
unique triangles is written to a temporary folder and drawn at 320x180, by `direct` and by
`reference-ao` with one ray for each pixel, each in a process of its own.
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.common import answering, command, positive
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

COUNTS = (1_000_000, 4_000_000, 10_000_000)


def write_grid(path: Path, count: int) -> None:
    """Write a PLY file of a rough sheet of at least `count` triangles."""
    side = int(np.ceil(np.sqrt(count / 2)))
    x, y = np.meshgrid(*2 * [np.linspace(0.0, 1.0, side + 1)], indexing="ij")
    z = 0.06 * np.sin(9.0 * x) * np.cos(7.0 * y) + 0.02 * np.sin(61.0 * x) * np.sin(53.0 * y)
    z += 0.1 / side * np.random.default_rng(0).standard_normal(x.shape)
    a = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    b, c, d = a + side + 1, a + side + 2, a + 1
    rows = np.empty(2 * len(a), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    rows["n"] = 3
    rows["corners"] = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {x.size}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(rows)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    vertices = np.stack([x, y, z], axis=-1).astype("<f4")
    path.write_bytes(header.encode() + vertices.tobytes() + rows.tobytes())


def measure(path: Path, method: str) -> tuple[float, float, float]:
    """Return processor seconds, seconds by the wall clock and GiB of a first picture."""
    start, wall = time.process_time(), time.perf_counter()
    with Renderer(load_scene(path), Settings(method=method, size=(320, 180), spp=1)) as renderer:
        renderer.render(["beauty"])
    # Linux counts in KiB, macOS in bytes.
    unit = 2.0**30 if sys.platform == "darwin" else 2.0**20
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    return time.process_time() - start, time.perf_counter() - wall, peak


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Print a row for each number of triangles and method."""
    parser = command("large", __doc__)
    parser.add_argument("counts", nargs="*", type=positive, default=COUNTS, metavar="COUNT")
    options = parser.parse_args(argv)
    table = Table("triangles", "method", "processor s", "wall s", "peak GiB")
    # Forked processes would begin with the memory of this one.
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as folder:
        for count in options.counts:
            path = Path(folder) / "grid.ply"
            write_grid(path, count)
            for method in ("direct", "reference-ao"):
                with context.Pool(1) as pool:
                    numbers = pool.apply(measure, (path, method))
                table.add_row(str(count), method, *(f"{number:.1f}" for number in numbers))
    Console().print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
