"""What a user may choose for a rendering, in one frozen dataclass."""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

from ssdo_gl.settings import modes
from ssdo_gl.settings.backgrounds import BACKGROUNDS
from ssdo_gl.settings.estimators import DEFAULT_ESTIMATOR, ESTIMATORS
from ssdo_gl.settings.fields import (
    SettingError,
    SettingInfo,
    Unset,
    check,
    describe,
    documented,
    setting,
)
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.wording import described

Combine = Literal["ambient", "multiply", "report"]
COMBINES: tuple[str, ...] = typing.get_args(Combine)
# 16384 is the smallest maximum texture size of desktop OpenGL drivers in use, and
# of llvmpipe; larger frames would need tiling.
MAX_SIZE_PX = 16384
# Lengths, coordinates and sizes of scenes leave float64 for float32 relative to the camera;
# within these ends neither they nor their squares overflow or vanish there.
SHORTEST, LONGEST = 1e-15, 1e15
# Beyond 2^60 the exposed image would leave the range of float32.
MAX_EXPOSURE_EV = 60.0
# About what shaders count without a loop that would be cut off.
MAX_SPP = 1 << 20
# No path reaches as many under Russian roulette: 0.95^512 is 4e-12.
MAX_BOUNCES = 512

LOOK, QUALITY = "what to show", "accuracy against time"
_look = partial(setting, yields=True, group=LOOK, modes=modes.ONE)
_quality = partial(setting, yields=True, group=QUALITY, modes=modes.ONE)


