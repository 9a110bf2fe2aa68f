"""The scenes of a batch: which they are, and what each is to be written to."""

from __future__ import annotations

import glob
import os.path
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path, PurePath

from ssdo_gl.images.files import SUFFIXES, image_paths
from ssdo_gl.options.flags import STREAM, CommandLine, UsageError, wanted_aovs
from ssdo_gl.scene.formats import model_suffixes, scene_suffixes

# Stands for a scene's name in an output's.
_NAME = "{name}"


def one_by_one(command: CommandLine) -> list[CommandLine]:
    """Return a snapshot of each scene of a batch, with outputs of its own.

    In an output's name ``{name}`` is the scene's, without folder, and without suffix unless
    another scene would then have the same name.

    Raises
    ------
    UsageError
        If two scenes would be written to one file, or no file matches a pattern.
    """
    scenes, run = tuple(_matching(command.scenes)), command.run
    out = _batch_out(run.out)
    if run.stats is not None and _NAME not in run.stats:
        raise UsageError(f"--stats {run.stats}: a batch needs a name with {_NAME}")
    commands = []
    for scene, name in _names(scenes).items():
        stats = None if run.stats is None else run.stats.replace(_NAME, name)
        own = replace(run, snapshot=out.replace(_NAME, name), stats=stats)
        commands.append(replace(command, scenes=(scene,), run=own))
    _check_apart(commands)
    return commands


def files_of(command: CommandLine) -> list[Path]:
    """Return the files that a command with one scene writes."""
    run = command.run
    files = [] if run.snapshot is None else image_paths(Path(run.snapshot), wanted_aovs(run))
    return files if run.stats is None else [*files, Path(run.stats)]


def _matching(words: Iterable[str]) -> Iterator[str]:
    """Yield each scene that is named, or whose file matches a pattern, once."""
    suffixes = (*scene_suffixes(), *model_suffixes())
    seen = set()
    for word in words:
        if word == STREAM:
            raise UsageError("--batch -: standard input belongs to --snapshot OUT or --explain")
        found = [word]
        if glob.has_magic(word) and not os.path.exists(word):
            # A folder of models holds their textures, too.
            found = sorted(
                path
                for path in glob.iglob(word, recursive=True)
                if path.lower().endswith(suffixes) and os.path.isfile(path)
            )
        if not found:
            raise UsageError(f"--batch {word}: no file of that name is a scene or a model")
        for scene in found:
            if (place := os.path.normpath(scene)) not in seen:
                seen.add(place)
                yield scene


def _batch_out(out: str | None) -> str:
    """Return the name, with a place for the scene's, of a batch's pictures."""
    if not out:
        raise UsageError("--batch needs --out DIR")
    if _NAME in out:
        return out
    if out.lower().endswith(SUFFIXES):
        raise UsageError(f"--out {out}: expected a folder, or names as DIR/{_NAME}.png")
    return str(Path(out) / f"{_NAME}.png")


def _names(scenes: Iterable[str]) -> dict[str, str]:
    """Return the name of each scene in those of its outputs."""
    paths = {scene: PurePath(scene.replace("\\", "/")) for scene in scenes}
    counts = Counter(path.stem for path in paths.values())
    return {
        scene: path.stem if counts[path.stem] == 1 else path.name for scene, path in paths.items()
    }


def _check_apart(commands: Iterable[CommandLine]) -> None:
    """Refuse two scenes that would be written to one file."""
    first: dict[Path, str] = {}
    for item in commands:
        for path in files_of(item):
            if path in first:
                raise UsageError(
                    f"--batch: {first[path]} and {item.scene} would both be written to {path};"
                    " render them into two folders"
                )
            first[path] = item.scene
