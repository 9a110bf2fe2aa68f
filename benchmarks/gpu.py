"""What a GPU does: tests, pass times beside bandwidth floors, rays, images against llvmpipe.

``make bench-gpu`` runs ``python -m benchmarks.gpu OUTDIR``: at most eight minutes, no network.
OUTDIR receives gpu.json (all of it, written after every section), passes.csv, triangles.csv,
window.csv, rays.csv, passes.png, estimators.csv, estimators.md, estimators.png, images.npz and,
with ``--compare FOLDER``, differences.csv and differences.png.
FOLDER is where the same script, run with ``--only images`` on llvmpipe, wrote its images:

    LIBGL_ALWAYS_SOFTWARE=1 python -m benchmarks.gpu llvmpipe --only images
    python -m benchmarks.gpu results --compare llvmpipe

A section that fails says so in gpu.json, and the others go on.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import all_estimators
from benchmarks.common import answering, command
from benchmarks.gpu_frames import triangle_rows, window_rows
from benchmarks.gpu_passes import COPY_SIDE, copy_bandwidth, draw_passes, pass_rows
from ssdo_gl.bench.measure.machine import describe_machine
from ssdo_gl.bench.presets import load_preset
from ssdo_gl.bench.report import as_bytes, drawn_in_style
from ssdo_gl.bench.storage import csv_bytes, load_arrays, replace_file, replace_json, save_arrays
from ssdo_gl.gpu.context import Device, create_context, describe
from ssdo_gl.images.display import picture_of
from ssdo_gl.images.error import failures, relative_rmse
from ssdo_gl.images.files import png_bytes
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

SECONDS = 480.0
SCENE = "cornell_meso"
SIZES = ((640, 360), (1920, 1080), (3840, 2160))
# (preset, method)
CONFIGURATIONS = (("fast", "bounce"), ("balanced", "bounce"), ("balanced", "gi"), ("fine", "gi"))
TESTS = ("tests/gpu", "tests/shaders", "tests/passes")
TEST_SECONDS = 150.0
# (method, rays or paths per pixel); rays per second count first rays only.
REFERENCES = (("reference-ao", 64), ("reference-near", 16), ("reference-gi", 16))
RAY_SCENES = ("cornell_meso", "stairs", "colonnade")
RAY_SIZE = (640, 360)
IMAGE_SCENES = ("corner", "cornell_meso", "courtyard", "stairs")
IMAGE_METHODS = ("direct", "ssao", "ssdo", "bounce", "gi", "reference-near", "reference-gi")
IMAGE_SIZE = (160, 90)
# A difference within this part of the value is rounding; a pixel beyond `VISIBLE` of the
# mean is seen.
ROUNDING, VISIBLE = 1e-5, 0.01
EGL_DEVICES = 8
ESTIMATORS = all_estimators.ScenesPlan(
    ("cornell_meso",), steps=(4, 8), size=(1280, 720), seeds=2, reference_seconds=5.0
)


class Run:
    """One run: what is asked for, what was found so far, and how much time is left."""

    def __init__(
        self, outdir: Path, quick: bool, compare: Path | None, seconds: float = SECONDS
    ) -> None:
        self.outdir = outdir
        self.seconds = seconds
        self.quick = quick
        self.compare = compare
        self.found: dict[str, Any] = {}
        self._start = time.monotonic()

    @property
    def seconds_left(self) -> float:
        """Until the run must end."""
        return self.seconds - (time.monotonic() - self._start)

    def section(self, name: str, work: Callable[[Run], object]) -> None:
        """Do one section and write what it found, or why it failed."""
        print(f"{name} ...", file=sys.stderr, flush=True)
        begin = time.monotonic()
        try:
            result = work(self)
        except Exception as error:
            # Whatever a driver does, the other sections shall be measured.
            trace = traceback.format_exc().splitlines()[-6:]
            result = {"failed": f"{type(error).__name__}: {error}", "trace": trace}
        seconds = round(time.monotonic() - begin, 2)
        self.found[name] = {"seconds": seconds, "result": result}
        replace_json(self.outdir / "gpu.json", self.found)


def find_devices(run: Run) -> object:
    """Return the chosen device, and each that EGL offers by its index."""
    device = create_context()
    with Renderer(load_scene(SCENE), Settings(size=(1, 1)), device=device) as renderer:
        machine = describe_machine(device, renderer.timer_kind, " ".join(sys.argv))
    chosen = {**describe(device), "machine": machine}
    device.release()
    script = (
        "import json; from ssdo_gl.gpu.context import create_context as c, describe;"
        "print(json.dumps(describe(c('egl'))))"
    )
    devices = []
    for index in range(1 if run.quick else EGL_DEVICES):
        # In processes of their own: a broken driver may end its process.
        environment = {**os.environ, "GLCONTEXT_DEVICE_INDEX": str(index)}
        done = _child([sys.executable, "-c", script], 30.0, environment)
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines()
            devices.append({"index": index, "failed": lines[-1] if lines else "no answer"})
            break
        devices.append({"index": index, **json.loads(done.stdout.splitlines()[-1])})
    return {"chosen": chosen, "egl": devices}


def run_tests(run: Run) -> object:
    """Run the test suites that draw, and return the outcome of each."""
    rows = []
    for folder in TESTS[:1] if run.quick else TESTS:
        limit = min(TEST_SECONDS, run.seconds_left)
        options = ["-q", "-p", "no:cacheprovider", "--tb=line"]
        begin = time.monotonic()
        done = _child([sys.executable, "-m", "pytest", *options, folder], limit, None)
        lines = done.stdout.strip().splitlines()
        rows.append(
            {
                "suite": folder,
                "exit": done.returncode,
                "seconds": round(time.monotonic() - begin, 1),
                "summary": lines[-1] if lines else done.stderr[-500:],
                "failed": [line for line in lines if line.startswith(("FAILED", "ERROR"))][:50],
            }
        )
    return rows


def _child(
    words: Sequence[str], limit: float, environment: Mapping[str, str] | None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, or for `limit` seconds: its exit code is then 124."""
    root = Path(__file__).parent.parent
    try:
        return subprocess.run(
            words, capture_output=True, text=True, timeout=limit, check=False, cwd=root,
            env=environment,
        )  # fmt: skip
    except subprocess.TimeoutExpired as ended:
        output = ended.stdout or b""
        text = output.decode(errors="replace") if isinstance(output, bytes) else output
        return subprocess.CompletedProcess(words, 124, text, f"more than {limit:.0f} s")


