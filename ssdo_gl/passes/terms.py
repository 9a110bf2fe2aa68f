"""What passes set that include ``lib/terms.glsl``: the terms of the picture by number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ssdo_gl.passes.brdf_wiring import brdf_wiring

if TYPE_CHECKING:
    import moderngl

# Sampler slots that lib/terms.glsl has.
MOST_IRRADIANCES, MOST_RADIANCES = 6, 4


def term_defines(irradiances: Sequence[str], radiances: Sequence[str]) -> dict[str, int]:
    """Return how many terms there are.

    Raises
    ------
    ValueError
        If there are more than the shader has slots for.
    """
    if len(irradiances) > MOST_IRRADIANCES or len(radiances) > MOST_RADIANCES:
        raise ValueError(
            f"{len(irradiances)} irradiances and {len(radiances)} radiances: lib/terms.glsl adds "
            f"up to {MOST_IRRADIANCES} and {MOST_RADIANCES}"
        )
    return {"IRRADIANCE_COUNT": len(irradiances), "RADIANCE_COUNT": len(radiances)}


def term_wiring(irradiances: Sequence[str], radiances: Sequence[str]) -> dict[str, str]:
    """Return the resource behind each sampler."""
    return {
        **{f"t_irradiance_{i}": name for i, name in enumerate(irradiances)},
        **{f"t_radiance_{i}": name for i, name in enumerate(radiances)},
    }


class SenderTerms(NamedTuple):
    """What surfaces send on, for ``lib/senders.glsl``.

    Attributes
    ----------
    irradiances : tuple of str
        Resources of irradiance, full size or half of it, rgb.
    radiances : tuple of str
        Resources of what is emitted; only where their alpha is 1.
    """

    irradiances: tuple[str, ...] = ()
    radiances: tuple[str, ...] = ()

    def wiring(self, glossy: bool) -> dict[str, str]:
        """Return the resource behind each sampler; `glossy` is the define GLOSSY."""
        return {**brdf_wiring(glossy), **term_wiring(*self)}

    def defines(self, inputs: Mapping[str, moderngl.Texture]) -> dict[str, int]:
        """Return how many terms there are, and which of them have half the frame's size."""
        half = sum(
            (inputs[name].size != inputs["albedo"].size) << i
            for i, name in enumerate(self.irradiances)
        )
        return {**term_defines(*self), "HALF_IRRADIANCES": half}
