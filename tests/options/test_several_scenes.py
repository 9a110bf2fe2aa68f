"""What each of several scenes is written to."""

from __future__ import annotations

import pytest

from ssdo_gl.options.flags import UsageError, read_command
from ssdo_gl.options.several_scenes import one_by_one


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


def test_models_of_one_name_keep_their_suffixes():
    assert outputs(
        "m/a.glb", "a.ply", "b.obj", "--batch", "--out", "o", "--stats", "{name}.json"
    ) == [
        ("m/a.glb", "o/a.glb.png", "a.glb.json"),
        ("a.ply", "o/a.ply.png", "a.ply.json"),
        ("b.obj", "o/b.png", "b.json"),
    ]
    # A built-in scene has no suffix.
    named = outputs("corner", "corner.toml", "--snapshot", "{name}.exr")
    assert [out for _, out, _ in named] == ["corner.exr", "corner.toml.exr"]


def test_one_scene_keeps_the_name_that_was_given():
    assert outputs("a.glb", "--snapshot", "x.png") == [("a.glb", "x.png", None)]
    assert outputs("--snapshot", "x.png") == [("cornell_meso", "x.png", None)]


def test_a_batch_goes_into_its_folder():
    expected = [("m/a.glb", "o/a.png", None), ("stairs", "o/stairs.png", None)]
    assert outputs("--batch", "m/a.glb", "stairs", "--out", "o") == expected
    assert outputs("m/a.glb", "--batch", "--out", "o/", "--stats", "s_{name}.json") == [
        ("m/a.glb", "o/a.png", "s_a.json")
    ]
    assert outputs("m/a.glb", "--batch", "--out", "o/x_{name}.exr")[0][1] == "o/x_a.exr"


def test_models_of_one_name_in_several_folders_have_these_in_front():
    """As downloads are, each a scene.gltf in a folder of its own."""
    scenes = ("m/car/a.glb", "m/boat/a.glb", "/n/car/a.glb", "a.glb", "b/c.obj")
    found = outputs(*scenes, "--batch", "--out", "o")
    names = ("m_car_a", "boat_a", "n_car_a", "a", "c")
    assert [picture for _, picture, _ in found] == [f"o/{name}.png" for name in names]


def test_patterns_name_scenes_and_models_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m" / "deep.glb").mkdir(parents=True)
    for name in ("b.glb", "a.OBJ", "wood.png", "a.bin", "deep.glb/c.ply", "[x].glb"):
        (tmp_path / "m" / name).touch()

    def scenes(*words):
        return [name for name, _, _ in outputs("--batch", *words, "--out", "o")]

    assert scenes("m/*") == ["m/[x].glb", "m/a.OBJ", "m/b.glb"]
    assert scenes("m/b.glb", "stairs", "m/*.glb") == ["m/b.glb", "stairs", "m/[x].glb"]
    assert scenes("m/**/c.*") == ["m/deep.glb/c.ply"]
    assert scenes("m/[x].glb") == ["m/[x].glb"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a", "b", "--snapshot", "x.png"], "--snapshot x.png: several scenes need a folder"),
        (["a", "b", "--snapshot", "-"], "several scenes need a folder"),
        (["a", "b", "--explain", "--stats", "x.json"], "as out_{name}.json"),
        (["a", "a", "--snapshot", "{name}.png"], "--snapshot: a and a would both be written to a"),
        (["-", "-", "--explain", "--stats", "{name}.json"], "--stats: - and - would both be writt"),
        (["m/a.glb", "m//a.glb", "--snapshot", "{name}.png"], "would both be written to a.png"),
        (
            ["m/a.glb", "n/a.glb", "m_a.glb", "--batch", "--out", "o"],
            "--out: m/a.glb and m_a.glb would both be written to o/m_a.png; render them into two",
        ),
        (
            ["a.glb", "a-depth.glb", "--batch", "--out", "o", "--aov", "beauty,depth"],
            "--out: a.glb and a-depth.glb would both be written to o/a-depth.png",
        ),
        (["m/a", "n/a", "m_a", "--batch", "--out", "{name}-x.png"], "written to m_a-x.png"),
        (["a", "b", "--batch", "--out", "o", "--stats", "x.json"], "as out_{name}.json"),
        (["a", "--snapshot", "x.png", "--stats", "x.png"], "--stats x.png: the picture is writt"),
        (["a", "--batch"], "--batch needs --out DIR"),
        (["a", "--batch", "--out", ""], "--batch needs --out DIR"),
        (["a", "--batch", "--out", "x.exr"], "--out x.exr: expected a folder, or names as DIR/"),
        (["no/*.glb", "--batch", "--out", "o"], "--batch no/*.glb: no file of that name is a sc"),
        (["a", "b"], "2 scenes: belongs to --snapshot OUT, --explain or --batch"),
        (["a", "b", "--bench", "out"], "2 scenes: belongs to"),
        (["-"], "- (standard input): belongs to"),
    ],
)
def test_what_cannot_be_told_apart_is_refused(arguments, said):
    with pytest.raises(UsageError) as caught:
        outputs(*arguments)
    assert said in str(caught.value)
