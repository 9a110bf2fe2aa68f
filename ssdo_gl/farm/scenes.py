"""Carries a command out for each of several scenes, here or on workers."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from ssdo_gl.farm.scheduler import mapped
from ssdo_gl.printable import printable
from ssdo_gl.process import EXIT_INTERRUPTED
from ssdo_gl.settings.flags import CommandLine

Work = Callable[[CommandLine], int]


@dataclass(frozen=True)
class Said:
    """The exit code of a command, and what it has printed."""

    code: int
    out: str
    err: str


class CapturedWork:
    """Carries commands out on a worker.

    Parameters
    ----------
    task : (Work, Path)
        What takes a command and returns an exit code; the folder that names of files are
        of, which the worker must see under the same name.
    """

    def __init__(self, task: tuple[Work, Path]) -> None:
        self._work, folder = task
        # The process is the worker's own, and does nothing else.
        os.chdir(folder)

    def make(self, command: CommandLine) -> Said:
        """Carry out one command."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = self._work(command)
        return Said(code, out.getvalue(), err.getvalue())

    def close(self) -> None:
        """Nothing is held."""


def codes_of_all(commands: Sequence[CommandLine], work: Work) -> list[int]:
    """Do `work` for each command, where the first says; return the exit codes until Ctrl-C."""
    options = commands[0].run
    if options.scheduler is None:
        codes = []
        for command in commands:
            _print_name(command)
            codes.append(work(command))
            if codes[-1] == EXIT_INTERRUPTED:
                break
        return codes
    with closing(mapped(options.scheduler, CapturedWork, (work, Path.cwd()), commands)) as told:
        return list(_printed(commands, told))


def _printed(commands: Sequence[CommandLine], told: Iterator[Said]) -> Iterator[int]:
    for command, said in zip(commands, told, strict=True):
        _print_name(command)
        print(said.out, end="", flush=True)
        print(said.err, end="", file=sys.stderr, flush=True)
        yield said.code


def _print_name(command: CommandLine) -> None:
    if not command.run.quiet:
        print(f"{printable(command.scene)}:", flush=True)