@dataclass(frozen=True)
class Settings:
    """Settings of a rendering; frozen, so that they can be compared and hashed.

    A value out of range raises SettingError, a ValueError. A field that was not given yields
    to what the scene asks for, else it holds its default; None, where it is one, stands for a
    default derived from scene and method. `resolve.resolved` fills in both, and `Renderer`
    calls it.
    """

    method: str = _look("gi", "which quantities make up the image", choices=tuple(METHODS))
    estimator: str | None = _quality(
        None,
        "how screen space is sampled; by default march",
        choices=tuple(ESTIMATORS),
    )
    size: tuple[int, int] = _look(
        (1280, 720),
        "width and height of the picture",
        unit="px",
        low=1,
        high=MAX_SIZE_PX,
        metavar="WxH",
        modes=modes.SIZED,
        is_quality=False,
    )
    samples: int = _quality(48, "depth reads per pixel", low=1, high=1024, metavar="N")
    steps: int = _quality(8, "depth reads along each direction", low=1, high=256, metavar="M")
    spp: int = _quality(
        256,
        "rays or paths per pixel of the references; with --max-error at most, if given",
        low=1,
        high=MAX_SPP,
        metavar="N",
    )
    bounces: int | None = _quality(
        None,
        "indirect bounces of reference-gi; by default all, ended by Russian roulette",
        low=0,
        high=MAX_BOUNCES,
        slider_high=64,
        metavar="B",
        modes=modes.ALL,
    )
    shadow_rays: int = _quality(
        16,
        "rays per pixel to each light, for traced shadows",
        low=1,
        high=MAX_SPP,
        slider_high=4096,
        metavar="N",
        modes=modes.ALL,
    )
    radius: float | None = _quality(
        None,
        "reach R of the near field; by default the scene's, or 0.08 of its diagonal; where no"
        " rays go beyond it, of models 0.32, of rooms 0.64",
        unit="scene units",
        low=SHORTEST,
        high=LONGEST,
        also=(0.0, math.inf),
        slider_high=4.0,
        metavar="R",
        modes=modes.ALL,
    )
    seed: int = _quality(
        0, "selects the sample pattern", low=0, high=(1 << 31) - 1, metavar="S", modes=modes.ALL
    )
    shadows: str | None = _quality(
        None,
        "how lights are shadowed; by default maps, for references rays",
        choices=("map", "traced", "none"),
        modes=modes.ALL,
    )
    combine: Combine | None = _look(  # noqa: RUF009 - a field like the others
        None,
        "what visibility multiplies, for ssao and reference-ao; by default by scene",
        choices=COMBINES,
        modes=modes.ALL,
    )
    filter: str = _quality("edge", "how noise is filtered", choices=("edge", "naive", "none"))
    temporal: str = _quality(
        "on",
        "average frames while something moves, or not",
        choices=("on", "off"),
        modes=modes.LIVE,
        is_quality=False,
    )
    effects: str = _quality(
        "auto", "skip what the scene lacks, or not", choices=("auto", "full"), modes=modes.ALL
    )
    exposure: float | None = _look(
        None,
        "doubles the brightness with each step; by default the camera's",
        unit="EV",
        low=-MAX_EXPOSURE_EV,
        high=MAX_EXPOSURE_EV,
        slider_high=10.0,
        metavar="EV",
        modes=modes.ALL,
    )
    background: str | None = _look(
        None,
        "what is shown where no surface is, a colour or nothing (alpha); by default the"
        " environment, or what suits the light that was added",
        choices=BACKGROUNDS,
        is_color=True,
        metavar="COLOUR|transparent|environment",
        is_quality=False,
    )
    antialias: int = _quality(
        1,
        "sub-pixel jittered frames averaged; 4 for a picture, 16 if anything is translucent",
        low=1,
        high=256,
        metavar="N",
        modes=modes.FRAMES,
        is_quality=False,
    )
    resolution_scale: float = _quality(
        1.0, "size of the estimators' images, relative to the frame", choices=(1.0, 0.5)
    )
    max_error: float | None = _quality(
        None,
        "bound on the relative error: references go on until their standard error is below,"
        " other methods take the cheapest setting measured to be",
        low=1e-9,
        high=1e9,
        slider_high=1.0,
        metavar="E",
    )
    overrides: Mapping[str, Any] = field(
        default_factory=dict,
        metadata={
            "info": SettingInfo(
                {},
                doc="any setting of any pass; a wrong one names what exists",
                flag_name="set",
                metavar="PASS.FIELD=VALUE",
                in_scene=False,
                group=QUALITY,
                modes=modes.ALL,
            )
        },
    )
    # Whether the scene's settings are in; its own None's then stay, whatever the scene says.
    is_resolved: bool = field(default=False, repr=False, compare=False)

    def __hash__(self) -> int:
        fields = [getattr(self, f.name) for f in dataclasses.fields(self) if f.compare]
        return hash(tuple(frozenset(v.items()) if isinstance(v, Mapping) else v for v in fields))

    def __repr__(self) -> str:
        # What was given; the rest follows from the scene and the defaults.
        facts = [
            f"{name}={value!r}"
            for name in describe(type(self))
            if self.gives(name) and (value := getattr(self, name)) != {}
        ]
        return described(self, *facts)

    def __post_init__(self) -> None:
        check(self)

    def checked(self) -> Settings:
        """Return self if its estimator suits its method, or raise SettingError."""
        allowed = METHODS[self.method].estimators
        if self.estimator is not None and self.estimator not in allowed:
            valid = f"expected one of {', '.join(allowed)}" if allowed else "it takes none"
            raise SettingError(f"estimator = {self.estimator!r} for method {self.method}: {valid}")
        return self

    def gives(self, name: str) -> bool:
        """Return whether somebody chose the value of a field."""
        value = getattr(self, name)
        return value is not None and not isinstance(value, Unset)

    @property
    def chosen_estimator(self) -> str:
        """The estimator in force: the chosen one or the default."""
        return self.estimator or DEFAULT_ESTIMATOR

    @property
    def chosen_shadows(self) -> str:
        """map, traced or none: the chosen way, or what fits the method."""
        return self.shadows or ("traced" if self.is_reference else "map")

    @property
    def is_reference(self) -> bool:
        """Whether the method traces rays."""
        return METHODS[self.method].is_reference


def same_as(name: str, default: Any = None, doc: str = "") -> Any:
    """Declare a field of a pass that repeats one of `Settings`: its unit, range, choices.

    Parameters
    ----------
    name : str
        The field of `Settings`.
    default : object or None
        The pass' own default; None: that of `Settings`.
    doc : str
        The effect, where it has other words in the pass.
    """
    info = describe(Settings)[name]
    default = info.default if default is None else default
    return dataclasses.field(
        default=default,
        metadata={"info": dataclasses.replace(info, default=default, doc=doc or info.doc)},
    )


documented(Settings)
