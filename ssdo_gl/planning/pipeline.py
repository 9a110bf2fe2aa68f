"""The passes of a frame, with what each of them is for."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

from ssdo_gl.effects.effect import ImageSource
from ssdo_gl.effects.request import Decided
from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.graph.render_pass import RenderPass


@dataclass(frozen=True)
class Pipeline:
    """Passes for what was asked for.

    Attributes
    ----------
    outputs : dict of image name to ImageSource
    reasons : dict of pass name to why it runs
    skipped : dict of pass name to why it is not needed
    """

    passes: tuple[RenderPass, ...]
    outputs: dict[str, ImageSource]
    decided: Decided
    reasons: dict[str, str] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)

    @property
    def resources(self) -> tuple[str, ...]:
        """Resources that must be made, for the graph."""
        named = (output.resource for output in self.outputs.values())
        return tuple(dict.fromkeys(name for name in named if name is not None))

    @property
    def order(self) -> tuple[RenderPass, ...]:
        """The passes that run, each behind what it reads."""
        return compile_graph(self.passes, self.resources).order

    def changed(self, others: Mapping[RenderPass, RenderPass | None], reason: str = "") -> Pipeline:
        """Return the pipeline with `others` for some passes; None: left out, for a `reason`."""
        found = (others.get(item, item) for item in self.passes)
        spared = {item.name: reason for item, other in others.items() if other is None}
        return dataclasses.replace(
            self,
            passes=tuple(item for item in found if item is not None),
            skipped={**self.skipped, **spared},
        )
