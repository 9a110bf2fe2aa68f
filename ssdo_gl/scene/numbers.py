"""The gate that every number from a file passes."""

from __future__ import annotations

# float32 holds 3.4e38, but sums and products of larger numbers than this leave it.
LARGEST_NUMBER = 1e30
# Coordinates leave float64 for float32 relative to the camera; up to here neither they
# nor their squares overflow there.
LARGEST_COORDINATE = 1e15


def finite(value: object, largest: float = LARGEST_NUMBER) -> float | None:
    """Return `value` as a float if it is a number of usable size, else None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    if not abs(value) <= largest:  # also false for NaN
        return None
    return float(value)
