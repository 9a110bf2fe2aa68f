"""Orders passes and culls those whose results nobody reads. No OpenGL here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ssdo_gl.graph.render_pass import RenderPass


class GraphError(Exception):
    """Wiring faults of a graph, all of them in one message."""


@dataclass(frozen=True)
class Plan:
    """The outcome of compiling a graph.

    Attributes
    ----------
    order : tuple of RenderPass
        Passes to run, each after the producers of what it reads.
    culled : tuple of RenderPass
        Passes that no wanted output needs, in the order they were added.
    """

    order: tuple[RenderPass, ...]
    culled: tuple[RenderPass, ...]
    outputs: tuple[str, ...]

    def last_readers(self) -> dict[str, int]:
        """Return, for each transient resource, the place in `order` of its last reader.

        Outputs are not among them: they are read after the frame.
        """
        last = {resource: index for index, item in enumerate(self.order) for resource in item.reads}
        return {
            resource: last[resource]
            for item in self.order
            for resource, spec in item.writes.items()
            if spec.transient and resource not in self.outputs and resource in last
        }


def compile_graph(passes: Sequence[RenderPass], outputs: Iterable[str]) -> Plan:
    """Walk backwards from `outputs` and return the passes that they need, in order.

    Raises
    ------
    GraphError
        Two passes of one name, two writers of one resource, a read or an output
        that nobody writes, or a cycle.
    """
    wanted = tuple(dict.fromkeys(outputs))
    faults: list[str] = []
    names: set[str] = set()
    writer: dict[str, RenderPass] = {}
    for item in passes:
        if item.name in names:
            faults.append(f"two passes are called {item.name!r}")
        names.add(item.name)
        for resource in item.writes:
            if resource in writer:
                faults.append(
                    f"{resource!r} is written by both {writer[resource].name!r} and {item.name!r}"
                )
            writer.setdefault(resource, item)

    order: list[RenderPass] = []
    state: dict[str, str] = {}

    def visit(item: RenderPass, path: tuple[str, ...]) -> None:
        if state.get(item.name) == "done":
            return
        if state.get(item.name) == "open":
            faults.append(f"cycle: {' -> '.join((*path, item.name))}")
            return
        state[item.name] = "open"
        for resource in item.reads:
            if resource in writer:
                visit(writer[resource], (*path, item.name))
            else:
                faults.append(f"pass {item.name!r} reads {resource!r}, which no pass writes")
        state[item.name] = "done"
        order.append(item)

    for output in wanted:
        if output in writer:
            visit(writer[output], ())
        else:
            faults.append(f"output {output!r} is written by no pass")
    if faults:
        raise GraphError("; ".join(dict.fromkeys(faults)))
    culled = tuple(item for item in passes if item.name not in state)
    return Plan(tuple(order), culled, wanted)
