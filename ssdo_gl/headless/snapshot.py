"""Renders one picture or a set of arrays without a window, and says what it took."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike
from rich.console import Console
from rich.markup import escape

from ssdo_gl.effects.registry import image_names
from ssdo_gl.gpu.held_signals import whole_before_ctrl_c
from ssdo_gl.gpu.warm_device import WarmDevice
from ssdo_gl.headless.explain import (
    Explanation,
    decisions_for_json,
    explain,
    explanation_table,
    summary,
)
from ssdo_gl.image_requests import images_of_other_methods
from ssdo_gl.images.files import STDOUT, is_picture, write_atomically
from ssdo_gl.images.saving import image_files
from ssdo_gl.process import check_said
from ssdo_gl.progress import progress_on_terminal
from ssdo_gl.render_result import RenderResult, camera_numbers
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import values
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.version import __version__
from ssdo_gl.wording import counted, printable

_BLACK = (
    "the picture is black: {dark}the camera sees nothing that light reaches"
    " (--camera fit shows the whole scene, --light studio lights it)"
)


@dataclass(frozen=True)
class SnapshotRequest:
    """What `take_snapshot` is asked to do.

    Attributes
    ----------
    wanted : tuple of str
        AOV names.
    out : Path or None
        Where the image goes; None only explains.
    camera : Camera or None
        Replaces the scene's camera.
    frames : int
        Timed frames after one warm-up.
    seconds : float
        Time of an animated scene.
    keeps_partial : bool
        Write what a reference had reached when it was interrupted.
    warm : WarmDevice or None
        Draws and is kept; None: a device for this picture alone.
    """

    scene: Scene
    settings: Settings
    wanted: tuple[str, ...] = ("beauty",)
    out: Path | None = None
    camera: Camera | None = None
    frames: int = 1
    seconds: float = 0.0
    stats: Path | None = None
    backend: str = "auto"
    explain: bool = False
    keeps_partial: bool = True
    warm: WarmDevice | None = None
    quiet: bool = False


def take_snapshot(request: SnapshotRequest) -> RenderResult:
    """Render as requested, write the files and print a summary.

    To standard output, or where that takes the picture, to standard error.
    """
    to_stderr = request.out == STDOUT
    console = Console(highlight=False, soft_wrap=True, stderr=to_stderr)
    if not console.is_terminal:
        # Files and pipes have no width; whole sentences are easier to search.
        console = Console(highlight=False, soft_wrap=True, width=200, stderr=to_stderr)
    as_picture = request.out is not None and is_picture(request.out)
    wanted = resources_wanted(request.wanted, as_picture)
    device, shaders = request.warm.made(request.backend) if request.warm else (None, None)
    with (
        Renderer(
            request.scene,
            request.settings,
            backend=request.backend,
            device=device,
            shaders=shaders,
        ) as renderer,
        progress_on_terminal(quiet=request.quiet) as progress,
    ):
        result = renderer.render(
            wanted,
            camera=request.camera,
            seconds=request.seconds,
            frames=request.frames,
            time_passes=request.stats is not None or request.explain,
            progress=progress,
        )
        explanation = Explanation(result)
        if request.explain:
            explanation = explain(renderer, result, request.camera, request.seconds, progress)
        stats = stats_of(renderer, explanation)
    if result.partial and not request.keeps_partial:
        return result
    _write_files(request, result, stats)
    if result.partial:
        Console(stderr=True, highlight=False, soft_wrap=True).print(
            "ssdo-gl: interrupted; the image holds what the reference had reached"
        )
    for line in missed_bounds(result):
        print(f"ssdo-gl: {line}", file=sys.stderr)
    if not request.quiet:
        _print_summary(console, request, explanation, stats)
    if request.explain:
        check_said()
    return result


def _write_files(request: SnapshotRequest, result: RenderResult, stats: dict[str, Any]) -> None:
    """Write all files of a snapshot; Ctrl-C waits for them, but not for who reads a pipe."""
    files: dict[Path, bytes] = {}
    if request.out is not None:
        extents = extents_of(request.wanted, request.scene, result)
        meta = file_meta(stats, result)
        files = image_files(request.out, request.wanted, result.images, meta, extents)
    if request.stats is not None:
        files[request.stats] = (json.dumps(stats, indent=2) + "\n").encode()
    if STDOUT in files:
        write_atomically(STDOUT, files.pop(STDOUT))
    if not files:
        return
    names = ", ".join(str(path) for path in files)
    with whole_before_ctrl_c(f"interrupted after {names} had been written"):
        for path, data in files.items():
            write_atomically(path, data)


def resources_wanted(aovs: tuple[str, ...], as_picture: bool) -> tuple[str, ...]:
    """Return what to render: a picture of the beauty comes from the tone mapper."""
    if not as_picture:
        return aovs
    return tuple("display" if name == "beauty" else name for name in aovs)


def extents_of(
    names: Iterable[str], scene: Scene, result: RenderResult
) -> dict[str, tuple[ArrayLike, ArrayLike]]:
    """Return `extent_of` of those of `names` that have one."""
    extents = {name: extent_of(name, scene, result) for name in names}
    return {name: extent for name, extent in extents.items() if extent is not None}


def extent_of(name: str, scene: Scene, result: RenderResult) -> tuple[ArrayLike, ArrayLike] | None:
    """Return between which values a picture of `name` is spread: as in the window."""
    if name == "position_ws":
        return scene.bounds()
    return (result.view.near, result.view.far) if name == "depth" else None


def file_meta(stats: dict[str, Any], result: RenderResult) -> dict[str, Any]:
    """Return the part of `stats` that is the same in every run, so that files are; the camera."""
    kept = (
        "renderer",
        "gl_version",
        "backend",
        "size",
        "settings",
        "notes",
        "references",
        "partial",
    )
    return {
        "ssdo_gl": __version__,
        **{key: stats[key] for key in kept if key in stats},
        "camera": camera_numbers(result.camera, result.size),
    }


def stats_of(renderer: Renderer, explanation: Explanation) -> dict[str, Any]:
    """Return the content of ``--stats``: device, frame and pass times, settings."""
    result = explanation.result
    return {
        "ssdo_gl": __version__,
        "renderer": renderer.device.renderer,
        "gl_version": renderer.device.version,
        "backend": renderer.device.backend,
        "platform": platform.platform(),
        "size": list(result.size),
        "frames": len(result.frame_ms),
        "timer": renderer.timer_kind,
        "setup_ms": round(result.setup_ms, 3),
        "frame_ms": result.frame_summary(),
        "passes": [
            {
                "name": row.name,
                "ran": row.ran,
                "reason": row.reason,
                "gpu_ms": None if row.gpu_ms is None else round(row.gpu_ms, 4),
                "cpu_ms": round(row.cpu_ms, 4),
            }
            for row in result.passes
        ],
        "decisions": decisions_for_json(explanation),
        "references": result.references,
        "partial": result.partial,
        "notes": list(renderer.scene.notes) + list(result.notes),
        "settings": values(result.settings),
    }


def print_notes(notes: Iterable[str]) -> None:
    """Print what there is to say about a scene to standard error."""
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    for note in notes:
        console.print(f"note: {escape(printable(note))}")


def _print_summary(
    console: Console, request: SnapshotRequest, explanation: Explanation, stats: dict[str, Any]
) -> None:
    result = explanation.result
    print_notes([*stats["notes"], *_notes_on_images(request, result)])
    if request.explain:
        console.print(explanation_table(explanation))
        whole = summary(explanation)
        if whole is not None:
            console.print(whole)
    ran = [row.name for row in result.passes if row.ran or row.was_kept]
    width, height = result.size
    frame = stats["frame_ms"]
    out = "standard output" if request.out == STDOUT else printable(str(request.out))
    where = "" if request.out is None else f"{out}: "
    settings = result.settings
    method = settings.method
    if METHODS[method].estimators:
        method += f" ({settings.chosen_estimator})"
    times = f"{frame['median']:.1f} ms a frame (first: {result.setup_ms:.0f} ms)"
    if result.frame_ms == (result.setup_ms,):
        times = f"first frame: {result.setup_ms:.0f} ms"
    console.print(escape(f"{where}{width}x{height}, {method}, R = {settings.radius:.4g}, {times}"))
    console.print(escape(f"passes: {' '.join(ran)}"))
    console.print(
        escape(
            f"{stats['renderer']}, OpenGL {stats['gl_version']}, {stats['backend']},"
            f" {counted(request.scene.triangle_count, 'triangle')}"
        )
    )
    for name, statistics in stats["references"].items():
        console.print(escape(f"{name}: {reference_text(statistics)}"))


def _notes_on_images(request: SnapshotRequest, result: RenderResult) -> Iterator[str]:
    if is_black(result):
        exposure = result.settings.exposure or 0.0
        yield _BLACK.format(dark=f"at {exposure:g} EV, or " if exposure < 0.0 else "")
    others = images_of_other_methods(request.wanted, result.settings.method)
    if others and set(request.wanted) != set(image_names()):
        yield f"{', '.join(others)}: no part of {result.settings.method}, the same everywhere"


def is_black(result: RenderResult) -> bool:
    """Return whether a picture was made, and shows nothing."""
    shown = [result.images[name] for name in ("display", "beauty") if name in result.images]
    return bool(shown) and not any(image[..., :3].any() for image in shown)


def reference_text(statistics: Mapping[str, Any]) -> str:
    """Return what a Monte-Carlo pass reached, in words."""
    relative = statistics["relative_standard_error"]
    # From less than two samples of a surface no error can be told.
    errors = ", ".join(
        f"{resource} unknown"
        if error is None
        else f"{resource} {error:.2g} ({relative[resource]:.1%})"
        for resource, error in statistics["standard_error"].items()
    )
    partial = " (interrupted: partial)" if statistics["partial"] else ""
    return f"{counted(statistics['spp'], 'sample')} per pixel{partial}, standard error {errors}"


def missed_bounds(result: RenderResult) -> list[str]:
    """Return a line for each reference that is not known to have met its error bound."""
    bound = result.settings.max_error
    if bound is None or not result.settings.is_reference or result.partial:
        return []
    lines = []
    for name, statistics in result.references.items():
        for resource, error in statistics["relative_standard_error"].items():
            # Of more than one sample it is unknown only where there is no surface to err.
            if statistics["spp"] > 1 if error is None else error <= bound:
                continue
            said = "unknown" if error is None else f"{100.0 * error:.3g} %"
            lines.append(
                f"{name}: relative standard error of {resource} is {said} after "
                f"{counted(statistics['spp'], 'sample')} per pixel, --max-error asked for "
                f"{100.0 * bound:.3g} %"
            )
    return lines
