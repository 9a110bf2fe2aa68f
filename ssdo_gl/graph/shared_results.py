"""What several executors make of one scene on one device, each made once."""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from weakref import WeakSet, WeakValueDictionary

from ssdo_gl.gpu.texture_pool import Format
from ssdo_gl.graph.render_pass import TextureWithFacts

if TYPE_CHECKING:
    import moderngl

    from ssdo_gl.graph.execute import Executor

# Of all tables together: a number stands for one thing only.
_UNUSED = itertools.count()


class Identities:
    """Numbers that are equal exactly where what they stand for is equal.

    Attributes
    ----------
    parts : dict of number to int
        How often a gradual pass has run for what a number stands for, and left work to do.
    """

    # A moving camera makes new identities every frame; forgetting all of them once in
    # a while costs one full frame and keeps memory flat.
    MOST = 16384

    def __init__(self) -> None:
        self.parts: dict[int, int] = {}
        self._numbers: dict[Hashable, int] = {}

    def of(self, key: Hashable) -> int:
        """Return the number of `key`."""
        known = self._numbers.get(key)
        if known is None:
            known = self._numbers[key] = next(_UNUSED)
        return known

    def add_part(self, number: int) -> None:
        """Note that a pass has left work to do of what `number` stands for."""
        self.parts[number] = self.parts.get(number, 0) + 1

    def tidy(self) -> None:
        """Forget all of them if they have become many; only between two frames."""
        if len(self._numbers) > self.MOST:
            self._numbers.clear()
            self.parts.clear()


@dataclass(eq=False)
class KeptResult:
    """What a pass left behind, and what it was made from.

    Textures that were lent on are missing among `borrowed`, which `formats` tells in full;
    until then `target` draws into them. `source` is the identity but for the part of a
    gradual pass, -1 where it belongs to one executor alone.
    """

    identity: int
    textures: dict[str, moderngl.Texture]
    borrowed: dict[str, moderngl.Texture]
    formats: dict[str, Format]
    target: moderngl.Framebuffer | None
    source: int = -1
    facts: dict[str, object] = field(default_factory=dict)

    def returned(self) -> dict[str, TextureWithFacts]:
        """Return the textures that the pass made itself, with their facts."""
        own = (name for name in self.textures if name not in self.borrowed)
        return {n: TextureWithFacts(self.textures[n], self.facts.get(n)) for n in own}

    def has_taken(self, others: Mapping[str, moderngl.Texture]) -> bool:
        """Return whether a texture that another pass has made is among its own."""
        return not {*self.textures.values()}.isdisjoint(others.values())

    def forget(self) -> None:
        """Leave nothing to go on from: given up half-way, sums would hold a part twice."""
        self.textures.clear()
        self.facts.clear()

    def has(self, formats: dict[str, Format]) -> bool:
        """Return whether it holds textures of these formats, in their order."""
        if len(self.borrowed) < len(self.formats):
            return False
        return self.formats is formats or [*self.formats.items()] == [*formats.items()]


class SharedResults:
    """Results that no view is part of, for all executors of one scene on one device.

    Who needs one first makes it, the others take it over; it is freed with the last of
    them. A gradual pass goes on from what any of them has left, unless others still need it
    as it is.
    """

    def __init__(self) -> None:
        self.identities = Identities()
        self.holders: WeakSet[Executor] = WeakSet()
        self._made: WeakValueDictionary[int, KeptResult] = WeakValueDictionary()

    def find(self, source: int) -> KeptResult | None:
        """Return what was made last from the same, whole or in part."""
        result = self._made.get(source)
        return result if result is not None and result.source == source else None

    def add(self, result: KeptResult, source: int) -> None:
        """Let others find a result, which is made from `source` now."""
        result.source = source
        self._made[source] = result

    def is_held_by_others(self, result: KeptResult, holder: Executor) -> bool:
        """Return whether anybody but `holder` needs `result`."""
        return any(other is not holder and other.holds(result) for other in self.holders)
