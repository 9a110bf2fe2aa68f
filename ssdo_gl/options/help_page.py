"""What ``--help``, ``--list-scenes`` and ``--completion`` print beside the flags themselves."""

from __future__ import annotations

import argparse
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from ssdo_gl.effects.registry import image_names
from ssdo_gl.scene.load import builtin_names, builtin_scenes
from ssdo_gl.settings.fields import Kind, SettingError, SettingInfo, value_text
from ssdo_gl.settings.loading import LIGHTS

# As it is printed, behind "usage: ".
USAGE = """ssdo-gl [SCENE ...] [--snapshot OUT] [--explain] [--batch --out DIR]
               [--film OUT] [--serve] [--bench OUTDIR] [flags]"""
EXAMPLES = """
examples:
  ssdo-gl                                       fly through the Cornell room
  ssdo-gl courtyard --snapshot courtyard.png    a picture of a built-in scene
  ssdo-gl model.glb --snapshot a.png --method gi --size 1920x1080
  ssdo-gl stairs --snapshot all.exr --aov all   every image, linear
  ssdo-gl a.glb b.glb --snapshot "{name}.jpg"   several scenes
  ssdo-gl --batch 'models/*.glb' --out pictures   a picture of each
  ssdo-gl model.glb --serve                     fly through it in a browser
  ssdo-gl corner --explain                      which passes run, and why
  ssdo-gl cornell_meso --bench report --quick   error against time
"""
SHELLS = ("bash", "zsh")
_WIDTH = 96
# Flags whose value is the name of a file or a folder.
_FILES = ("snapshot", "stats", "film", "path")
_FOLDERS = ("bench", "out")
PRESETS = ("fast", "balanced", "fine", "reference")


def argument_of(info: SettingInfo) -> dict[str, Any]:
    """Return what argparse is told of a flag."""
    described = help_text(info).replace("%", "%%")
    if info.kind is Kind.BOOLEAN:
        return {"action": "store_true", "default": None, "help": described}
    if info.kind is Kind.MAPPING:
        return {"action": "append", "metavar": info.metavar, "help": described}
    metavar = info.metavar or "|".join(map(value_text, info.choices))
    if info.bare:
        return {"nargs": "?", "const": info.bare, "metavar": metavar, "help": described}
    return {"metavar": metavar, "help": described}


def help_text(info: SettingInfo) -> str:
    """Return a flag's line of ``--help``: effect, range and default."""
    notes = [] if info.choices else [info.range_text]
    if info.default is not None and info.kind not in (Kind.BOOLEAN, Kind.MAPPING):
        notes.append(f"default {value_text(info.default)}")
    noted = "; ".join(note for note in notes if note)
    return f"{info.doc} ({noted})" if noted else info.doc


def scene_epilog() -> str:
    """Return the end of the help page: built-in scenes and examples."""
    names = textwrap.fill(
        ", ".join(builtin_names()), 78, initial_indent="  ", subsequent_indent="  "
    )
    return f"built-in scenes (--list-scenes says what each is for):\n{names}\n{EXAMPLES}"


def scene_list() -> str:
    """Return every built-in scene with its title, and its purpose indented below."""
    return "\n".join(
        f"{name}: {title}\n{textwrap.indent(textwrap.fill(purpose, _WIDTH - 4), '    ')}\n"
        for name, (title, purpose) in builtin_scenes().items()
    )


class ListScenes(argparse.Action):
    """Prints the built-in scenes and ends the command."""

    def __init__(self, option_strings: Sequence[str], dest: str, **words: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **words)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Print, and leave with code 0."""
        print(scene_list(), end="")
        parser.exit()


def completion(
    parser: argparse.ArgumentParser, infos: Mapping[str, SettingInfo], shell: str
) -> str:
    """Return a script that completes the command's flags, their choices, scenes and files.

    Parameters
    ----------
    parser : ArgumentParser
        Its actions get what `shtab` asks of them; it is then of no other use.
    infos : mapping
        The declarations of the flags, by name.

    Raises
    ------
    SettingError
        If the shell is none of `SHELLS`, or shtab is not installed.
    """
    if shell not in SHELLS:
        raise SettingError(f"--completion = {shell!r}: expected one of {', '.join(SHELLS)}")
    try:
        import shtab
    except ImportError:
        raise SettingError("--completion needs shtab: pip install 'ssdo_gl[completion]'") from None
    # What has a name, or is a file that nobody has named.
    named = {"scene": builtin_names(), "preset": PRESETS, "light": LIGHTS}
    named["aov"] = ("all", *image_names())
    for action in parser._actions:
        info = infos.get(action.dest)
        if isinstance(action.metavar, str):
            # shtab writes it as it is between quotes and colons, which have a meaning to zsh.
            action.metavar = re.sub(r'[":`$\\]', " ", action.metavar)
        if action.dest in named:
            has_files = action.dest != "aov"
            action.complete = _named(action.dest, named[action.dest], has_files)  # type: ignore[attr-defined]
        elif action.dest in _FILES:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
        elif action.dest in _FOLDERS:
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
        elif action.dest == "completion":
            action.choices = SHELLS
        elif info is not None and info.choices:
            action.choices = tuple(map(value_text, info.choices))
    script = str(shtab.complete(parser, shell))
    # All that is left over is a scene; what shtab writes for zsh completes the first alone.
    return script.replace('"(*)::', '"*:').replace("_defaults_added=0", "_defaults_added=1")


def _named(flag: str, names: Sequence[str], has_files: bool) -> dict[str, Any]:
    """Return what shtab takes for a value that is one of `names`, or a file."""
    function, words = f"_ssdo_gl_{flag}", " ".join(names)
    files = {"bash": ' compgen -f -- "$1";', "zsh": " _files;"} if has_files else {}
    return {
        **dict.fromkeys(SHELLS, function),
        "preamble": {
            "bash": f'{function}() {{ compgen -W "{words}" -- "$1";{files.get("bash", "")} }}',
            "zsh": f"{function}() {{ compadd -- {words};{files.get('zsh', '')} }}",
        },
    }
