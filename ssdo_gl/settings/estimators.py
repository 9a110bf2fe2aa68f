"""The screen-space estimators: what each can do, and what it takes for granted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

# Where a back-face layer holds every closed body, what lacks a back is mostly a wall, seen
# from the inside of a room; without the layer it may be anything. Best of .2, .3, .5, 1, 2
# for the mean error of visibility over six scenes, but for 2 against 1 (.056 against .057),
# which was not worth the deeper shadow behind a sheet.
_THICKNESS_BESIDE_BACKS = 1.0
_THICKNESS_ALONE = 0.3
# Single points miss so much that taking solids for deeper mends more than it spoils: over
# five scenes .180, .143, .130, .136 with .5, 1, 2, infinity.
_THICKNESS_OF_POINTS = 2.0


@dataclass(frozen=True)
class Estimator:
    """One way to find out from the depth buffer what blocks directions.

    Attributes
    ----------
    name : str
        As ``--estimator`` knows it, and of its shader: ``estimators/<name>.glsl``.
    doc : str
        One line for the user.
    gives_light : bool
        Says what blocks a direction, so that light can be gathered; else visibility only.
    takes_steps : bool
        Reads several depths along each direction.
    sides : int
        2: a direction is a slice of the hemisphere, looked along both ways.
    names_blockers : bool
        Says which one surface blocks a direction, so that another pass may take it over.
    reads_backs : bool
        Uses the back-face layer.
    has_radius : bool
        Looks no farther than R, so that a view can be proven open.
    thickness, thickness_beside_backs : float
        Of solids whose back is unknown, relative to R, without a back-face layer and
        beside one.
    sums_open_light : bool
        Adds up the light of open directions, as the paper does, instead of correcting the
        exact irradiance of an open point.
    """

    name: str
    doc: str
    gives_light: bool = False
    takes_steps: bool = False
    sides: int = 1
    names_blockers: bool = False
    reads_backs: bool = False
    has_radius: bool = True
    thickness: float = _THICKNESS_ALONE
    thickness_beside_backs: float = _THICKNESS_BESIDE_BACKS
    sums_open_light: bool = False

    def shared_out(self, samples: int, steps: int) -> tuple[int, int]:
        """Return how many directions `samples` depth reads make, and steps along each.

        Steps are counted each way. Reads are rounded down to whole directions, of which
        there is at least one: a slice takes two reads where `samples` is 1.
        """
        step_count = max(1, min(steps, samples // self.sides)) if self.takes_steps else 1
        return max(1, samples // (step_count * self.sides)), step_count

    def count_label(self, samples: int, steps: int) -> str:
        """Return what a person reads: ``2x8`` directions and steps, ``2x2x4`` slices, ``16``."""
        directions, step_count = self.shared_out(samples, steps)
        ways = [] if self.sides == 1 else [self.sides]
        return "x".join(map(str, [directions, *ways, *([step_count] if self.takes_steps else [])]))

    @property
    def choices(self) -> Mapping[str, str]:
        """What ``#include <estimator>`` stands for."""
        return {"estimator": f"estimators/{self.name}.glsl"}


# The most accurate one for its time, behind a filter: docs/estimators.md.
DEFAULT_ESTIMATOR = "march"
ESTIMATORS: Mapping[str, Estimator] = {
    estimator.name: estimator
    for estimator in (
        Estimator(
            "march",
            "several depth reads along each direction",
            gives_light=True,
            takes_steps=True,
            names_blockers=True,
            reads_backs=True,
        ),
        Estimator(
            "rgs09",
            "the paper's single point in each direction",
            gives_light=True,
            names_blockers=True,
            sums_open_light=True,
        ),
        Estimator(
            "hemisphere",
            "points of the normal's half-ball",
            names_blockers=True,
            thickness=_THICKNESS_OF_POINTS,
            thickness_beside_backs=_THICKNESS_OF_POINTS,
        ),
        Estimator("zbuffer", "a box in the image", has_radius=False),
        Estimator(
            "bitmask",
            "32 directions of each slice, between fronts and backs",
            gives_light=True,
            takes_steps=True,
            sides=2,
            reads_backs=True,
        ),
        Estimator(
            "gtao",
            "the highest thing on either side of slices",
            takes_steps=True,
            sides=2,
        ),
        Estimator(
            "hbao",
            "the highest thing in directions of the picture",
            takes_steps=True,
        ),
        Estimator("sao", "heights of points on a spiral"),
    )
}
LIGHT_ESTIMATORS = tuple(e.name for e in ESTIMATORS.values() if e.gives_light)


def described(names: Iterable[str]) -> str:
    """Return what the estimators called `names` do, in one line."""
    return "; ".join(f"{name}: {ESTIMATORS[name].doc}" for name in names)
