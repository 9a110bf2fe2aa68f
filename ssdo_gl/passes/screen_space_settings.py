"""What the screen-space estimators have in common: settings, defines and uniforms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.settings import SettingError, setting

# Numbers by which `shaders/lib/estimator.glsl` and `ssao.frag` know the estimators.
ESTIMATOR_NUMBERS = {"march": 0, "rgs09": 1, "hemisphere": 2, "zbuffer": 3}


@dataclass(frozen=True)
class ScreenSpaceSettings:
    """Settings that ssao, directional and bounce share."""

    estimator: str = setting(
        "march",
        "march: several depth reads along each direction; rgs09: the paper's single one",
        choices=("march", "rgs09"),
    )
    radius: float = setting(
        0.3, "reach R of the near field; inf: the whole frame", unit="scene units", low=0.0
    )
    samples: int = setting(64, "depth reads per pixel", low=1, high=1024)
    steps: int = setting(8, "of them along each direction, for march", low=1, high=256)
    step_growth: float = setting(
        1.0, "0: equal steps; 1: steps lengthen linearly with distance", low=0.0, high=1.0
    )
    thickness: float = setting(
        0.5, "assumed depth of solids whose back is unknown, relative to R", low=0.0
    )
    bias: float = setting(
        0.002, "height above the tangent plane that starts to block, relative to R", low=0.0
    )
    resolution_scale: float = setting(
        1.0, "size of the estimator's image relative to the frame: 0.5 or 1", low=0.5, high=1.0
    )

    # The estimator's point samples have no steps.
    STEPPING: ClassVar[tuple[str, ...]] = ("march",)

    @property
    def step_count(self) -> int:
        """Depth reads along each direction."""
        return min(self.steps, self.samples) if self.estimator in self.STEPPING else 1

    @property
    def direction_count(self) -> int:
        """Directions per pixel; `samples` rounded down to whole directions."""
        return max(1, self.samples // self.step_count)

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


def defines(settings: ScreenSpaceSettings, has_back_layer: bool) -> dict[str, int]:
    """Return the loop bounds and switches of `lib/estimator.glsl`."""
    return {
        "ESTIMATOR": ESTIMATOR_NUMBERS[settings.estimator],
        "DIRECTION_COUNT": settings.direction_count,
        "STEP_COUNT": settings.step_count,
        "HAS_BACK_LAYER": int(has_back_layer),
    }


def estimator_uniforms(settings: ScreenSpaceSettings, frame: Frame) -> dict[str, Any]:
    """Return the uniforms of `lib/estimator.glsl` and of what it includes."""
    return {
        **frame.view.uniforms(),
        "u_receiver_stride": settings.receiver_stride,
        "u_pattern_offset": pattern_offset(frame.seed),
        "u_near_vs": frame.view.near,
        "u_radius": settings.radius,
        "u_thickness": settings.thickness,
        "u_bias": settings.bias,
        "u_step_growth": settings.step_growth,
    }


def pattern_offset(seed: int) -> tuple[int, int, int]:
    """Return where the sample sequence starts, as fractions of 2^32, for a frame's seed."""
    x, y, z = np.random.SeedSequence(seed).generate_state(3, np.uint32)
    return int(x), int(y), int(z)
