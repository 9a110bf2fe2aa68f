"""Settings without effect are refused on the command line, and truly have none."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

from ssdo_gl.cli import main
from ssdo_gl.effects.registry import pass_settings
from ssdo_gl.options.command_line import command_line
from ssdo_gl.options.flags import read_command
from ssdo_gl.options.idle import check_used, idle_because
from ssdo_gl.options.preset_files import write_preset
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import Kind, SettingInfo, describe
from ssdo_gl.settings.methods import METHODS

SIZE = (24, 14)
BOX = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'


def other_value(info: SettingInfo) -> object:
    """Return a value that is not the default."""
    if info.choices:
        return next(choice for choice in info.choices if choice != info.default)
    if info.kind is Kind.BOOLEAN:
        return not info.default
    low = 0.0 if info.low is None else info.low
    value = low + 1 if info.default is None else 0.5 * (low + info.default) + 1e-3
    return int(value) + 1 if info.kind is Kind.INTEGER else value


def idle_values(settings: Settings, image: str) -> dict[str, object]:
    """Return other values of all settings that are said to have no effect, by name."""
    infos = {name: info for name, info in describe(Settings).items() if name != "overrides"}
    for name, cls in pass_settings().items():
        infos |= {f"{name}.{field}": info for field, info in describe(cls).items()}
    idle = {name: info for name, info in infos.items() if idle_because(settings, name, (image,))}
    return {name: other_value(info) for name, info in idle.items() if name != "estimator"}


@pytest.mark.parametrize(
    ("method", "image"),
    [*((method, "beauty") for method in METHODS), ("gi", "visibility"), ("direct", "visibility")],
)
def test_what_is_said_to_have_no_effect_has_none(device, method, image):
    scene = load_scene("courtyard")
    settings = Settings(size=SIZE, method=method, **few_rays(method)).checked()
    changed = idle_values(settings, image)
    assert len(changed) > 5
    overrides = {name: value for name, value in changed.items() if "." in name}
    whole = {name: value for name, value in changed.items() if "." not in name}
    images = []
    for other in ({}, {**whole, "overrides": overrides}):
        fields = {**few_rays(method), **other}
        with Renderer(scene, Settings(size=SIZE, method=method, **fields)) as renderer:
            images.append(renderer.render((image,)).images[image])
    assert np.array_equal(*images), changed


def few_rays(method: str) -> dict[str, int]:
    """Return settings of references that are soon there."""
    return {"spp": 2, "shadow_rays": 1} if METHODS[method].is_reference else {}


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ("--method direct --samples 4", "method direct: it belongs to ssao, ssdo, bounce or gi"),
        ("--spp 4", "--spp has no effect with method gi: it belongs to reference-ao,"),
        ("--method reference-ao --bounces 3", "--bounces has no effect with method reference-ao"),
        ("--method reference-gi --shadows none", "--shadows has no effect with method"),
        ("--method ssdo --set bounce.strength=2", "method ssdo: it belongs to bounce or gi"),
        ("--combine report", "--combine has no effect with method gi: it belongs to ssao or"),
        ("--shadow-rays 2", "--shadow-rays has no effect without traced shadows"),
        ("--shadows traced --set shadow_map.resolution=512", "has no effect without shadow maps"),
        ("--method ssdo --estimator rgs09 --steps 2", "rgs09: it belongs to march or bitmask"),
        ("--set temporal.frames=2", "has no effect on pictures: it belongs to the window"),
        ("--budget-ms 9 --samples 4", "--samples has no effect with --budget-ms or --max-error"),
        ("--max-error 1 --filter none", "--filter has no effect with --budget-ms or --max-error"),
    ],
)  # fmt: skip
def test_a_flag_that_the_method_cannot_use_is_refused(tmp_path, capsys, flags, said):
    out = tmp_path / "a.png"
    assert main(["corner", "--snapshot", str(out), *shlex.split(flags)]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    "flags",
    [
        "--method direct --aov visibility --samples 4",
        "--method direct --shadows traced --shadow-rays 2",
        "--method ssao --combine report",
        "--method ssao --estimator rgs09 --set ssao.estimator=march --steps 2",
        "--set surface_cache.surfels=4096",
    ],
)
def test_a_flag_with_an_effect_is_taken(tmp_path, flags):
    out = str(tmp_path / "a.npz")
    assert main(["corner", "--snapshot", out, "--size", "16x9", *shlex.split(flags)]) == 0


def test_what_scenes_and_presets_ask_for_are_no_flags(tmp_path):
    scene, preset = tmp_path / "a.toml", tmp_path / "p.toml"
    scene.write_text(f'[render]\nspp = 2\nmethod = "direct"\n{BOX}')
    write_preset(preset, Settings(samples=4, shadow_rays=2), {})
    out = ["--snapshot", str(tmp_path / "a.png"), "--size", "16x9"]
    assert main([str(scene), *out, "--preset", str(preset), "--method", "direct"]) == 0
    # Of one scene, its own method counts; of several, another may use the flag.
    assert main([str(scene), *out, "--samples", "4"]) == 2
    several = ["--snapshot", str(tmp_path / "{name}.png"), "--size", "16x9", "--samples", "4"]
    assert main([str(scene), "corner", *several]) == 0
    assert main([str(scene), "corner", *several, "--method", "direct"]) == 2


def test_what_a_scene_says_of_shadows_counts():
    given = {"shadow_rays": 2}
    settings = settings_for({"shadows": "traced"}, {"method": "bounce", **given})
    check_used(settings, given, ("beauty",), is_scene_read=True)


@pytest.mark.parametrize("method", METHODS)
def test_commands_that_a_window_copies_are_taken(method):
    """Whatever was set in the panel before the method was."""
    settings = Settings(
        method=method, samples=4, spp=4, bounces=2, combine="report", temporal="off",
        shadow_rays=2, overrides={"bounce.strength": 2.0, "temporal.frames": 2},
    )  # fmt: skip
    line = command_line("corner", settings, scene_settings={}, camera=None)
    command = read_command(shlex.split(line)[1:])
    read = settings_for({}, command.settings)
    check_used(read, command.settings, ("beauty",), is_scene_read=True)
    assert read.method == method
