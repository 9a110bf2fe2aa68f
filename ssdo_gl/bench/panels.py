"""Which errors a bench measures: each an AOV against the reference that has the same one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ssdo_gl.bench.points import Point

# What is added up to the picture; each one's error is reported beside the picture's.
TERM_AOVS = ("direct", "directional", "bounce")


@dataclass(frozen=True)
class ErrorPanel:
    """One way to hold points to a reference: one Pareto chart.

    Attributes
    ----------
    name : str
    method : str
        The reference.
    aov : str
        The image whose error counts.
    title : str
        For plots and tables.
    lacks : str
        What even a converged march lacks of this reference.
    parts : tuple of str
        Further AOVs whose errors are reported, relative to their own means.
    own_radius : bool
        Whether the reference has the bench's radius, so that points of another radius
        cannot be held to it.
    """

    name: str
    method: str
    aov: str
    title: str
    lacks: str
    parts: tuple[str, ...] = ()
    own_radius: bool = True

    @property
    def is_picture(self) -> bool:
        """Whether it judges pictures, and not an AOV of its own."""
        return self.aov == "beauty"

    @property
    def kind(self) -> str:
        """Which points it judges."""
        return "radiance" if self.is_picture else self.aov

    @property
    def relative(self) -> bool:
        """Whether errors are relative to the reference's mean: radiance has no unit of its own."""
        return self.is_picture

    @property
    def error_label(self) -> str:
        """The unit of its errors."""
        return "RMSE / mean of the reference" if self.relative else f"RMSE of {self.aov}"

    @property
    def aovs(self) -> tuple[str, ...]:
        """All images that judging by it needs."""
        return (self.aov, *self.parts)

    def judges(self, point: Point) -> bool:
        """Whether `point` can be held to this panel's reference."""
        if point.kind != self.kind:
            return False
        # Full transport is held to its own reference only.
        if point.method == "reference-gi" != self.method:
            return False
        return not self.own_radius or point.radius_factor == 1.0


def error_panels() -> tuple[ErrorPanel, ...]:
    """Return all panels; the first one decides what is recommended."""
    return (
        ErrorPanel(
            "near",
            "reference-near",
            "beauty",
            "Picture against the near-field reference (same integral, rays instead of depth reads)",
            "what the screen does not show, and shadow maps",
            parts=TERM_AOVS,
        ),
        ErrorPanel(
            "gi",
            "reference-gi",
            "beauty",
            "Picture against full global illumination (path traced)",
            "what the near-field model leaves out, and the same",
            own_radius=False,
        ),
        ErrorPanel(
            "visibility",
            "reference-ao",
            "visibility",
            "Visibility against ray-traced ambient occlusion of the same radius",
            "what the screen does not show",
        ),
    )


def panel_named(name: str) -> ErrorPanel:
    """Return the panel called `name`."""
    return next(panel for panel in error_panels() if panel.name == name)


def all_aovs(panels: Iterable[ErrorPanel]) -> Sequence[str]:
    """Return the images that judging by `panels` needs, each once."""
    return tuple(dict.fromkeys(aov for panel in panels for aov in panel.aovs))
