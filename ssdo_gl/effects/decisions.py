"""What is decided about a frame, each decision with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Decision:
    """One effect, whether it is simulated, and why, in a sentence for the user.

    Attributes
    ----------
    passes : tuple of str
        The passes of the full pipeline that it decides about.
    instead : tuple of str
        What runs in their place.
    """

    effect: str
    run: bool
    reason: str
    passes: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()


@dataclass(frozen=True)
class Decided:
    """All that was decided about a frame: two frames with equal ones run the same passes.

    Attributes
    ----------
    running : frozenset of str
        Names of the effects that run.
    lights : tuple of bool, or None
        For each light of the scene, whether it can matter. None: as the scene says.
    rows : tuple of Decision
        In the order in which they were taken.
    """

    running: frozenset[str]
    lights: tuple[bool, ...] | None
    rows: tuple[Decision, ...]

    def runs(self, *names: str) -> bool:
        """Return whether any of the effects of these names runs."""
        return not self.running.isdisjoint(names)

    def spares(self, effect: str) -> bool:
        """Return whether a row says that `effect`, as users know it, is not simulated."""
        return any(row.effect == effect and not row.run for row in self.rows)
