"""What a rendering gives back: images, times, and what every pass did."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Self

import moderngl

from ssdo_gl.effects.request import Decision
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.execute import PassTiming
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.graph.graph import Plan
from ssdo_gl.images.display import displayed, picture_of
from ssdo_gl.images.files import (
    check_output,
    is_picture,
    picture_paths,
    png_bytes,
)
from ssdo_gl.images.metering import measured_exposure
from ssdo_gl.images.saving import Extent, write_images
from ssdo_gl.images.surface_arrays import Image
from ssdo_gl.planning.pipeline import Pipeline
from ssdo_gl.scene.camera import CONVENTIONS, Camera
from ssdo_gl.settings import Settings
from ssdo_gl.settings.backgrounds import TRANSPARENT
from ssdo_gl.settings.fields import values
from ssdo_gl.version import __version__
from ssdo_gl.wording import described


class PassReport(NamedTuple):
    """What one pass did, for ``--explain`` and ``--stats``."""

    name: str
    ran: bool
    reason: str
    gpu_ms: float | None = None
    cpu_ms: float = 0.0
    # Not run, because what it had made for an earlier frame is used.
    was_kept: bool = False


@dataclass(frozen=True)
class FrameTimes:
    """What one frame took, milliseconds.

    Attributes
    ----------
    frame_ms : float
        From its first command until the device had finished.
    process_ms : float
        Processor time of all threads.
    planning_ms : float
        Before that: deciding what runs.
    report : callable
        Returns what every pass did; `passes` is the answer.
    """

    frame_ms: float
    process_ms: float
    planning_ms: float
    report: Callable[[], tuple[PassReport, ...]]

    @cached_property
    def passes(self) -> tuple[PassReport, ...]:
        """What every pass did."""
        return self.report()


@dataclass(frozen=True)
class Plane:
    """An image on the device: channels of a texture, or one number everywhere.

    Attributes
    ----------
    texture : moderngl.Texture or None
        The renderer's; it holds until the next frame is drawn.
    neutral : float
        What every channel is if there is no texture.
    """

    texture: moderngl.Texture | None
    first_channel: int = 0
    channels: int = 3
    neutral: float = 0.0

    def read(self) -> Image:
        """Return all channels of its texture, row 0 at the top, once it is drawn."""
        assert self.texture is not None, f"it is {self.neutral} everywhere"
        return read_texture(self.texture)


@dataclass(frozen=True)
class Drawing:
    """One frame whose images are still on the device.

    Attributes
    ----------
    planes : mapping of image name to Plane
    report : callable
        Returns what every pass did; a window asks for it where it is shown, and `passes`
        is the answer.
    frame_ms : float
        Until the device had finished, without what was done in between.
    references : mapping
        Statistics of the Monte-Carlo passes.
    is_settled : bool
        Whether the same frame, drawn again, would be the same.
    """

    planes: Mapping[str, Plane]
    view: FrameView
    report: Callable[[], tuple[PassReport, ...]]
    decisions: tuple[Decision, ...]
    frame_ms: float
    references: Mapping[str, Any] = field(default_factory=dict)
    is_settled: bool = True

    @cached_property
    def passes(self) -> tuple[PassReport, ...]:
        """What every pass did."""
        return self.report()


@dataclass(frozen=True)
class RenderResult:
    """The outcome of `Renderer.render`.

    Attributes
    ----------
    images : dict of str to ndarray, shape (height, width, channels), float32
        Row 0 at the top.
    view : FrameView
        Through the pixels' centres.
    size : (int, int)
        Width and height in pixels.
    camera : Camera or None
        Whose picture it is; it knows its intrinsic and extrinsic matrices.
    passes : tuple of PassReport
        Medians over the timed frames.
    frame_ms : tuple of float
        Milliseconds of each timed frame until the device had finished.
    process_ms : tuple of float
        Processor time of the same frames, all threads: what a software rasterizer
        spends, whatever else the machine is doing.
    setup_ms : float
        The first frame, with shader compilation, shadow maps and uploads.
    references : dict
        Statistics of the Monte-Carlo passes: samples per pixel, standard errors.
    partial : bool
        A reference was interrupted; the images hold what it had reached.
    metering_slack : float or None
        Where exposure is left to the picture and was not measured: as of the scene.
    """

    images: dict[str, Image]
    view: FrameView
    size: tuple[int, int]
    settings: Settings
    passes: tuple[PassReport, ...]
    decisions: tuple[Decision, ...]
    frame_ms: tuple[float, ...]
    setup_ms: float
    process_ms: tuple[float, ...] = ()
    references: dict[str, Any] = field(default_factory=dict)
    partial: bool = False
    notes: tuple[str, ...] = ()
    camera: Camera | None = None
    metering_slack: float | None = None

    def __repr__(self) -> str:
        width, height = self.size
        return described(
            self,
            " ".join(self.images),
            f"{width}x{height}",
            self.settings.method,
            f"{self.frame_summary()['median']:.1f} ms a frame",
            "partial" if self.partial else "",
        )

    def whole(self) -> Self:
        """Return the result; raises KeyboardInterrupt where it is partial."""
        if self.partial:
            raise KeyboardInterrupt
        return self

    def save(self, path: str | Path) -> None:
        """Write the images to a file, whole or not at all.

        Parameters
        ----------
        path : str or Path
            ``.png``, ``.jpg`` or ``.webp`` for pictures, each further one beside it as
            ``stem-name.png``; ``.exr`` or ``.npz`` for linear numbers, all in one file. The
            picture of the beauty is ``display``, made of the beauty if it was not rendered.

        Raises
        ------
        OutputError
            If the suffix is another one, or the file cannot be written.
        """
        out = Path(path)
        check_output(out)
        names: tuple[str, ...] = ()
        if is_picture(out):
            shown = {"display": "beauty"}
            names = tuple(dict.fromkeys(shown.get(name, name) for name in self.images))
            for other in picture_paths(out, names).values():
                check_output(other)
        meta = {
            "ssdo_gl": __version__,
            "size": list(self.size),
            "settings": values(self.settings),
            "notes": list(self.notes),
            "references": self.references,
            "partial": self.partial,
            "camera": camera_numbers(self.camera, self.size),
        }
        extents: dict[str, Extent] = {"depth": (self.view.near, self.view.far)}
        images = self._shown_images() if names else self.images
        write_images(out, names, images, meta, extents)

    def _repr_png_(self) -> bytes | None:
        """Return what a notebook shows: the beauty as displayed, or else the first image."""
        images = self._shown_images()
        name = "display" if "display" in images else next(iter(images), "")
        return png_bytes(picture_of(name, images[name])) if name else None

    def _shown_images(self) -> dict[str, Image]:
        """Return the images, with the ``display`` of a beauty that has none."""
        if "display" in self.images or "beauty" not in self.images:
            return self.images
        chosen, beauty = self.settings, self.images["beauty"]
        exposure = chosen.exposure or 0.0
        if self.metering_slack is not None:
            exposure = measured_exposure(beauty, self.metering_slack)
        tone: dict[str, Any] = {
            "exposure": exposure,
            "background": chosen.background,
            "curve": "plain",
        }
        tone |= {name: chosen.overrides.get(f"tone_map.{name}", tone[name]) for name in tone}
        shown = displayed(
            beauty,
            tone["exposure"],
            filmic=tone["curve"] == "aces",
            cut_out=tone["background"] == TRANSPARENT,
        )
        return {**self.images, "display": shown}

    def frame_summary(self) -> dict[str, float]:
        """Return median, min and max of the frame times, milliseconds."""
        times = self.frame_ms
        values = {"median": statistics.median(times), "min": min(times), "max": max(times)}
        return {name: round(value, 3) for name, value in values.items()}


def camera_numbers(camera: Camera | None, size: tuple[int, int]) -> dict[str, Any] | None:
    """Return a camera as files hold it, with its matrices as lists of rows."""
    if camera is None:
        return None
    return {
        **dataclasses.asdict(camera),
        "intrinsics": camera.intrinsics(size).tolist(),
        **{f"extrinsics_{name}": camera.extrinsics(name).tolist() for name in CONVENTIONS},
    }


class FrameLog:
    """Collects the times of frames; the first one is the set-up and stands apart.

    If no other frame follows, the first one has to speak for all.
    """

    def __init__(self) -> None:
        self.setup_ms: float | None = None
        self._setup_process_ms = 0.0
        self._setup_rows: list[PassTiming] = []
        self._frame_ms: list[float] = []
        self._process_ms: list[float] = []
        self._rows: list[list[PassTiming]] = []

    def add(self, frame_ms: float, process_ms: float, rows: list[PassTiming]) -> None:
        """Record one frame."""
        if self.setup_ms is None:
            self.setup_ms, self._setup_process_ms, self._setup_rows = frame_ms, process_ms, rows
            return
        self._frame_ms.append(frame_ms)
        self._process_ms.append(process_ms)
        self._rows.append(rows)

    def restart(self) -> None:
        """Forget all frames but the first: the ones that count come now."""
        self._frame_ms.clear()
        self._process_ms.clear()
        self._rows.clear()

    @property
    def frame_ms(self) -> tuple[float, ...]:
        """Milliseconds of each frame."""
        return tuple(self._frame_ms) or (self.setup_ms or 0.0,)

    @property
    def process_ms(self) -> tuple[float, ...]:
        """Processor milliseconds of each frame."""
        return tuple(self._process_ms) or (self._setup_process_ms,)

    def reports(self, pipeline: Pipeline, plan: Plan) -> tuple[PassReport, ...]:
        """Return what every pass of `plan` did, and why the others did not run."""
        by_name: dict[str, list[PassTiming]] = {}
        for rows in self._rows or [self._setup_rows]:
            for row in rows:
                by_name.setdefault(row.name, []).append(row)
        reports = [
            _report(item.name, by_name[item.name], pipeline.reasons.get(item.name, "needed"))
            for item in plan.order
        ]
        reports += [
            PassReport(item.name, False, "nothing that was asked for reads it")
            for item in plan.culled
        ]
        reports += [PassReport(name, False, why) for name, why in pipeline.skipped.items()]
        return tuple(reports)


def _report(name: str, rows: Sequence[PassTiming], reason: str) -> PassReport:
    ran = [row for row in rows if row.ran]
    if not any(row.was_made for row in rows):
        return PassReport(name, False, f"nothing read it this time: {reason}")
    if not ran:
        return PassReport(name, False, f"unchanged, kept: {reason}", was_kept=True)
    if len(ran) == 1:
        # Of every frame of a window.
        return PassReport(name, True, reason, ran[0].gpu_ms, ran[0].cpu_ms)
    measured = [row.gpu_ms for row in ran if row.gpu_ms is not None]
    return PassReport(
        name,
        True,
        reason,
        statistics.median(measured) if measured else None,
        statistics.median(row.cpu_ms for row in ran),
    )
