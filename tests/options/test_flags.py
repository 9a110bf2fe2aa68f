"""A flag is used or refused: every flag in every mode, and every way to write it wrong."""

from __future__ import annotations

import pytest

from ssdo_gl.effects.registry import image_names
from ssdo_gl.options.flags import UsageError, flag_infos, read_command, wanted_aovs
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import Kind, SettingError, value_text

MODE_FLAGS = {
    modes.WINDOW: [],
    modes.SNAPSHOT: ["--snapshot", "a.png"],
    modes.EXPLAIN: ["--explain"],
    modes.BENCH: ["--bench", "out"],
    modes.BATCH: ["--batch", "a.glb"],
    modes.FILM: ["--film", "out"],
    modes.SERVE: ["--serve"],
}
# A flag's modes, by heart: who changes a declaration has to say so here, too.
EXPECTED = {
    modes.SIZED: "size",
    modes.ALL: "camera projection two_sided exposure combine bounces shadow_rays radius seed "
    "shadows effects overrides backend quiet light no_default_light normals crease_angle up ground",
    modes.ONE: "method estimator samples steps spp filter resolution_scale max_error aov time "
    "preset budget_ms error_reference background",
    modes.FRAMES: "antialias",
    modes.HEADLESS: "snapshot explain",
    modes.STILLS: "frames stats",
    frozenset({modes.BENCH}): "bench estimators quick",
    modes.LIVE: "temporal",
    frozenset({modes.FILM}): "film path turntable frames_range fps",
    frozenset({modes.BATCH}): "batch out",
    frozenset({modes.BATCH, modes.FILM}): "resume",
    frozenset({modes.BATCH, modes.BENCH, modes.FILM, modes.SNAPSHOT}): "scheduler",
    frozenset({modes.SERVE}): "serve host port viewers",
}


def words(info):
    """Return a flag with a valid value."""
    texts = {
        "camera": "0,0,1 0,0,0",
        "overrides": "bounce.strength=2",
        "aov": "depth",
        "light": "studio",
        "background": "#ff8800",
        "ground": "off",
    }
    if info.kind is Kind.BOOLEAN:
        return [info.flag]
    if info.name in texts:
        return [info.flag, texts[info.name]]
    if info.choices:
        return [info.flag, value_text(info.choices[0])]
    if info.kind is Kind.TEXT:
        return [info.flag, "a.json"]
    return [info.flag, "9x9" if info.kind is Kind.SIZE else "1"]


def test_every_flag_has_its_modes():
    expected = {name: where for where, names in EXPECTED.items() for name in names.split()}
    assert {name: info.modes for name, (_, info) in flag_infos().items()} == expected


@pytest.mark.parametrize("name", list(flag_infos()))
@pytest.mark.parametrize("mode", list(MODE_FLAGS))
def test_flag_is_taken_or_refused(mode, name):
    info = flag_infos()[name][1]
    given = [*MODE_FLAGS[mode], *words(info)]
    if name in MODE_FLAGS and name != mode:
        return  # that is another mode
    if mode in info.modes:
        command = read_command(given)
        given = {**command.settings, **command.loading.given()}
        assert name in given or any(
            getattr(options, name, None) not in (None, False)
            for options in (command.run, command.film, command.serving)
        )
        return
    with pytest.raises(UsageError) as caught:
        read_command(given)
    message = str(caught.value)
    assert message.startswith(f"{info.flag} has no effect in {modes.MODES[mode]}: it belongs to")
    for where in info.modes:
        assert modes.MODES[where] in message


@pytest.mark.parametrize("flag", ["--host", "--out", "--path"])
def test_an_empty_text_is_given_too(flag):
    with pytest.raises(UsageError, match=f"{flag} has no effect in --snapshot OUT"):
        read_command(["--snapshot", "a.png", flag, ""])


def test_a_picture_may_be_explained():
    assert read_command(["--snapshot", "a.png", "--explain", "--frames", "3"]).run.frames == 3


@pytest.mark.parametrize("other", [["--explain"], ["--snapshot", "a.png"], ["--serve"]])
def test_a_film_is_on_its_own(other):
    with pytest.raises(UsageError, match=f"--film renders frames alone; leave out {other[0]}"):
        read_command(["--film", "out", *other])


@pytest.mark.parametrize("other", [["--snapshot", "a.png"], ["--explain"], ["--film", "out"]])
def test_a_batch_is_on_its_own(other):
    with pytest.raises(UsageError, match=r"--batch renders pictures|--film renders"):
        read_command(["--batch", "a.glb", "--out", "o", *other])


def test_a_batch_names_its_scenes():
    command = read_command(["a.glb", "--batch", "m/*.glb", "--out", "o", "b.obj"])
    assert command.scenes == ("a.glb", "m/*.glb", "b.obj")
    with pytest.raises(UsageError, match="--batch: name scenes, or a pattern such as"):
        read_command(["--batch", "--out", "o"])


@pytest.mark.parametrize("other", [["--snapshot", "a.png"], ["--explain"], ["--film", "out"]])
def test_a_page_is_on_its_own(other):
    with pytest.raises(UsageError, match=r"--serve shows|--film renders"):
        read_command(["--serve", *other])


def test_a_page_begins_with_one_image():
    assert wanted_aovs(read_command(["--serve", "--aov", "depth"]).run) == ("depth",)
    with pytest.raises(UsageError, match="a page begins with one of beauty"):
        wanted_aovs(read_command(["--serve", "--aov", "all"]).run)


