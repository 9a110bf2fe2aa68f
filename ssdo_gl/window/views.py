"""What of a scene is shown, and how an image becomes colours. Pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from ssdo_gl.images.display import ColorMapping, color_mapping
from ssdo_gl.settings import AOVS, Settings
from ssdo_gl.settings.methods import METHODS

# A divider at the very edge could not be grabbed again.
DIVIDER_MARGIN = 0.02
# How far off a cursor still grabs it.
REACH_PX = 6.0


# What each method shows of its own accord, for people who do not know the names.
METHOD_LABELS: Mapping[str, str] = {method.name: method.label for method in METHODS.values()}


@dataclass(frozen=True)
class View:
    """What the window shows.

    Attributes
    ----------
    aov : str
        One of `AOVS`.
    method, other_method : str
        Left and right of the divider; `other_method` only while `is_split`, or as
        what `is_error` compares with.
    divider : float
        Where the split is, 0 (left edge) to 1.
    is_error : bool
        Show the difference of the two methods in false colour.
    error_range : float
        Relative difference at which the colours saturate.
    """

    aov: str = "beauty"
    method: str = "gi"
    other_method: str = "reference-gi"
    is_split: bool = False
    divider: float = 0.5
    is_error: bool = False
    error_range: float = 0.5

    @property
    def kind(self) -> ColorMapping:
        """How the image becomes colours."""
        return color_mapping(self.aov)

    @property
    def compares(self) -> bool:
        """Whether the second method has to be rendered."""
        return self.is_split or self.is_error

    def with_number(self, number: int) -> View:
        """Return the view of image 1 to 10."""
        return dataclasses.replace(self, aov=AOVS[number - 1])

    def with_next_method(self, step: int) -> View:
        """Return the view with another method on the left."""
        return dataclasses.replace(self, method=_stepped(self.method, step))

    def with_next_other_method(self) -> View:
        """Return the view with another method on the right."""
        return dataclasses.replace(self, other_method=_stepped(self.other_method, 1))

    def with_divider(self, position: float) -> View:
        """Return the view with the divider at `position`, kept inside the window."""
        position = min(1.0 - DIVIDER_MARGIN, max(DIVIDER_MARGIN, position))
        return dataclasses.replace(self, divider=position)


def image_of(view: View, settings: Settings) -> str:
    """Return which image must be rendered: linear where it is averaged or subtracted.

    The picture of a screen-space method is averaged after tone mapping, as ``--snapshot``
    does it, so that edges against a blinding light come out smooth. A reference is noisy
    radiance whose mean is the answer; tone mapping before averaging would darken it.
    """
    if view.aov != "beauty":
        return view.aov
    return "beauty" if settings.is_reference or view.is_error else "display"


def kind_of_image(view: View, image: str) -> ColorMapping:
    """Return how the rendered `image` becomes colours."""
    return ColorMapping.RADIANCE if image == "beauty" else view.kind


def is_averaged(kind: ColorMapping) -> bool:
    """Whether frames with other sub-pixel offsets and seeds are averaged.

    Geometry is not: the mean of two depths or normals lies on neither surface.
    """
    return kind not in (ColorMapping.NORMAL, ColorMapping.POSITION, ColorMapping.DEPTH)


def settings_of(settings: Settings, method: str) -> Settings:
    """Return `settings` for another method; an estimator it does not know is dropped."""
    estimator = settings.estimator
    if estimator not in METHODS[method].estimators:
        estimator = None
    return dataclasses.replace(settings, method=method, estimator=estimator)


def _stepped(method: str, step: int) -> str:
    names = list(METHODS)
    return names[(names.index(method) + step) % len(names)]


def divider_hit(view: View, x: float, width: float) -> bool:
    """Return whether a cursor at `x` of `width` pixels grabs the divider."""
    return view.is_split and abs(x - view.divider * width) <= REACH_PX
