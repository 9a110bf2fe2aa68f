"""Frames of a window: what is kept between them, and passes that take several."""

from __future__ import annotations

import dataclasses
import weakref
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import pytest
from graph.painting import Paint, chain, frame

from ssdo_gl.gpu import texture_pool
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.render_pass import RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec


class Climb(RenderPass):
    """In live frames it comes one nearer to its goal each time; else it is there at once."""

    name = "climb"
    writes: ClassVar[Mapping[str, TextureSpec]] = {"climb": TextureSpec(1, own=True)}
    depends_on = ("goal",)
    is_gradual = True

    def execute(self, context):
        goal = context.frame.versions["goal"]
        known = context.last["climb"].facts if context.last else None
        height = goal if known is None else min(known + 1, goal)
        self.is_settled = height == goal
        texture = context.gl.texture((1, 1), 1, np.float32(height).tobytes(), dtype="f4")
        return {"climb": TextureWithFacts(texture, height)}


def live(**versions):
    return dataclasses.replace(frame(**versions), is_live=True)


def lit():
    """An image that reads a table, which no view is part of."""
    return [Paint("table", own=True, depends_on=["lights"]), Paint("a", reads=["table"])]


@pytest.mark.parametrize("made", [live, frame])
def test_a_window_keeps_what_no_view_is_part_of_while_it_shows_other_images(world, made):
    run, executor = world
    passes = lit()
    run(passes, ["a"], made(lights=1))
    kept = weakref.ref(executor.texture("table"))
    run([Paint("b")], ["b"], made(lights=1))
    with pytest.raises(KeyError):
        executor.texture("table")
    assert (kept() is not None) == (made is live)
    assert [row.ran for row in run(passes, ["a"], made(lights=1))] == [made is frame, True]
    run([Paint("b")], ["b"], made(lights=1))
    run([Paint("b")], ["b"], made(lights=2))
    assert kept() is None, "kept of a scene that is gone"


def test_a_moving_scene_makes_no_new_textures(world, monkeypatch):
    run, _ = world
    passes = chain()
    passes[0].depends_on = ("geometry",)
    run(passes, ["smooth_2"], live(geometry=0))
    made = []
    monkeypatch.setattr(texture_pool, "make_texture", lambda *_: made.append(1))
    for number in range(1, 4):
        run(passes, ["smooth_2"], live(geometry=number))
    assert made == []


def test_a_gradual_pass_runs_in_live_frames_until_it_is_settled(world):
    run, executor = world
    passes = [Climb(), Paint("a", reads=["climb"])]
    run(passes, ["a"], live(goal=2))
    assert executor.is_settled
    heights = []
    for _ in range(5):
        ran = [row.ran for row in run(passes, ["a", "climb"], live(goal=5))]
        heights.append((read_texture(executor.texture("climb")).max(), executor.is_settled, *ran))
    going, settled, done = (True, True), (5.0, True, True, True), (5.0, True, False, False)
    assert heights == [(3.0, False, *going), (4.0, False, *going), settled, done, done]


def test_frames_that_are_not_live_know_nothing_of_those_before(world):
    run, executor = world
    passes = [Climb(), Paint("a", reads=["climb"])]
    run(passes, ["a"], live(goal=2))
    run(passes, ["a"], live(goal=5))
    rows = run(passes, ["a", "climb"], frame(goal=5))
    assert [row.ran for row in rows] == [True, True]
    assert read_texture(executor.texture("climb")).max() == 5.0
    assert executor.is_settled
