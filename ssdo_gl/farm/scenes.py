"""Carries a command out for each of several scenes, here or on workers."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from ssdo_gl.farm.scheduler import mapped
from ssdo_gl.gpu.warm_device import WarmDevice
from ssdo_gl.options.flags import CommandLine
from ssdo_gl.options.several_scenes import files_of
from ssdo_gl.process import (
    EXIT_INTERRUPTED,
    EXIT_MISSED,
    EXIT_NO_OPENGL,
    EXIT_OK,
    EXIT_USER,
)
from ssdo_gl.progress import progress_on_terminal
from ssdo_gl.whole_files import has_data
from ssdo_gl.wording import counted, printable

# Carries a command out, on a device that may have drawn others before.
Work = Callable[[CommandLine, WarmDevice], int]
_PREFIX = "ssdo-gl: "
# Of several scenes the worst counts; this is from good to bad.
_SEVERITY = (EXIT_OK, EXIT_MISSED, EXIT_USER, EXIT_NO_OPENGL, EXIT_INTERRUPTED)


@dataclass(frozen=True)
class Said:
    """The exit code of a command, and what it has printed."""

    code: int
    out: str = ""
    err: str = ""


class CapturedWork:
    """Carries commands out, each without harm to the others, and keeps what they print.

    Parameters
    ----------
    task : (Work, Path)
        What takes a command and returns an exit code; the folder that names of files are
        of, which a worker must see under the same name.
    """

    def __init__(self, task: tuple[Work, Path]) -> None:
        self._work, folder = task
        # The process of a worker is its own, and does nothing else.
        os.chdir(folder)
        self._warm = WarmDevice()

    def make(self, command: CommandLine) -> Said:
        """Carry out one command."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = self._work(command, self._warm)
            except Exception as error:  # one scene must not end a night's work
                code = EXIT_USER
                print(f"{_PREFIX}{type(error).__name__}: {error}", file=sys.stderr)
        if code not in (EXIT_OK, EXIT_MISSED):
            # Nobody knows in what state it was left.
            self.close()
        return Said(code, out.getvalue(), err.getvalue())

    def close(self) -> None:
        """Free what has drawn."""
        self._warm.close()


def carry_out_all(commands: Sequence[CommandLine], work: Work) -> int:
    """Do `work` for each command until Ctrl-C, where the first says; return the worst code.

    Raises
    ------
    KeyboardInterrupt
        Of workers, saying how many scenes are done.
    """
    codes = []
    if commands[0].run.scheduler is None:
        with closing(WarmDevice()) as warm:
            for command in commands:
                _print_name(command)
                codes.append(work(command, warm))
                if codes[-1] == EXIT_INTERRUPTED:
                    break
        return _worst(codes)
    try:
        with closing(_captured(commands, work)) as told:
            for command, said in zip(commands, told, strict=True):
                _print_name(command)
                print(said.out, end="", flush=True)
                print(said.err, end="", file=sys.stderr, flush=True)
                codes.append(said.code)
    except KeyboardInterrupt:
        done = f"{len(codes)} of the {counted(len(commands), 'scene')}"
        raise KeyboardInterrupt(f"interrupted; {done} had been rendered") from None
    return _worst(codes)


def render_batch(commands: Sequence[CommandLine], work: Work) -> int:
    """Render a batch, where and as its first command says; return the worst exit code.

    On a terminal, a bar shows how far it is. What is printed besides are faults, each after
    the name of its scene, and one line at the end.

    Raises
    ------
    KeyboardInterrupt
        Saying how many pictures are there.
    """
    run = commands[0].run
    start = time.perf_counter()
    missing = [command for command in commands if not (run.resume and _is_there(command))]
    old = [_is_there(command) for command in missing]
    for folder in {path.parent for command in missing for path in files_of(command)}:
        folder.mkdir(exist_ok=True)
    silent = [replace(command, run=replace(command.run, quiet=True)) for command in missing]
    codes: list[int] = []
    try:
        with (
            progress_on_terminal(quiet=run.quiet) as progress,
            closing(_captured(silent, work)) as told,
        ):
            for command, said in zip(missing, told, strict=True):
                if said.code == EXIT_INTERRUPTED:
                    raise KeyboardInterrupt
                for line in said.err.splitlines():
                    print(_named(line, command.scene), file=sys.stderr, flush=True)
                codes.append(said.code)
                if progress:
                    progress("pictures", len(codes), len(missing))
    except KeyboardInterrupt:
        # Of workers, some that nothing has been heard of yet.
        rest = zip(missing[len(codes) :], old[len(codes) :], strict=True)
        made = _made(codes) + sum(_is_there(command) and not was for command, was in rest)
        raise KeyboardInterrupt(
            f"interrupted; {run.out} has {made} of the {len(missing)} pictures"
        ) from None
    if not run.quiet:
        kept, faulty = len(commands) - len(missing), len(missing) - _made(codes)
        there = f", {kept} were there" if kept else ""
        failed = f", {faulty} could not be made" if faulty else ""
        print(
            f"{printable(str(run.out))}: {counted(_made(codes), 'picture')}{there}{failed},"
            f" {time.perf_counter() - start:.1f} s"
        )
    return _worst(codes)


def _captured(commands: Sequence[CommandLine], work: Work) -> Generator[Said, None, None]:
    """Yield what comes of each command, here or on the workers that the first one names."""
    if not commands:
        return
    scheduler, task = commands[0].run.scheduler, (work, Path.cwd())
    if scheduler is not None:
        yield from mapped(scheduler, CapturedWork, task, commands, _lost)
        return
    with closing(CapturedWork(task)) as maker:
        for command in commands:
            yield maker.make(command)


def _lost(command: CommandLine) -> Said:
    reason = "it has ended several workers; is there memory enough for it?"
    return Said(EXIT_USER, err=f"{_PREFIX}{printable(command.scene)}: {reason}\n")


def _worst(codes: Sequence[int]) -> int:
    return max(codes, key=_SEVERITY.index, default=EXIT_OK)


def _is_there(command: CommandLine) -> bool:
    return all(has_data(path) for path in files_of(command))


def _made(codes: Sequence[int]) -> int:
    return sum(code in (EXIT_OK, EXIT_MISSED) for code in codes)


def _named(line: str, scene: str) -> str:
    """Return a line of one scene's command as one of the batch."""
    name, message = printable(scene), line.removeprefix(_PREFIX)
    return f"{_PREFIX}{message}" if name in message else f"{_PREFIX}{name}: {message}"


def _print_name(command: CommandLine) -> None:
    if not command.run.quiet:
        print(f"{printable(command.scene)}:", flush=True)
