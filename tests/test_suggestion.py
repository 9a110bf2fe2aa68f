"""The end of a message about a name that is not known."""

from __future__ import annotations

import pytest

from ssdo_gl.wording import suggestion


@pytest.mark.parametrize(
    ("name", "known", "lists", "end"),
    [
        ("radus", ["range", "radius"], True, "; did you mean 'radius'?"),
        ("radus", ["range", "radius"], False, "; did you mean 'radius'?"),
        ("--list", ["--light", "--list-scenes"], True, "; did you mean '--list-scenes'?"),
        ("ra", ["radius", "range"], False, ""),
        ("xyzzy", ["range", "radius"], True, "; choose one of range, radius"),
        ("xyzzy", ["range", "radius"], False, ""),
        ("xyzzy", [], True, "; none is known here"),
        ("xyzzy", [], False, ""),
    ],
)
def test_the_nearest_name_or_all_of_them(name, known, lists, end):
    assert suggestion(name, iter(known), lists=lists) == end
