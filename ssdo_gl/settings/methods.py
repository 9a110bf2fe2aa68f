"""The methods of ``--method``: each is a set of effects, which say that they belong to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ssdo_gl.settings.estimators import DEFAULT_ESTIMATOR, ESTIMATORS


@dataclass(frozen=True)
class Method:
    """One method.

    Attributes
    ----------
    name : str
        As ``--method`` knows it.
    label : str
        A few words for people who do not know the name.
    doc : str
        What its picture consists of.
    is_reference : bool
        It traces rays: no view and no depth buffer decides anything.
    estimates : str
        What is estimated in screen space: visibility, light (which estimators of mere
        visibility cannot tell), or nothing.
    is_all_light : bool
        It is to show all light transport: a light is blocked by whatever stands before it,
        not only by what is within R.
    """

    name: str
    label: str
    doc: str
    is_reference: bool = False
    estimates: Literal["nothing", "visibility", "light"] = "nothing"
    is_all_light: bool = False

    @property
    def estimators(self) -> tuple[str, ...]:
        """Names of the estimators that it may use, the default one first."""
        if self.estimates == "nothing":
            return ()
        able = [e.name for e in ESTIMATORS.values() if e.gives_light or self.estimates != "light"]
        return (DEFAULT_ESTIMATOR, *(name for name in able if name != DEFAULT_ESTIMATOR))


METHODS: Mapping[str, Method] = {
    method.name: method
    for method in (
        Method("direct", "direct light", "light of the scene's lights, with their shadows"),
        Method(
            "ssao",
            "SSAO",
            "direct light, and the environment's times screen-space ambient visibility",
            estimates="visibility",
        ),
        Method(
            "ssdo", "SSDO", "direct light, and light through open directions", estimates="light"
        ),
        Method(
            "bounce",
            "SSDO + bounce",
            "SSDO, and one bounce from what blocks directions",
            estimates="light",
        ),
        Method(
            "gi",
            "SSDO + all light",
            "SSDO with light from beyond R, and all bounces",
            estimates="light",
            is_all_light=True,
        ),
        Method(
            "reference-ao",
            "ray-traced AO",
            "as ssao, with ray-traced visibility and shadows",
            is_reference=True,
        ),
        Method(
            "reference-near",
            "near-field reference",
            "as bounce, with ray-traced visibility and senders: the reference of the near field",
            is_reference=True,
        ),
        Method(
            "reference-gi",
            "path-traced GI",
            "all light transport, by paths",
            is_reference=True,
            is_all_light=True,
        ),
    )
}
ALL = frozenset(METHODS)
REFERENCES = frozenset(name for name, method in METHODS.items() if method.is_reference)
