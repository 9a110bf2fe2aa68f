"""What of running a plan is the same in every frame, found out once."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter

from ssdo_gl.gpu.texture_pool import Format
from ssdo_gl.graph.graph import Plan
from ssdo_gl.graph.render_pass import RenderPass

# Domains that no view is part of.
SCENE_DOMAINS = frozenset({"geometry", "materials", "lights", "environment"})


@dataclass(frozen=True, eq=False)
class Step:
    """One pass of a plan, for frames of one size.

    Attributes
    ----------
    kind : hashable
        Equal for passes that make the same of the same input.
    inputs_of : callable
        Picks those of its reads whose change makes its result stale out of a dict.
    versions_of : callable
        Picks the domains that it depends on out of a dict.
    formats : dict of resource to Format
        Of the textures that it borrows.
    lends : tuple of (pass name, resource)
        Transient textures that nobody reads after it.
    is_of_scene : bool
        Whether its result is the same for every view, in textures of its own.
    """

    item: RenderPass
    kind: Hashable
    inputs_of: Callable[[Mapping[str, int]], object]
    versions_of: Callable[[Mapping[str, int]], object]
    formats: dict[str, Format]
    lends: tuple[tuple[str, str], ...]
    is_of_scene: bool


class PlanSteps:
    """The steps of a plan, for frames of one size.

    It holds for as long as plan and size are the same: passes do not change.

    Attributes
    ----------
    formats : dict of pass name to dict of resource to Format
        `Step.formats`.
    domains : tuple of str
        Those that any pass depends on.
    shape : hashable
        Equal where the same textures are needed.
    """

    def __init__(self, plan: Plan, size: tuple[int, int]) -> None:
        self.plan = plan
        self.size = size
        writers = {resource: item for item in plan.order for resource in item.writes}
        named = (domain for item in plan.order for domain in item.depends_on)
        self.domains = tuple(dict.fromkeys(named))
        lends: dict[int, list[tuple[str, str]]] = {}
        for resource, last in plan.last_readers().items():
            lends.setdefault(last, []).append((writers[resource].name, resource))
        of_scene: set[str] = set()
        for item in plan.order:
            is_own = all(spec.own for spec in item.writes.values())
            if is_own and SCENE_DOMAINS.issuperset(item.depends_on) and of_scene >= {*item.reads}:
                of_scene.update(item.writes)
        self.order = tuple(
            _step(item, size, tuple(lends.get(number, ())), of_scene >= item.writes.keys())
            for number, item in enumerate(plan.order)
        )
        self.formats = {step.item.name: step.formats for step in self.order}
        self.shape = size, tuple((i.name, tuple(i.writes.items())) for i in plan.order)


def _step(
    item: RenderPass,
    size: tuple[int, int],
    lends: tuple[tuple[str, str], ...],
    is_of_scene: bool,
) -> Step:
    stale_by = tuple(name for name in item.reads if name not in item.steady_reads)
    formats: dict[str, Format] = {
        name: (spec.size(size), spec.components, spec.dtype)
        for name, spec in item.writes.items()
        if not spec.own
    }
    writes = tuple(item.writes.items())
    key = item.settings_key()
    # Tables and maps stay while a window changes the size of its picture.
    size_of = size if formats else None
    kind = item.name, type(item), key, writes, size_of, stale_by, item.depends_on
    picks = _picking(stale_by), _picking(item.depends_on)
    return Step(item, kind, *picks, formats, lends, is_of_scene)


def _picking(names: Sequence[str]) -> Callable[[Mapping[str, int]], object]:
    """Return what picks the values of `names` out of a dict, always in the same way."""
    return itemgetter(*names) if names else lambda values: None
