"""The frame graph orders, culls and refuses; no OpenGL is needed for that."""

from __future__ import annotations

import subprocess
import sys

import pytest

from ssdo_gl.graph.graph import GraphError, compile_graph
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.graph.resource import TextureSpec


class Step(RenderPass):
    """A pass that only declares."""

    def __init__(self, name: str, reads: str = "", writes: str = "") -> None:
        self.name = name
        self.reads = tuple(reads.split())
        self.writes = {resource: TextureSpec(4) for resource in writes.split()}

    def execute(self, context):
        raise AssertionError("compiling must not run a pass")


def names(passes):
    return [item.name for item in passes]


def test_order_follows_data_not_the_order_of_adding():
    passes = [Step("c", "b", "out"), Step("a", "", "a"), Step("b", "a", "b")]
    assert names(compile_graph(passes, ["out"]).order) == ["a", "b", "c"]


def test_passes_nobody_reads_are_culled_transitively():
    r"""
    gbuffer --> direct --> out
          \--> ao --> blur          nobody reads blur, so ao goes too
    """
    passes = [
        Step("gbuffer", "", "z"),
        Step("ao", "z", "raw"),
        Step("blur", "raw", "smooth"),
        Step("direct", "z", "out"),
    ]
    plan = compile_graph(passes, ["out"])
    assert names(plan.order) == ["gbuffer", "direct"]
    assert names(plan.culled) == ["ao", "blur"]


def test_a_diamond_runs_its_source_once():
    passes = [Step("s", "", "z"), Step("l", "z", "l"), Step("r", "z", "r"), Step("j", "l r", "out")]
    assert names(compile_graph(passes, ["out"]).order) == ["s", "l", "r", "j"]


def test_outputs_may_name_intermediate_resources():
    passes = [Step("a", "", "a"), Step("b", "a", "b")]
    plan = compile_graph(passes, ["a", "a"])
    assert names(plan.order) == ["a"]
    assert plan.outputs == ("a",)


def test_every_wiring_fault_is_in_one_message():
    passes = [Step("x", "nowhere", "out"), Step("y", "", "out"), Step("x", "", "z")]
    with pytest.raises(GraphError) as caught:
        compile_graph(passes, ["out", "missing"])
    message = str(caught.value)
    assert "two passes are called 'x'" in message
    assert "'out' is written by both 'x' and 'y'" in message
    assert "'x' reads 'nowhere'" in message
    assert "'missing' is written by no pass" in message


def test_a_cycle_is_named():
    passes = [Step("a", "y", "x"), Step("b", "x", "y")]
    with pytest.raises(GraphError, match="a -> b -> a"):
        compile_graph(passes, ["x"])


def test_the_graph_never_imports_moderngl():
    code = (
        "import sys, ssdo_gl.graph.graph, ssdo_gl.graph.frame; assert 'moderngl' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("frame", "scale", "expected"),
    [((640, 360), 1.0, (640, 360)), ((641, 7), 0.5, (321, 4)), ((1, 1), 0.5, (1, 1))],
)
def test_texture_sizes_round_up(frame, scale, expected):
    assert TextureSpec(1, scale=scale).size(frame) == expected