def test_a_turntable_turns_once_round_or_as_far_as_is_said():
    assert read_command(["corner", "--film", "out", "--turntable"]).film.turntable == 360.0
    assert read_command(["--film", "out", "--turntable", "-90"]).film.turntable == -90.0


@pytest.mark.parametrize("other", [["--explain"], ["--snapshot", "a.png"]])
def test_a_bench_is_on_its_own(other):
    with pytest.raises(UsageError, match="--bench renders what it needs"):
        read_command(["--bench", "out", *other])


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--time", "nan"], "--time = nan: expected a number from -1000000000 to"),
        (["--exposure", "-inf"], "--exposure = -inf"),
        (["--radius", "-1e-3"], "--radius = -0.001"),
        (["--samples", "9" * 5000], "--samples = '999"),
        (["--samples", "9" * 4000], "--samples = 999"),
        (["--seed", "0x10"], "--seed = '0x10': expected a whole number"),
        (["--budget-ms", "1e39"], "--budget-ms = 1e+39"),
        (["--frames", "0"], "--frames = 0: expected a whole number from 1"),
        (["--size", "5"], "--size = '5': expected WIDTHxHEIGHT"),
        (["--method", "ssdoo"], "--method = 'ssdoo': expected one of direct"),
        (["--backend", "gles"], "--backend = 'gles': expected one of auto, egl"),
        (["--set", "bounce"], "--set 'bounce': expected PASS.FIELD=VALUE"),
        (["--set", "composite.x=1"], "--set 'composite.x=1': the pass composite has no settings"),
        (["--set", "bounce.samples=" + "9" * 5000], "--set 'bounce.samples=999"),
        (["--set", "x" * 5000], "--set 'xxx"),
        (["--samples"], "--samples: expected one argument"),
        (["--samples=--"], "--samples: expected one argument"),
        (["--set=--"], "--set: expected one argument"),
        (["--quiet=" + "9" * 5000], "--quiet"),
        (["--samples", "8", "--" + "x" * 5000, "y"], "unrecognized arguments"),
        (["--sise", "3x3"], "--sise; did you mean '--size'?"),
        (["--methd=gi", "corner"], "--methd=gi; did you mean '--method'?"),
    ],
)
def test_wrong_values_are_named_in_one_short_line(flags, said):
    with pytest.raises(SettingError) as caught:
        read_command(["--snapshot", "a.png", *flags])
    message = str(caught.value)
    assert said in message
    assert "\n" not in message and len(message) < 300


@pytest.mark.parametrize(
    ("flags", "wanted"),
    [
        ([], ("beauty",)),
        (["--aov", "depth, albedo,depth", "--snapshot", "a.npz"], ("depth", "albedo")),
        (["--aov", "depth"], ("depth",)),
        (["--aov", "all,all,depth", "--snapshot", "a.npz"], image_names()),
    ],
)
def test_images_that_are_wanted(flags, wanted):
    assert wanted_aovs(read_command(flags).run) == wanted


@pytest.mark.parametrize("text", ["all", "depth,albedo", "deep"])
def test_a_window_begins_with_one_image(text):
    with pytest.raises(UsageError, match="a window begins with one of beauty"):
        wanted_aovs(read_command(["--aov", text]).run)


def test_later_flags_win():
    assert read_command(["--samples", "3", "--samples", "5"]).settings["samples"] == 5
    both = read_command(["--set", "bounce.strength=2", "--set", "tone_map.curve=aces"])
    assert both.settings["overrides"] == {"bounce.strength": 2.0, "tone_map.curve": "aces"}


@pytest.mark.parametrize("text", ["-1", "-1.5", "-.5", "-1e-3", "-1e1"])
def test_numbers_may_be_negative_in_any_notation(text):
    for given in (["--exposure", text], [f"--exposure={text}"]):
        assert read_command(given).settings["exposure"] == float(text)
    assert read_command(["--camera", "-1,0,0 0,0,0"]).run.camera == "-1,0,0 0,0,0"


@pytest.mark.parametrize(
    ("text", "name", "frames_all"),
    [
        ("fit", None, True),
        ("Front", "Front", False),
        ("2", "2", False),
        ("Kamera, oben 1", "Kamera, oben 1", False),
        ("3d view", "3d view", False),
        ("1,2,3 0,0,0", None, False),
        ("nan,0,0 1,1,1", None, False),
        ("1 2 3", None, False),
        ("-1", None, False),
        ("", None, False),
    ],
)
def test_a_camera_is_a_place_or_a_name(text, name, frames_all):
    loading = read_command(["a.glb", f"--camera={text}"]).loading
    assert (loading.camera, loading.frames_all) == (name, frames_all)


HOSTILE = [
    *("", "nan", "inf", "-inf", "1e400", "1e39", "-0", "0x10", "1_000", "\u00bd", "\u00b2", "true"),
    *(
        "1" * 5000,
        "a" * 5000,
        "%s",
        "\n",
        "\x1b[31m",
        "1x1",
        "\uff11x\uff11",
        "\u00b2x\u00b2",
        "--",
    ),
    *("a.b=c", "bounce.strength=nan", "bounce.samples=\u00b2", "bounce.=1", ".=", "1,2,3 4,5,6"),
]


@pytest.mark.parametrize("name", list(flag_infos()))
def test_any_text_is_a_value_or_a_short_line(name):
    info = flag_infos()[name][1]
    for text in HOSTILE:
        try:
            command = read_command([f"{info.flag}={text}"])
            settings_for({}, {"method": "ssao", **command.settings})
        except SettingError as error:
            assert len(str(error)) < 400, text[:20]
