"""What passes set that include ``lib/terms.glsl``: the terms of the picture by number."""

from __future__ import annotations

from collections.abc import Sequence

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
