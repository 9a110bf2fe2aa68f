"""Several scenes in one command: what each of them is to be written to. Pure."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path, PurePath

from ssdo_gl.settings import modes
from ssdo_gl.settings.flags import STREAM, CommandLine, UsageError

# Stands for a scene's name in an output's.
NAME = "{name}"


def one_by_one(command: CommandLine) -> list[CommandLine]:
    """Return a command for each scene, with outputs of its own.

    In an output's name ``{name}`` is the scene's, without folder and suffix; an output that
    is a folder gets a file of that name.

    Raises
    ------
    UsageError
        If two scenes would be written to one file, or are not rendered but shown.
    """
    scenes, run = command.scenes, command.run
    if (len(scenes) > 1 or STREAM in scenes) and not run.active <= modes.HEADLESS:
        shown = "- (standard input)" if len(scenes) == 1 else f"{len(scenes)} scenes"
        raise UsageError(f"{shown}: belongs to --snapshot OUT or --explain")
    are_several = len(scenes) > 1
    commands = []
    for scene in scenes:
        own = replace(
            run,
            snapshot=_own(run.snapshot, scene, "--snapshot", ".png", are_several),
            stats=_own(run.stats, scene, "--stats", ".json", are_several),
        )
        commands.append(replace(command, scenes=(scene,), run=own))
    for field in ("snapshot", "stats"):
        first: dict[str | None, str] = {}
        for item in commands:
            out = getattr(item.run, field)
            if out is not None and out in first:
                raise UsageError(
                    f"--{field}: {first[out]} and {item.scene} would both be written to {out}"
                )
            first[out] = item.scene
    return commands


def _own(out: str | None, scene: str, flag: str, suffix: str, are_several: bool) -> str | None:
    """Return the output of one scene."""
    if out is None:
        return None
    name = "stdin" if scene == STREAM else PurePath(scene.replace("\\", "/")).stem
    if NAME in out:
        return out.replace(NAME, name)
    if out.endswith(("/", os.sep)) or (are_several and os.path.isdir(out)):
        return str(Path(out) / f"{name}{suffix}")
    if are_several:
        raise UsageError(
            f"{flag} {out}: several scenes need a folder that exists, or a name with {NAME}, as "
            f"out_{NAME}{suffix}"
        )
    return out
