"""What the screen-space estimators have in common: settings, defines and uniforms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.settings.estimators import DEFAULT_ESTIMATOR, ESTIMATORS, LIGHT_ESTIMATORS, described
from ssdo_gl.settings.fields import SettingError, setting
from ssdo_gl.settings.settings import same_as


@dataclass(frozen=True)
class ScreenSpaceSettings:
    """Settings that ssao, directional and bounce share."""

    estimator: str = setting(
        DEFAULT_ESTIMATOR,
        described(LIGHT_ESTIMATORS),
        choices=LIGHT_ESTIMATORS,
    )
    radius: float = same_as("radius", 0.3)
    samples: int = same_as("samples")
    steps: int = same_as("steps")
    step_growth: float = setting(
        0.5, "0: equal steps; 1: steps lengthen linearly with distance", low=0.0, high=1.0
    )
    front_slack: float = setting(
        0.25,
        "how far a step may pass in front of a solid and still meet it",
        unit="strides",
        low=0.0,
        high=4.0,
    )
    back_slack: float = setting(
        1.0,
        "how far a step may pass behind a solid and still meet it",
        unit="strides",
        low=0.0,
        high=4.0,
    )
    thickness: float | None = setting(
        None,
        "depth of solids whose back is unknown, relative to R; "
        "None: 1 beside a back-face layer, 0.3 without, 2 for hemisphere",
        low=0.0,
        also=(math.inf,),
        slider_high=4.0,
    )
    bias: float = setting(
        0.002,
        "height above the tangent plane that starts to block, relative to R",
        low=0.0,
        slider_high=0.1,
    )
    resolution_scale: float = same_as("resolution_scale")

    @property
    def step_count(self) -> int:
        """Depth reads along each direction; of a slice, each way."""
        return ESTIMATORS[self.estimator].shared_out(self.samples, self.steps)[1]

    @property
    def direction_count(self) -> int:
        """Directions, or slices, per pixel; `samples` rounded down to whole ones."""
        return ESTIMATORS[self.estimator].shared_out(self.samples, self.steps)[0]

    @property
    def receiver_stride(self) -> int:
        """Texels of the frame per pixel of the estimator's image, along one side.

        Raises
        ------
        SettingError
            If `resolution_scale` is neither 0.5 nor 1.
        """
        if self.resolution_scale not in (0.5, 1.0):
            raise SettingError(f"resolution_scale = {self.resolution_scale}: must be 0.5 or 1")
        return 1 if self.resolution_scale == 1.0 else 2


def defines(
    settings: ScreenSpaceSettings,
    has_back_layer: bool,
    refine_count: int = 0,
    *,
    is_open: bool = False,
    keeps_directions: bool = False,
) -> dict[str, int]:
    """Return the loop bounds and switches of an estimator's shader.

    Parameters
    ----------
    refine_count : int
        Bisections of a march towards the sender.
    is_open : bool
        Nothing in view blocks any direction, so nothing has to be looked for.
    keeps_directions : bool
        One pass writes what blocks each direction, or another reads it.
    """
    return {
        "IS_OPEN": int(is_open),
        "KEPT_TEXTURE_COUNT": len(kept_names(settings)) if keeps_directions else 0,
        "DIRECTION_COUNT": settings.direction_count,
        "STEP_COUNT": settings.step_count,
        "REFINE_COUNT": refine_count,
        "HAS_BACK_LAYER": int(has_back_layer),
    }


def kept_names(settings: ScreenSpaceSettings) -> tuple[str, ...]:
    """Return the resources of `screen_space/kept_directions.glsl`: four directions in each."""
    return tuple(f"kept_{i}" for i in range(-(-settings.direction_count // 4)))


def kept_resources(settings: ScreenSpaceSettings) -> dict[str, TextureSpec]:
    """Return what the pass writes that keeps directions."""
    spec = TextureSpec(4, scale=settings.resolution_scale, transient=True)
    return dict.fromkeys(kept_names(settings), spec)


def estimator_uniforms(
    settings: ScreenSpaceSettings, frame: Frame, has_back_layer: bool
) -> dict[str, Any]:
    """Return the uniforms of `screen_space/estimator.glsl` and of what it includes."""
    thickness = settings.thickness
    if thickness is None:
        thickness = default_thickness(settings.estimator, has_back_layer)
    return {
        **frame.view.uniforms(),
        "u_receiver_stride": settings.receiver_stride,
        "u_pattern_offset": pattern_offset(frame.pattern),
        "u_near_vs": frame.view.near,
        "u_radius": settings.radius,
        "u_thickness": thickness,
        "u_bias": settings.bias,
        "u_step_growth": settings.step_growth,
        "u_front_slack": settings.front_slack,
        "u_back_slack": settings.back_slack,
    }


def default_thickness(estimator: str, has_back_layer: bool) -> float:
    """Return the thickness that stands for None, relative to R."""
    chosen = ESTIMATORS[estimator]
    return chosen.thickness_beside_backs if has_back_layer else chosen.thickness


@lru_cache(maxsize=64)
def pattern_offset(seed: int) -> tuple[int, int, int]:
    """Return where the sample sequence starts, as fractions of 2^32, for a frame's seed."""
    x, y, z = np.random.SeedSequence(seed).generate_state(3, np.uint32)
    return int(x), int(y), int(z)
