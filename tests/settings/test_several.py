"""What each of several scenes is written to."""

from __future__ import annotations

import pytest

from ssdo_gl.settings.flags import UsageError, read_command
from ssdo_gl.settings.several import one_by_one


def outputs(*arguments):
    commands = one_by_one(read_command(arguments))
    return [(item.scene, item.run.snapshot, item.run.stats) for item in commands]


def test_a_name_with_a_place_for_the_scene():
    assert outputs("m/a.glb", "--snapshot", "out_{name}.exr", "--stats", "{name}.json", "b") == [
        ("m/a.glb", "out_a.exr", "a.json"),
        ("b", "out_b.exr", "b.json"),
    ]


def test_a_folder(tmp_path):
    expected = [("a.glb", str(tmp_path / "a.png"), None), ("b", str(tmp_path / "b.png"), None)]
    assert outputs("a.glb", "b", "--snapshot", str(tmp_path)) == expected
    assert outputs("a.glb", "--snapshot", f"{tmp_path}/") == expected[:1]


def test_one_scene_keeps_the_name_that_was_given():
    assert outputs("a.glb", "--snapshot", "x.png") == [("a.glb", "x.png", None)]
    assert outputs("--snapshot", "x.png") == [("cornell_meso", "x.png", None)]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a", "b", "--snapshot", "x.png"], "--snapshot x.png: several scenes need a folder"),
        (["a", "b", "--snapshot", "-"], "several scenes need a folder"),
        (["a", "b", "--explain", "--stats", "x.json"], "as out_{name}.json"),
        (["m/a.glb", "n/a.obj", "--snapshot", "{name}.png"], "would both be written to a.png"),
        (["a", "b"], "2 scenes: belongs to --snapshot OUT or --explain"),
        (["a", "b", "--bench", "out"], "2 scenes: belongs to"),
        (["-"], "- (standard input): belongs to"),
    ],
)
def test_what_cannot_be_told_apart_is_refused(arguments, said):
    with pytest.raises(UsageError) as caught:
        outputs(*arguments)
    assert said in str(caught.value)
