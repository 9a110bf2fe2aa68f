"""What was made last holds for the very objects that it was made from, and no longer."""

from __future__ import annotations

from ssdo_gl.last_made import LastMade, MadeOfEach, are_same


def test_it_is_made_again_for_equal_objects_that_are_others():
    kept, made = LastMade(), []
    first, second = [1.0], [1.0]
    for made_from in ((first, first), (first, first), (first, second), (first, first)):
        kept.get(made_from, lambda: made.append(len(made)) or len(made))
    assert made == [0, 1, 2]
    assert kept.get((first, first), lambda: -1) == 3


def test_sequences_are_the_same_if_their_objects_are():
    one, other = [1.0], [1.0]
    assert are_same((one, other), [one, other])
    assert not are_same((one,), (other,))
    assert not are_same((one,), (one, one))


def test_each_object_has_one_of_its_own_and_few_are_kept():
    made = MadeOfEach(lambda given: [*given], 2)
    first, second, third = [1.0], [1.0], [1.0]
    of_first = made.of(first)
    assert made.of(second) is not of_first and made.of(first) is of_first
    made.of(third)
    assert made.of(first) is not of_first and made.of(first) == first
