"""Everything a bench found out, as plain data: what tables, plots and report are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ssdo_gl.bench.analysis import Recommendation, ReferenceSummary, Result
from ssdo_gl.bench.measure import Point
from ssdo_gl.options.command_line import command_line
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings import Settings
from ssdo_gl.settings.loading import LoadOptions


@dataclass(frozen=True)
class Series:
    """How a cost grows with one quantity.

    Attributes
    ----------
    name : str
        ``samples``, ``pixels``, ``radius`` or ``triangles``.
    curves : dict of str to tuple of float
        Milliseconds by what is timed; NaN where it did not run.
    """

    name: str
    x_label: str
    x: tuple[float, ...]
    curves: dict[str, tuple[float, ...]]


@dataclass(frozen=True)
class Picture:
    """An image of the report.

    Attributes
    ----------
    name : str
        What the reader chooses it by.
    flip_png : bytes or None
        Its FLIP map against the reference of its group.
    group : str
        ``radiance`` or ``visibility``; only pictures of one group are compared.
    against : str
        Name of the picture that its FLIP map is against.
    """

    name: str
    png: bytes
    flip_png: bytes | None
    group: str
    is_reference: bool
    caption: str
    against: str = ""


@dataclass(frozen=True)
class Bench:
    """The outcome of one bench.

    Attributes
    ----------
    scene : str
        As it was named on the command line.
    scene_settings : mapping
        ``Scene.render``.
    camera : Camera or None
        None: the scene's own.
    loading : LoadOptions
        How the scene was loaded.
    base : Settings
        What all points share; its size and radius are those of the bench.
    splits : dict of str to tuple of (str, float)
        Point key -> (pass, milliseconds).
    clock : str
        What frame times, and so ``splits``, were measured by: a key of `clock.CLOCKS`.
    drift : tuple of float
        How much slower each round was than usual; 1 is usual.
    """

    scene: str
    scene_settings: Mapping[str, Any]
    camera: Camera | None
    loading: LoadOptions
    base: Settings
    title: str
    radius_px: float
    triangles: int
    quick: bool
    seeds: int
    rounds: int
    frames: int
    clock: str
    drift: tuple[float, ...]
    machine: dict[str, Any]
    results: list[Result]
    references: dict[str, ReferenceSummary]
    recommendation: Recommendation
    series: list[Series] = field(default_factory=list)
    splits: dict[str, tuple[tuple[str, float], ...]] = field(default_factory=dict)
    pictures: list[Picture] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def command(self, point: Point) -> str:
        """Return the shell command that renders what was measured of a point, timed."""
        line = self._line(point.settings(self.base), point.wanted[0], "out.png")
        return f"{line} --antialias 1 --frames {self.frames}"

    def asking(self, flags: str) -> str:
        """Return the command that renders the benched view with other settings' `flags`."""
        return f"{self._line(self.base, 'beauty', 'out.png')} --antialias 1 {flags}"

    def _line(self, settings: Settings, aov: str, out: str) -> str:
        return command_line(
            self.scene,
            settings,
            scene_settings=self.scene_settings,
            camera=self.camera,
            loading=self.loading,
            aov=aov,
            out=out,
        )
