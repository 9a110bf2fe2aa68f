"""The command line: every flag made from its declaration, read, and refused where idle."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn

from ssdo_gl.effects.registry import image_names
from ssdo_gl.options.help_page import (
    SHELLS,
    USAGE,
    ListScenes,
    argument_of,
    completion,
    scene_epilog,
)
from ssdo_gl.options.pass_settings import overrides_from_text
from ssdo_gl.options.run_options import (
    BROWSER,
    FILM,
    MODE,
    RUNNING,
    FilmOptions,
    RunOptions,
    ServeOptions,
)
from ssdo_gl.scene.formats import model_suffixes, scene_suffixes
from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import (
    Kind,
    SettingError,
    SettingInfo,
    describe,
    parse,
    shown,
)
from ssdo_gl.settings.loading import FIT, LoadOptions, named_camera
from ssdo_gl.settings.settings import LOOK, QUALITY, Settings
from ssdo_gl.version import __version__
from ssdo_gl.wording import suggestion

DEFAULT_SCENE = "cornell_meso"
# As a scene: standard input; as an output: standard output.
STREAM = "-"

# Modes that go with no other one.
_ALONE = {
    modes.BENCH: "--bench renders what it needs itself",
    modes.BATCH: "--batch renders pictures into --out",
    modes.FILM: "--film renders frames alone",
    modes.SERVE: "--serve shows a scene to browsers",
}


class UsageError(SettingError):
    """Arguments that contradict each other or cannot be read."""


@dataclass(frozen=True)
class CommandLine:
    """One command line, read and checked.

    Attributes
    ----------
    scenes : tuple of str
        At least one.
    settings : mapping
        Fields of Settings that were given, by name; ``overrides`` among them.
    """

    scenes: tuple[str, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)
    loading: LoadOptions = field(default_factory=LoadOptions)
    run: RunOptions = field(default_factory=RunOptions)
    film: FilmOptions = field(default_factory=FilmOptions)
    serving: ServeOptions = field(default_factory=ServeOptions)

    @property
    def scene(self) -> str:
        """The first scene, of most commands the only one."""
        return self.scenes[0]


class _Parser(argparse.ArgumentParser):
    """argparse that reports one line instead of a usage block."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{textwrap.shorten(message, 200)} (see ssdo-gl --help)")


