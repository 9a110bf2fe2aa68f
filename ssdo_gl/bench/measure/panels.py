"""Which errors a bench measures: each an AOV against the reference that has the same one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ssdo_gl.bench.measure.points import PICTURE, Point
from ssdo_gl.effects import registry
from ssdo_gl.effects.effect import Effect
from ssdo_gl.settings.methods import METHODS, REFERENCES, Method

# Emitters do not count (`errors.judged_pixels`), so what they emit has no error.
NOT_JUDGED = "emission"


@dataclass(frozen=True)
class ErrorPanel:
    """One way to hold points to a reference: one Pareto chart.

    Attributes
    ----------
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
    def is_all_light(self) -> bool:
        """Whether its reference shows all light transport."""
        return METHODS[self.method].is_all_light

    @property
    def kind(self) -> str:
        """Which points it judges."""
        return PICTURE if self.is_picture else self.aov

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
        # What shows more than the near field would only seem wrong beside it.
        if METHODS[point.method].is_all_light and not self.is_all_light:
            return False
        return not self.own_radius or point.radius_factor == 1.0


def error_panels() -> tuple[ErrorPanel, ...]:
    """Return all panels, pictures first: each reference judges what its effects make."""
    references = [method for method in METHODS.values() if method.is_reference]
    panels = {panel.name: panel for method in references for panel in _panels_of(method)}
    return tuple(sorted(panels.values(), key=lambda panel: not panel.is_picture))


def _panels_of(method: Method) -> Iterator[ErrorPanel]:
    members = [effect for effect in registry.effects() if method.name in effect.methods]
    own = [effect for effect in members if effect.methods <= REFERENCES]
    has_radius = any(
        hasattr(settings, "radius") for effect in own for settings in effect.settings.values()
    )
    lacks = "what the screen does not show"
    if any(effect.terms or effect.picture for effect in own):
        # A reference that is the whole picture does not tell its terms apart.
        parts = () if any(effect.picture for effect in own) else _terms(members)
        against = f"the {method.label}"
        if method.is_all_light:
            against = f"all light transport ({method.label})"
        yield ErrorPanel(
            method.name.removeprefix("reference-"),
            method.name,
            "beauty",
            f"Picture against {against}",
            f"{lacks}, and shadow maps",
            parts,
            has_radius,
        )
    for image in dict.fromkeys(name for effect in members for name in effect.images):
        title = f"{image.capitalize()} against {method.label}"
        yield ErrorPanel(image, method.name, image, title, lacks, own_radius=has_radius)


def _terms(effects: Iterable[Effect]) -> tuple[str, ...]:
    names = dict.fromkeys(term.name for effect in effects for term in effect.terms)
    return tuple(name for name in names if name != NOT_JUDGED)


def panel_named(name: str) -> ErrorPanel:
    """Return the panel called `name`."""
    return next(panel for panel in error_panels() if panel.name == name)


def all_aovs(panels: Iterable[ErrorPanel]) -> Sequence[str]:
    """Return the images that judging by `panels` needs, each once."""
    return tuple(dict.fromkeys(aov for panel in panels for aov in panel.aovs))
