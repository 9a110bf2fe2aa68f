"""How far `gi` and `bounce` are from all light transport, scene by scene.

``make bench-light`` prints Markdown: relMSE, mean error and FLIP against `reference-gi` over the
pixels that count (`docs/accuracy.md`). SCENE is a built-in scene, a scene file, a model, which
is put into a room of boxes, or room-N, a closed room drawn at random by the seed N. The variance
of the paths, known from independent batches, is subtracted from relMSE; FLIP sees their noise.
The last column says how many times the error of `gi` (relMSE) paths have that are traced for as
long as a warm frame of `gi` takes, by processor time; what it prepares once is not counted.
The exit code is 1 if `gi` is worse than `bounce` in any.
"""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.common import answering, check_scenes, command
from benchmarks.rooms import model_room, random_room
from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.errors import color, judged_pixels
from ssdo_gl.bench.measure.reference_cache import Goal, ReferenceCache, obtain
from ssdo_gl.bench.statistics.metrics import flip_ldr, srgb_of
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.images.error import bias, mean_level, relative, relative_mse
from ssdo_gl.options.resolve import resolved
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats import model_suffixes
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

INTERIORS = Path(__file__).parent.parent / "tests" / "effects" / "interiors"
# Never looked at while `gi` was tuned.
SEEDS = range(1, 7)
ROOM = re.compile(r"room-(\d+)")
METHODS = ("bounce", "gi")
BATCH_SPP = 64
# Paths whose time is measured, enough to outweigh what a frame costs beside them; and how often
# that is done in turn with frames of `gi`.
TIMED_SPP = 8
ROUNDS = 3


@dataclass(frozen=True)
class Distance:
    """How far a picture is from all light: relMSE, relative mean error, mean LDR-FLIP."""

    rel_mse: float
    mean_error: float
    flip: float

    def __str__(self) -> str:
        return f"{self.rel_mse:.4f} | {self.mean_error:+.1%} | {self.flip:.3f}"


@dataclass(frozen=True)
class Row:
    """One scene: its distances by method, and what is known of the reference.

    Attributes
    ----------
    standard_error : float
        Of the reference, relative to its mean.
    paths : float
        Paths for each pixel in the time of a warm frame of `gi`.
    paths_rel_mse : float
        relMSE of that many, from their variance: they have no bias.
    """

    name: str
    by_method: dict[str, Distance]
    standard_error: float
    paths: float
    paths_rel_mse: float

    @property
    def equal_time(self) -> float:
        """How many times the error of `gi` paths have in the same time."""
        return self.paths_rel_mse / max(self.by_method["gi"].rel_mse, 1e-9)

    @property
    def is_worse(self) -> bool:
        """Whether `gi` is farther away than `bounce`."""
        return self.by_method["gi"].rel_mse > self.by_method["bounce"].rel_mse


def scene_named(name: str) -> Scene:
    """Return a scene by name, file or seed; exits with a line if there is none."""
    if seed := ROOM.fullmatch(name):
        return random_room(int(seed[1]))
    path = Path(name)
    if path.suffix.lower() in model_suffixes():
        return model_room(path)
    return load_scene(name)


def measure(
    name: str,
    size: tuple[int, int],
    device: Device,
    standard_error: float,
    seconds: float,
    cache: ReferenceCache,
    *,
    whole: bool = False,
) -> Row:
    """Draw a scene by every method and hold the pictures, or the whole of them, to paths."""
    scene = scene_named(name)
    with Renderer(scene, Settings(size=size), device=device) as renderer:
        bench = BenchRenderer(renderer)
        base = renderer.settings
        exposure = base.exposure or 0.0
        judged = judged_pixels(bench, base)
        # In a furnace all that is seen glows.
        mask = judged | (whole or not judged.any())
        traced = dataclasses.replace(base, method="reference-gi", spp=BATCH_SPP)
        goal = Goal("beauty", standard_error, True, seconds)
        reference = obtain(bench, traced, ("beauty",), goal, mask, cache)
        target, variance = color(reference.images["beauty"]), color(reference.variance["beauty"])
        level = mean_level(target, mask)
        found = {}
        for method in METHODS:
            settings = resolved(Settings(method, size=size, exposure=exposure), scene)
            image = color(bench.images(settings, ("beauty",))["beauty"])
            found[method] = Distance(
                relative_mse(image, target, mask, variance),
                relative(bias(image, target, mask), level),
                flip_ldr(srgb_of(image, exposure), srgb_of(target, exposure), mask).mean,
            )
        paths = _paths_in_time(bench, base, traced)
        noise = relative_mse(target + np.sqrt(variance), target, mask)
    return Row(
        name,
        found,
        reference.relative_standard_error("beauty", mask),
        paths,
        noise * reference.spp / paths,
    )


def _paths_in_time(bench: BenchRenderer, base: Settings, traced: Settings) -> float:
    """Return how many paths for a pixel take the processor time of a warm frame of `gi`."""
    rounds = [
        [
            bench.timed(settings, ("beauty",), 2).process_ms
            for settings in (
                dataclasses.replace(base, method="gi", estimator=None),
                dataclasses.replace(traced, spp=TIMED_SPP),
            )
        ]
        for _ in range(ROUNDS)
    ]
    frame, paths = np.median(rounds, axis=0)
    return float(TIMED_SPP * frame / paths)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if `gi` is worse than `bounce` in any scene."""
    parser = command("all_light", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180), metavar=("W", "H"))
    parser.add_argument(
        "--error", type=float, default=0.01, help="standard error of the paths, of the mean"
    )
    parser.add_argument("--seconds", type=float, default=120.0, help="at most, of each scene")
    parser.add_argument("--whole", action="store_true", help="count background and lamps, too")
    arguments = parser.parse_args(argv)
    scenes = arguments.scenes or [
        *builtin_names(),
        *(str(path) for path in sorted(INTERIORS.glob("*.toml")) if path.stem != "wall"),
        *(f"room-{seed}" for seed in SEEDS),
    ]
    check_scenes(name for name in scenes if not ROOM.fullmatch(name))
    size = Settings(size=tuple(arguments.size)).size
    print(
        "| scene | `bounce` | | FLIP | `gi` | | FLIP | noise of the paths |"
        " paths in the time | their error / `gi`'s |"
    )
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    cache, worse = ReferenceCache(), []
    goal = arguments.error, arguments.seconds
    device = create_context("auto")
    try:
        for name in scenes:
            row = measure(name, size, device, *goal, cache, whole=arguments.whole)
            cells = " | ".join(str(row.by_method[method]) for method in METHODS)
            print(f"| {Path(name).stem} | {cells} | {row.standard_error:.1%} |", end="")
            print(f" {row.paths:.2g} | {row.equal_time:.3g} |", flush=True)
            worse += [name] if row.is_worse else []
    finally:
        device.release()
    print("gi is worse than bounce in: " + ", ".join(worse) if worse else "gi is worse in none")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
