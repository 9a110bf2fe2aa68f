"""What a user may choose for a rendering, in one frozen dataclass."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ssdo_gl.effects.methods import METHODS
from ssdo_gl.settings.fields import SettingError, check, setting

Combine = Literal["ambient", "multiply", "report"]
SHADOWS = (None, "map", "traced", "none")
# 16384 is the smallest maximum texture size of desktop OpenGL drivers in use, and
# of llvmpipe; larger frames would need tiling.
MAX_SIZE_PX = 16384


@dataclass(frozen=True)
class Settings:
    """Settings of a rendering; each field's line says unit, range and effect.

    ``radius``, ``estimator``, ``combine`` and ``exposure`` may be None: the scene's
    own wish holds, and without one a default derived from scene and method.
    """

    method: str = setting("bounce", "which quantities make up the image", choices=tuple(METHODS))
    estimator: str | None = setting(None, "how screen space is sampled; None: by method")
    size: tuple[int, int] = setting((1280, 720), "width and height", unit="px")
    samples: int = setting(64, "depth reads per pixel", low=1, high=1024)
    steps: int = setting(8, "depth reads along each direction", low=1, high=256)
    spp: int = setting(256, "rays or paths per pixel of the references", low=1, high=1 << 20)
    bounces: int | None = setting(
        None, "indirect bounces of reference-gi; None: 16 with Russian roulette", low=0, high=64
    )
    shadow_rays: int = setting(16, "rays per pixel and light, traced shadows", low=1, high=4096)
    radius: float | None = setting(
        None, "reach R of the near field; None: by scene", unit="scene units", low=0.0
    )
    seed: int = setting(0, "selects the sample pattern", low=0, high=(1 << 31) - 1)
    shadows: str | None = setting(
        None, "how lights are shadowed; None: maps, for references traced", choices=SHADOWS
    )
    combine: Combine | None = setting(
        None, "what visibility multiplies, for ssao and reference-ao; None: by scene"
    )
    filter: str = setting("edge", "denoising filter", choices=("edge", "naive", "none"))
    effects: str = setting("auto", "skip what the scene lacks, or not", choices=("auto", "full"))
    exposure: float | None = setting(None, "exposure; None: the camera's", unit="EV")
    antialias: int = setting(1, "sub-pixel jittered frames averaged", low=1, high=256)
    resolution_scale: float = setting(1.0, "size of the estimators' images, relative")
    max_error: float | None = setting(
        None, "references stop below this standard error (relative)", low=0.0
    )
    overrides: Mapping[str, Any] = field(
        default_factory=dict, metadata={"info": setting({}, "PASS.FIELD values").metadata["info"]}
    )

    def checked(self) -> Settings:
        """Return self after checking every field, or raise SettingError."""
        check(self)
        width, height = self.size
        if not (1 <= width <= MAX_SIZE_PX and 1 <= height <= MAX_SIZE_PX):
            raise SettingError(
                f"size = {width}x{height}: each side must be within 1 to {MAX_SIZE_PX} px"
            )
        allowed = METHODS[self.method].estimators
        if self.estimator is not None and self.estimator not in allowed:
            valid = f"choose one of {', '.join(allowed)}" if allowed else "it takes none"
            raise SettingError(f"estimator = {self.estimator!r} for method {self.method}: {valid}")
        if self.combine not in (None, "ambient", "multiply", "report"):
            raise SettingError(
                f"combine = {self.combine!r}: choose one of ambient, multiply, report"
            )
        if self.resolution_scale not in (0.5, 1.0):
            raise SettingError(f"resolution_scale = {self.resolution_scale}: must be 0.5 or 1")
        if self.exposure is not None and not math.isfinite(self.exposure):
            raise SettingError(f"exposure = {self.exposure}: must be a finite number of EV")
        return self

    @property
    def chosen_estimator(self) -> str:
        """The estimator in force: the chosen one or the method's default."""
        return self.estimator or METHODS[self.method].estimator

    @property
    def chosen_shadows(self) -> str:
        """map, traced or none: the chosen way, or what fits the method."""
        return self.shadows or ("traced" if self.is_reference else "map")

    @property
    def is_reference(self) -> bool:
        """Whether the method traces rays."""
        return METHODS[self.method].is_reference
