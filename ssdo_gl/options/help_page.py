"""What ``--help`` and ``--list-scenes`` print beside the flags themselves."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Sequence
from typing import Any

from ssdo_gl.scene.load import builtin_names, builtin_scenes
from ssdo_gl.settings.fields import Kind, SettingInfo, value_text

# As it is printed, behind "usage: ".
USAGE = """ssdo-gl [SCENE ...] [--snapshot OUT] [--explain] [--batch --out DIR]
               [--film OUT] [--serve] [--bench OUTDIR] [flags]"""
EXAMPLES = """
examples:
  ssdo-gl                                       fly through the Cornell room
  ssdo-gl courtyard --snapshot courtyard.png    a picture of a built-in scene
  ssdo-gl model.glb --snapshot a.png --method gi --size 1920x1080
  ssdo-gl stairs --snapshot all.exr --aov all   every image, linear
  ssdo-gl --batch 'models/*.glb' --out pictures   a picture of each
  ssdo-gl model.glb --serve                     fly through it in a browser
  ssdo-gl corner --explain                      which passes run, and why
  ssdo-gl cornell_meso --bench report --quick   error against time
"""
_WIDTH = 96


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
