"""What passes left behind: for one executor, or made once for all of one scene on one device."""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from weakref import WeakSet, WeakValueDictionary

from ssdo_gl.gpu.texture_pool import Format, TexturePool
from ssdo_gl.graph.plan_steps import PlanSteps, Step
from ssdo_gl.graph.render_pass import TextureWithFacts

if TYPE_CHECKING:
    import moderngl

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
        """Leave nothing to go on from."""
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
        self.holders: WeakSet[PassResults] = WeakSet()
        self._made: WeakValueDictionary[int, KeptResult] = WeakValueDictionary()

    def find(self, source: int) -> KeptResult | None:
        """Return what was made last from the same, whole or in part."""
        result = self._made.get(source)
        return result if result is not None and result.source == source else None

    def add(self, result: KeptResult, source: int) -> None:
        """Let others find a result, which is made from `source` now."""
        result.source = source
        self._made[source] = result


class PassResults:
    """What the passes of one executor left behind, in textures of its own pool.

    Attributes
    ----------
    present : dict of pass name to KeptResult
        What was made, or taken over, last.
    """

    def __init__(self, gl: moderngl.Context, shared: SharedResults) -> None:
        self.pool = TexturePool(gl)
        self.present: dict[str, KeptResult] = {}
        self._shared = shared
        shared.holders.add(self)

    def holds(self, result: KeptResult) -> bool:
        """Return whether somebody reads from a result."""
        return any(item is result for item in self.present.values())

    def forget(self) -> None:
        """Let nothing pass for what is wanted."""
        for result in self.present.values():
            result.identity = -1

    def release(self) -> None:
        """Free all; what is shared, with the last who holds it."""
        for name in list(self.present):
            self._discard(name)
        self.pool.trim()

    def fit(self, all_formats: Mapping[str, dict[str, Format]], *, keeps_shared: bool) -> None:
        """Free what passes of these formats have no use for.

        Of frames in a window, what no view is part of stays for as long as the scene: who
        looks at depth or at a method without rays soon wants the light again, without the
        second that its rays take.
        """
        for name, result in list(self.present.items()):
            formats = all_formats.get(name)
            if formats is None:
                if not (keeps_shared and result.source >= 0):
                    self._discard(name)
            # A transient texture that was lent on is missing; that is no misfit.
            elif any(formats.get(n) != result.formats[n] for n in result.borrowed):
                self._discard(name)
        self.pool.trim()

    def take_over(self, steps: PlanSteps, sources: dict[str, int]) -> None:
        """Take what is wanted of results that others have made."""
        for step in steps.order:
            name, source = step.item.name, sources[step.item.name]
            result = self.present.get(name)
            if not step.is_of_scene or (result is not None and result.source == source):
                continue
            made = self._shared.find(source)
            if made is not None:
                self._discard(name)
                self.present[name] = made

    def prepared(self, step: Step, source: int) -> KeptResult:
        """Return a result of the pass whose textures fit its declaration."""
        name = step.item.name
        result = self.present.get(name)
        if result is None or not self._may_change(result, step, source):
            self._discard(name)
            result = self.present[name] = self._new_result(step)
        if step.is_of_scene:
            self._shared.add(result, source)
        else:
            result.source = -1
        return result

    def _may_change(self, result: KeptResult, step: Step, source: int) -> bool:
        """Return whether a result fits, and nobody needs it as it is."""
        if not result.has(step.formats):
            return False
        # Others who hold what comes of the same source want it to go on.
        if result.source in (-1, source):
            return True
        holders = self._shared.holders
        return not any(other is not self and other.holds(result) for other in holders)

    def _new_result(self, step: Step) -> KeptResult:
        borrowed = {n: self.pool.borrow(*format_) for n, format_ in step.formats.items()}
        target = self.pool.target(list(borrowed.values()), depth=step.item.needs_depth)
        return KeptResult(-1, dict(borrowed), borrowed, step.formats, target)

    def has_made(self, name: str, identity: int) -> bool:
        """Return whether a pass has run for what has this identity."""
        result = self.present.get(name)
        return result is not None and result.identity == identity

    def lend_on(self, step: Step) -> None:
        """Give back the textures whose last reader is the pass that has just run."""
        for name, resource in step.lends:
            result = self.present.get(name)
            if result is not None and resource in result.borrowed:
                self.pool.give_back(result.borrowed.pop(resource))
                del result.textures[resource]

    def _discard(self, name: str) -> None:
        result = self.present.pop(name, None)
        if result is None:
            return
        for texture in result.borrowed.values():
            self.pool.give_back(texture)
        if not result.borrowed:
            return
        # A pass that has handed one of them on as its own, and has none of the pool, lost it.
        for other in self.present.values():
            if not other.formats and other.has_taken(result.borrowed):
                other.identity = -1
                other.forget()