def time_passes(run: Run) -> object:
    """Time every pass of the presets at every size; writes passes.csv and passes.png."""
    device = create_context()
    bandwidth = copy_bandwidth(device, COPY_SIDE // 8 if run.quick else COPY_SIDE)
    scene, rows, skipped = load_scene(SCENE), [], []
    ways = [device.computes, *([False] if device.computes else [])]
    for computes in ways:
        device.computes = computes
        # Where compute shaders are faster, the other way is shown once, at full HD.
        sizes = SIZES if computes == ways[0] else SIZES[1:2]
        for size in SIZES[:1] if run.quick else sizes:
            for preset, method in CONFIGURATIONS:
                if run.seconds_left < 120.0:
                    skipped.append(f"{preset} {method} at {size[0]}x{size[1]}")
                    continue
                fields = {**load_preset(preset), "method": method, "size": size}
                settings = settings_for(scene.render, fields)
                rows += pass_rows(device, scene, preset, settings, bandwidth, quick=run.quick)
    device.release()
    replace_file(run.outdir / "passes.csv", csv_bytes(rows))
    replace_file(run.outdir / "passes.png", as_bytes(drawn_in_style(draw_passes, rows), "png"))
    return {"copy_gb_per_s": round(bandwidth / 1e9, 2), "passes": rows, "skipped": skipped}


def time_frames(run: Run) -> object:
    """Time frames by either way to draw triangles, and of a window; writes two tables."""
    device = create_context()
    tables = {"triangles": triangle_rows, "window": window_rows}
    found = {}
    for name, rows_of in tables.items():
        if run.seconds_left > 90.0:
            found[name] = rows_of(device, quick=run.quick)
            replace_file(run.outdir / f"{name}.csv", csv_bytes(found[name]))
    device.release()
    return found


def time_rays(run: Run) -> object:
    """Time the references; writes rays.csv."""
    device, rows = create_context(), []
    for name in RAY_SCENES[:1] if run.quick else RAY_SCENES:
        scene = load_scene(name)
        for method, spp in REFERENCES:
            if run.seconds_left < 60.0:
                break
            size = (160, 90) if run.quick else RAY_SIZE
            spp = max(spp // 8, 1) if run.quick else spp
            wanted = "visibility" if method == "reference-ao" else "beauty"
            settings = settings_for(scene.render, {"method": method, "spp": spp, "size": size})
            with Renderer(scene, settings, device=device) as renderer:
                depth = renderer.render([wanted, "depth"]).images["depth"]
                timed = [
                    renderer.time_frame([wanted], number=number, time_passes=True).passes
                    for number in range(1, 4)
                ]
            traced = [
                sum(r.gpu_ms or 0.0 for r in passes if r.name.startswith("reference"))
                for passes in timed
            ]
            pixels, ms = int(np.count_nonzero(depth > 0.0)), min(traced)
            rate = pixels * spp / (ms * 1e-3) / 1e6 if ms > 0.0 else 0.0
            rows.append(
                {"scene": name, "triangles": scene.triangle_count, "method": method, "spp": spp}
                | {"pixels": pixels, "ms": round(ms, 3), "million_per_s": round(rate, 2)}
            )
    device.release()
    replace_file(run.outdir / "rays.csv", csv_bytes(rows))
    return rows


def compare_estimators(run: Run) -> object:
    """Hold every estimator of visibility to rays; writes estimators.csv, .md and .png."""
    extent = all_estimators.QUICK if run.quick else ESTIMATORS
    device = create_context()
    rows = all_estimators.write(run.outdir, extent, device)
    device.release()
    return rows


def render_images(run: Run) -> object:
    """Render arrays into images.npz and compare them with those of ``--compare``."""
    device, images = create_context(), {}
    for name in IMAGE_SCENES[:2] if run.quick else IMAGE_SCENES:
        scene = load_scene(name)
        for method in IMAGE_METHODS:
            fields = {"method": method, "size": IMAGE_SIZE, "spp": 16}
            with Renderer(scene, settings_for(scene.render, fields), device=device) as renderer:
                images[f"{name}.{method}"] = renderer.render(("beauty",)).images["beauty"]
    rows = _ways_of_drawing(device, images) if device.computes else []
    renderer_name = device.renderer
    device.release()
    save_arrays(run.outdir / "images.npz", {"renderer": renderer_name}, images)
    result: dict[str, Any] = {"renderer": renderer_name, "images": sorted(images)}
    result["fragment_shaders_to_compute_shaders"] = rows
    if run.compare is not None:
        stored = load_arrays(run.compare / "images.npz")
        if stored is None:
            raise ValueError(f"{run.compare}: holds no images.npz that can be read")
        shared = [name for name in images if name in stored[1]]
        rows = [difference(name, images[name], stored[1][name]) for name in shared]
        replace_file(run.outdir / "differences.csv", csv_bytes(rows))
        pictures = [_seen(images[name], stored[1][name]) for name in shared]
        if pictures:
            replace_file(run.outdir / "differences.png", png_bytes(np.vstack(pictures)))
        result |= {"against": stored[0]["renderer"], "differences": rows}
    return result


def _ways_of_drawing(device: Device, images: Mapping[str, NDArray[Any]]) -> list[dict[str, Any]]:
    """Return how images by fragment shaders differ from `images`, by compute shaders."""
    rows = []
    device.computes = False
    for name in IMAGE_SCENES[:2]:
        scene = load_scene(name)
        for method in ("direct", "gi", "reference-near"):
            fields = {"method": method, "size": IMAGE_SIZE, "spp": 16}
            with Renderer(scene, settings_for(scene.render, fields), device=device) as renderer:
                image = renderer.render(("beauty",)).images["beauty"]
            rows.append(difference(f"{name}.{method}", image, images[f"{name}.{method}"]))
    return rows


def difference(name: str, image: NDArray[Any], other: NDArray[Any]) -> dict[str, Any]:
    """Return how two images differ, and what that looks like: rounding, ties or a fault."""
    a, b = image[:, :, :3].astype(np.float64), other[:, :, :3].astype(np.float64)
    covered = (image[:, :, 3] > 0.0) | (other[:, :, 3] > 0.0)
    broken = int(np.count_nonzero(failures(a) | failures(b)))
    mean = float(b[covered].mean()) if covered.any() else 0.0
    gap = np.nan_to_num(np.abs(a - b), nan=np.inf).max(axis=2)
    seen = float(np.mean(gap[covered] > VISIBLE * mean)) if covered.any() else 0.0
    if (gap == 0.0).all():
        looks_like = "equal"
    elif (gap <= ROUNDING * np.maximum(np.abs(b).max(axis=2), mean)).all():
        looks_like = "rounding"
    elif not broken and seen <= 0.02:
        looks_like = "ties at edges"
    else:
        looks_like = "a fault, or other random numbers"
    return {
        "image": name,
        "max": float(gap.max()),
        "relative_rmse": float(relative_rmse(a, b, covered)),
        "share_seen": round(seen, 5),
        "non_finite": broken,
        "looks_like": looks_like,
    }


def _seen(image: NDArray[Any], other: NDArray[Any]) -> NDArray[np.uint8]:
    """Return two images and a hundred times their difference, side by side."""
    gap = 100.0 * np.abs(image - other)
    gap[:, :, 3] = 1.0
    return np.hstack([picture_of("beauty", np.asarray(i, np.float32)) for i in (image, other, gap)])


def _has_failed(result: Any) -> bool:
    if isinstance(result, list):
        return any(row.get("exit", 0) != 0 for row in result)
    return "failed" in result


# In this order: what needs least comes first, should the time run out.
SECTIONS: dict[str, Callable[[Run], object]] = {
    "devices": find_devices,
    "images": render_images,
    "passes": time_passes,
    "frames": time_frames,
    "rays": time_rays,
    "estimators": compare_estimators,
    "tests": run_tests,
}


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Run the sections; 1 if one of them failed."""
    parser = command("gpu", __doc__)
    parser.add_argument("outdir", type=Path, metavar="OUTDIR")
    parser.add_argument("--only", metavar="NAME,...", help=f"of {', '.join(SECTIONS)}")
    parser.add_argument("--compare", type=Path, metavar="FOLDER", help="images of another run")
    parser.add_argument("--quick", action="store_true", help="about two minutes on llvmpipe")
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"in all; {SECONDS:.0f}"
    )
    options = parser.parse_args(argv)
    names = options.only.split(",") if options.only else list(SECTIONS)
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        parser.error(f"--only {unknown[0]!r}: choose of {', '.join(SECTIONS)}")
    if options.compare is not None and not options.compare.is_dir():
        parser.error(f"--compare {options.compare}: there is no such folder")
    options.outdir.mkdir(parents=True, exist_ok=True)
    run = Run(options.outdir, options.quick, options.compare, options.seconds)
    for name in names:
        run.section(name, SECTIONS[name])
    failed = [name for name, row in run.found.items() if _has_failed(row["result"])]
    print(f"{options.outdir / 'gpu.json'}: {', '.join(failed) or 'no section'} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
