"""What each scene of a batch is written to."""

from __future__ import annotations

import pytest

from ssdo_gl.options.batches import one_by_one
from ssdo_gl.options.flags import UsageError, read_command


def outputs(*arguments):
    commands = one_by_one(read_command(["--batch", *arguments]))
    return [(item.scene, item.run.snapshot, item.run.stats) for item in commands]


def test_models_of_one_name_keep_their_suffixes():
    assert outputs("m/a.glb", "a.ply", "b.obj", "--out", "o", "--stats", "{name}.json") == [
        ("m/a.glb", "o/a.glb.png", "a.glb.json"),
        ("a.ply", "o/a.ply.png", "a.ply.json"),
        ("b.obj", "o/b.png", "b.json"),
    ]
    # A built-in scene has no suffix.
    named = outputs("corner", "corner.toml", "--out", "{name}.exr")
    assert [out for _, out, _ in named] == ["corner.exr", "corner.toml.exr"]


def test_a_batch_goes_into_its_folder():
    expected = [("m/a.glb", "o/a.png", None), ("stairs", "o/stairs.png", None)]
    assert outputs("m/a.glb", "stairs", "--out", "o") == expected
    assert outputs("m/a.glb", "--out", "o/", "--stats", "s_{name}.json") == [
        ("m/a.glb", "o/a.png", "s_a.json")
    ]
    assert outputs("m/a.glb", "--out", "o/x_{name}.exr")[0][1] == "o/x_a.exr"


def test_patterns_name_scenes_and_models_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m" / "deep.glb").mkdir(parents=True)
    for name in ("b.glb", "a.OBJ", "wood.png", "a.bin", "deep.glb/c.ply", "[x].glb"):
        (tmp_path / "m" / name).touch()

    def scenes(*words):
        return [name for name, _, _ in outputs(*words, "--out", "o")]

    assert scenes("m/*") == ["m/[x].glb", "m/a.OBJ", "m/b.glb"]
    assert scenes("m/b.glb", "stairs", "m/*.glb") == ["m/b.glb", "stairs", "m/[x].glb"]
    assert scenes("m/**/c.*") == ["m/deep.glb/c.ply"]
    assert scenes("m/[x].glb") == ["m/[x].glb"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["m/a.glb", "n/a.glb", "--out", "o"], "m/a.glb and n/a.glb would both be written to o/a."),
        (
            ["a.glb", "a-depth.glb", "--out", "o", "--aov", "beauty,depth"],
            "a.glb and a-depth.glb would both be written to o/a-depth.png; render them into two",
        ),
        (["m/a", "n/a", "--out", "{name}-x.png"], "written to a-x.png"),
        (["a", "b", "--out", "o", "--stats", "x.json"], "--stats x.json: a batch needs a name"),
        (["a"], "--batch needs --out DIR"),
        (["a", "--out", ""], "--batch needs --out DIR"),
        (["a", "--out", "x.exr"], "--out x.exr: expected a folder, or names as DIR/"),
        (["no/*.glb", "--out", "o"], "--batch no/*.glb: no file of that name is a sc"),
        (["a", "-", "--out", "o"], "--batch -: standard input belongs to --snapshot OUT"),
    ],
)
def test_what_cannot_be_told_apart_is_refused(arguments, said):
    with pytest.raises(UsageError) as caught:
        outputs(*arguments)
    assert said in str(caught.value)