def flag_infos() -> dict[str, tuple[type[Any], SettingInfo]]:
    """Return every flag's dataclass and declaration, by the field's name."""
    return {
        name: (owner, info)
        for owner in (RunOptions, FilmOptions, ServeOptions, LoadOptions, Settings)
        for name, info in describe(owner).items()
    }


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line. It reads texts; `read_command` their values."""
    parser = _Parser(
        prog="ssdo-gl",
        usage=USAGE,
        description="Render a scene with near-field global illumination (SSDO). A flag that"
        "\nwould have no effect, in a mode or with a method, is refused.",
        epilog=scene_epilog(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "scene",
        nargs="*",
        metavar="SCENE",
        help=f"a scene ({' '.join(scene_suffixes())}), a model ({' '.join(model_suffixes())}), "
        f"a built-in name (default: {DEFAULT_SCENE}), or - for a scene on standard input; with "
        "--snapshot, --explain or --batch, several",
    )
    infos = [info for _, info in flag_infos().values()]
    for title in dict.fromkeys((MODE, FILM, BROWSER, LOOK, QUALITY, RUNNING)):
        group = parser.add_argument_group(title)
        for info in infos:
            if info.group == title:
                group.add_argument(info.flag, dest=info.name, **argument_of(info))
        if title == MODE:
            version = f"ssdo-gl {__version__}"
            group.add_argument("--version", action="version", version=version)
            group.add_argument(
                "--list-scenes", action=ListScenes, help="say what each built-in scene is for"
            )
            group.add_argument(
                "--completion",
                metavar="|".join(SHELLS),
                action=_PrintCompletion,
                help="print a script that completes this command in a shell",
            )
    return parser


class _PrintCompletion(argparse.Action):
    def __call__(
        self, parser: argparse.ArgumentParser, _space: Any, shell: Any, _option: Any = None
    ) -> NoReturn:
        infos = {name: info for name, (_, info) in flag_infos().items()}
        print(completion(build_parser(), infos, shell))
        parser.exit()


def read_command(arguments: Sequence[str] | None = None) -> CommandLine:
    """Return what a command line says.

    Raises
    ------
    UsageError, SettingError
        One line naming the flag, the value and what would be valid.
    """
    parsed = _parsed(_joined(arguments))
    scenes = tuple(parsed["scene"] or [DEFAULT_SCENE])
    texts = {name: parsed[name] for name in flag_infos()}
    infos = flag_infos()
    given: dict[type[Any], dict[str, Any]] = {owner: {} for owner, _ in infos.values()}
    for name, text in texts.items():
        if text is not None:
            owner, info = infos[name]
            given[owner][name] = _value(owner, info, text)
    run = RunOptions(**given[RunOptions])
    if run.batch and not parsed["scene"]:
        raise UsageError("--batch: name scenes, or a pattern such as 'models/*.glb'")
    loading = LoadOptions(
        **given[LoadOptions], camera=named_camera(run.camera), frames_all=run.camera == FIT
    ).checked()
    film = FilmOptions(**given[FilmOptions])
    serving = ServeOptions(**given[ServeOptions])
    command = CommandLine(scenes, given[Settings], loading, run, film, serving)
    # An empty text is given, too.
    named = (info for _, info in infos.values() if texts[info.name] not in (None, False))
    _check_modes(command.run.active, named)
    return command


def _parsed(words: Sequence[str]) -> dict[str, Any]:
    """Return the text of every flag and the scenes, or refuse what is no flag."""
    parser = build_parser()
    # Intermixed: scenes may stand on both sides of a flag.
    parsed, unknown = parser.parse_known_intermixed_args(words)
    if unknown:
        flag = unknown[0].partition("=")[0]
        hint = suggestion(flag, parser._option_string_actions, lists=False)
        listed = textwrap.shorten(" ".join(unknown), 150)
        parser.error(f"unrecognized arguments: {listed}{hint}")
    return vars(parsed)


def _joined(arguments: Sequence[str] | None) -> list[str]:
    """Return the arguments with negative numbers joined to their flags.

    argparse takes -1e-3 and -inf for flags.
    """
    words: list[str] = []
    for word in sys.argv[1:] if arguments is None else arguments:
        follows_flag = bool(words) and words[-1].startswith("--") and "=" not in words[-1]
        if follows_flag and re.fullmatch(r"-(\.?\d.*|inf|nan)", word):
            words[-1] += f"={word}"
        else:
            words.append(word)
    return words


def _value(owner: type[Any], info: SettingInfo, text: Any) -> Any:
    if info.kind is Kind.BOOLEAN:
        return text
    # argparse makes an empty list of the text "--".
    if [] in (text, *(text if isinstance(text, list) else [])):
        raise UsageError(f"{info.flag}: expected one argument")
    if info.kind is Kind.MAPPING:
        return overrides_from_text(text)
    try:
        return parse(owner, info.name, text)
    except SettingError as error:
        raise SettingError(f"{info.flag}{str(error).removeprefix(info.name)}") from None


def _check_modes(active: frozenset[str], given: Iterable[SettingInfo]) -> None:
    """Refuse a flag that has no effect in what was asked for."""
    for mode, why in _ALONE.items():
        if mode in active and len(active) > 1:
            others = " and ".join(
                text for name, text in modes.MODES.items() if name in active - {mode}
            )
            raise UsageError(f"{why}; leave out {others}")
    for info in given:
        if not info.modes & active:
            where = " with ".join(modes.MODES[name] for name in modes.MODES if name in active)
            valid = " or ".join(modes.MODES[name] for name in modes.MODES if name in info.modes)
            raise UsageError(f"{info.flag} has no effect in {where}: it belongs to {valid}")


def wanted_aovs(run: RunOptions) -> tuple[str, ...]:
    """Return the images that ``--aov`` asks for.

    Raises
    ------
    UsageError
    """
    known = image_names()
    if run.aov is None:
        return ("beauty",)
    named = dict.fromkeys(part.strip() for part in run.aov.split(","))
    wanted = tuple(dict.fromkeys(n for name in named for n in (known if name == "all" else [name])))
    unknown = [name for name in wanted if name not in known]
    if run.active & modes.LIVE and (unknown or len(wanted) > 1):
        where = "window" if modes.WINDOW in run.active else "page"
        raise UsageError(f"--aov {shown(run.aov)}: a {where} begins with one of {', '.join(known)}")
    if unknown:
        hint = suggestion(unknown[0], known, lists=False)
        raise UsageError(f"--aov {shown(unknown[0])}: choose all or of {', '.join(known)}{hint}")
    return wanted
