"""Several scenes in one command: which they are, and what each is to be written to."""

from __future__ import annotations

import glob
import os
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path, PurePath

from ssdo_gl.images.files import SUFFIXES, image_paths
from ssdo_gl.options.flags import STREAM, CommandLine, UsageError, wanted_aovs
from ssdo_gl.scene.formats import model_suffixes, scene_suffixes
from ssdo_gl.settings import modes

# Stands for a scene's name in an output's.
NAME = "{name}"


def one_by_one(command: CommandLine) -> list[CommandLine]:
    """Return a command for each scene, with outputs of its own.

    In an output's name ``{name}`` is the scene's, without folder and suffix unless
    another scene would then have the same name; an output that is a folder gets a file of
    that name. Pictures of a batch are snapshots.

    Raises
    ------
    UsageError
        If two scenes would be written to one file, or are not rendered but shown; or if no
        file matches a pattern of a batch.
    """
    scenes, run = command.scenes, command.run
    if run.batch:
        scenes = tuple(_matching(scenes))
    elif (len(scenes) > 1 or STREAM in scenes) and not run.active <= modes.HEADLESS:
        shown = "- (standard input)" if len(scenes) == 1 else f"{len(scenes)} scenes"
        raise UsageError(f"{shown}: belongs to --snapshot OUT, --explain or --batch")
    out, flag = (_batch_out(run.out), "--out") if run.batch else (run.snapshot, "--snapshot")
    are_several = len(scenes) > 1
    names = _names(scenes)
    commands = []
    for scene in scenes:
        own = replace(
            run,
            snapshot=_own(out, names[scene], flag, ".png", are_several),
            stats=_own(run.stats, names[scene], "--stats", ".json", are_several),
        )
        commands.append(replace(command, scenes=(scene,), run=own))
    _check_apart(commands, flag)
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
    if NAME in out:
        return out
    if out.lower().endswith(SUFFIXES):
        raise UsageError(f"--out {out}: expected a folder, or names as DIR/{NAME}.png")
    return str(Path(out) / f"{NAME}.png")


def _names(scenes: Iterable[str]) -> dict[str, str]:
    """Return the name of each scene in those of its outputs: the first that is its alone.

    Without suffix and folders; with the suffix; then with ever more of its folders.
    """
    left = {scene: PurePath(scene.replace("\\", "/")) for scene in scenes}
    deepest = max((len(path.parts) for path in left.values()), default=0)
    names: dict[str, str] = {}
    for depth, with_suffix in product(range(deepest), (False, True)):
        found = {scene: _name(path, depth, with_suffix) for scene, path in left.items()}
        counts = Counter(found.values())
        names |= {s: name for s, name in found.items() if counts[name] == 1 or s not in names}
        left = {scene: path for scene, path in left.items() if counts[found[scene]] > 1}
    return {**names, STREAM: "stdin"}


def _name(path: PurePath, depth: int, with_suffix: bool) -> str:
    folders = [part for part in path.parts[-1 - depth : -1] if part.strip("/.")]
    return "_".join([*folders, path.name if with_suffix else path.stem])


def _own(out: str | None, name: str, flag: str, suffix: str, are_several: bool) -> str | None:
    """Return the output of the scene of a name."""
    if out is None:
        return None
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


def _check_apart(commands: Iterable[CommandLine], flag: str) -> None:
    """Refuse two scenes that would be written to one file."""
    first: dict[Path, str] = {}
    for item in commands:
        files = files_of(item)
        for path in files:
            if path in first:
                is_stats = item.run.stats is not None and path == Path(item.run.stats)
                if files.count(path) > 1:
                    raise UsageError(f"--stats {path}: the picture is written there; name a .json")
                cure = "; render them into two folders" if item.run.batch else ""
                raise UsageError(
                    f"{'--stats' if is_stats else flag}: {first[path]} and {item.scene} would both"
                    f" be written to {path}{cure}"
                )
            first[path] = item.scene
