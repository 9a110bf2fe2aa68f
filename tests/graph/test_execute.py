"""The executor: what runs again, what is kept, what is lent on."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from graph.painting import Paint, chain, frame

from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.render_pass import TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec


def test_an_unchanged_frame_runs_nothing_again(world):
    run, executor = world
    passes = [Paint("a"), Paint("b", reads=["a"])]
    assert [row.ran for row in run(passes, ["b"], frame())] == [True, True]
    assert [row.ran for row in run(passes, ["b"], frame())] == [False, False]
    assert read_texture(executor.texture("b")).max() == 1.0


def test_a_change_travels_downstream_only(world):
    run, _ = world
    first, side = Paint("a"), Paint("c")
    last = Paint("b", reads=["a", "c"])
    run([first, side, last], ["b"], frame())
    first.value = 2.0
    assert [row.ran for row in run([first, side, last], ["b"], frame())] == [True, False, True]


def test_a_pass_runs_again_when_its_domain_changes_and_no_other(world):
    run, _ = world
    passes = [Paint("a", depends_on=["view"])]
    run(passes, ["a"], frame(view=1, seed=1))
    assert not run(passes, ["a"], frame(view=1, seed=2))[0].ran
    assert run(passes, ["a"], frame(view=2, seed=2))[0].ran


def test_another_size_makes_new_textures(world):
    run, executor = world
    passes = [Paint("a")]
    run(passes, ["a"], frame())
    assert run(passes, ["a"], frame(size=(7, 5)))[0].ran
    assert executor.texture("a").size == (7, 5)


def test_what_has_no_size_of_the_frame_outlives_another_size(world):
    run, _ = world
    passes = [Paint("table", own=True), Paint("a", reads=["table"])]
    run(passes, ["a"], frame())
    assert [row.ran for row in run(passes, ["a"], frame(size=(7, 5)))] == [False, True]


def test_passes_no_longer_wanted_are_freed(world):
    run, executor = world
    passes = [Paint("a"), Paint("b")]
    run(passes, ["a", "b"], frame())
    run(passes, ["a"], frame())
    with pytest.raises(KeyError):
        executor.texture("b")


def test_a_pass_may_bring_its_own_texture(world):
    run, executor = world
    run([Paint("table", value=5.0, own=True)], ["table"], frame())
    assert executor.texture("table").size == (1, 1)
    assert read_texture(executor.texture("table")).item() == 5.0


class Table(Paint):
    """Makes a texture of its own and says its value to whoever reads it."""

    def execute(self, context):
        made = super().execute(context)
        return {self.name: TextureWithFacts(made[self.name], ("value", self.value))}


class Reader(Paint):
    """Keeps the facts that it was given."""

    def execute(self, context):
        self.seen = dict(context.facts)
        return super().execute(context)


def test_facts_come_with_the_resource_and_are_as_old_as_it_is(world):
    run, _ = world
    table, other = Table("table", own=True), Table("other", own=True)
    reader = Reader("a", reads=["table", "plain"], depends_on=["view"])
    passes = [table, other, Paint("plain"), reader]
    run(passes, ["a", "other"], frame(view=1))
    assert reader.seen == {"table": ("value", 1.0)}, "of what it reads, nothing else"
    run(passes, ["a", "other"], frame(view=2))
    assert (table.runs, reader.runs) == (1, 2)
    assert reader.seen == {"table": ("value", 1.0)}, "kept with the texture"
    table.value = 2.0
    run(passes, ["a", "other"], frame(view=2))
    assert reader.seen == {"table": ("value", 2.0)}
    silent = Paint("table", value=3.0, own=True)
    run([silent, *passes[1:]], ["a", "other"], frame(view=2))
    assert reader.seen == {}, "facts of a texture that is gone"


def test_forget_makes_a_pass_run_again(world):
    run, executor = world
    item = Paint("a")
    run([item], ["a"], frame())
    executor.forget()
    run([item], ["a"], frame())
    assert item.runs == 2


class Interrupting(Paint):
    """Paints, then gives the frame up."""

    gives_up = False

    def execute(self, context):
        made = super().execute(context)
        if self.gives_up:
            raise InterruptedError
        return made


def test_what_a_frame_finished_before_it_was_given_up_stands(world):
    run, executor = world
    first, second = Paint("a"), Interrupting("b", reads=["a"])
    run([first, second], ["b"], frame())
    first.value, second.value, second.gives_up = 2.0, 3.0, True
    with pytest.raises(InterruptedError):
        run([first, second], ["b"], frame())
    second.value, second.gives_up = 1.0, False
    assert [row.ran for row in run([first, second], ["b"], frame())] == [False, True]
    second.value, second.gives_up = 3.0, True
    with pytest.raises(InterruptedError):
        run([first, second], ["b"], frame())
    # What is wanted is as it was, and yet it was drawn over.
    second.value, second.gives_up = 1.0, False
    assert [row.ran for row in run([first, second], ["b"], frame())] == [False, True]
    assert read_texture(executor.texture("b")).max() == 1.0


class HandsOn(Paint):
    """Returns what it reads as it is."""

    def execute(self, context):
        self.runs += 1
        return {self.name: context.inputs[self.reads[0]]}


def test_what_was_handed_on_goes_with_who_made_it(world):
    """A frame of another size, given up in between, has freed it."""
    run, executor = world
    stopping = Interrupting("stop", reads=["a"])
    passes = [Paint("a"), stopping, HandsOn("b", reads=["a", "stop"], own=True)]
    run(passes, ["b"], frame())
    stopping.gives_up = True
    with pytest.raises(InterruptedError):
        run(passes, ["b"], frame(size=(7, 5)))
    stopping.gives_up = False
    run(passes, ["b"], frame())
    assert read_texture(executor.texture("b")).shape[:2] == (3, 4)


def test_times_are_measured_on_request(world):
    run, _ = world
    assert run([Paint("a")], ["a"], frame())[0].gpu_ms is None
    rows = run([Paint("a", value=3.0)], ["a"], frame(), time_passes=True)
    assert rows[0].gpu_ms > 0.0


def test_plans_of_other_passes_with_the_same_name_replace_each_other(world):
    run, executor = world
    run([Paint("a")], ["a"], frame())
    wider = Paint("a")
    wider.writes = {"a": dataclasses.replace(wider.writes["a"], components=4)}
    assert run([wider], ["a"], frame())[0].ran
    assert executor.texture("a").components == 4


def test_targets_are_in_the_order_that_the_pass_names_them_in(world):
    """Two plans whose passes of one name write the same images in another order."""
    run, executor = world

    class Two(Paint):
        def execute(self, context):
            for number, attachment in enumerate(context.target.color_attachments):
                attachment.write(np.full((3, 4), float(number), np.float32).tobytes())

    for names in (("a", "b"), ("b", "a")):
        both = Two("pair")
        both.writes = dict.fromkeys(names, TextureSpec(1))
        run([both], list(names), frame())
        for number, name in enumerate(names):
            assert np.all(read_texture(executor.texture(name)) == number)


def test_transient_textures_are_lent_on_within_the_frame(world):
    run, executor = world
    run(chain(), ["smooth_1", "smooth_2"], frame())
    # Four resources: raw_2 takes over raw_1's texture, the smooth ones are kept.
    assert executor.texture_count == 3


def test_a_lost_texture_is_made_again_only_if_somebody_needs_it(world):
    run, _ = world
    passes = chain()
    run(passes, ["smooth_1", "smooth_2"], frame())
    assert [row.ran for row in run(passes, ["smooth_1", "smooth_2"], frame())] == [False] * 4
    passes[3].value = 2.0
    ran = [row.ran for row in run(passes, ["smooth_1", "smooth_2"], frame())]
    assert ran == [False, False, True, True]


def test_a_transient_output_is_not_lent_on(world):
    run, executor = world
    run(chain(), ["raw_1", "smooth_2"], frame())
    assert read_texture(executor.texture("raw_1")).max() == 1.0
    assert executor.texture_count == 4


def test_textures_do_not_pile_up_over_frames_and_sizes(world):
    run, executor = world
    for size in ((4, 3), (8, 6), (5, 5), (4, 3)):
        for seed in range(3):
            passes = chain()
            passes[0].depends_on = ("seed",)
            run(passes, ["smooth_1", "smooth_2"], frame(size=size, seed=seed))
            assert executor.texture_count == 3
