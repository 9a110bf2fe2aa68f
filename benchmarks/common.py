"""What several benchmarks need."""

from __future__ import annotations

import argparse
import functools
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NoReturn, TypeVar, cast

from ssdo_gl.gpu.context import ContextError
from ssdo_gl.process import EXIT_INTERRUPTED, EXIT_NO_OPENGL, EXIT_USER, signals_as_exceptions
from ssdo_gl.scene.load import builtin_names, load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, parse
from ssdo_gl.user_error import UserError


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong, as `ssdo-gl` does."""

    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_USER, f"{self.prog}: {message}\n")


def command(name: str, doc: str | None) -> argparse.ArgumentParser:
    """Return the parser of ``python -m benchmarks.NAME``; `doc` is the script's docstring."""
    first, _, rest = (doc or "").partition("\n")
    return _Parser(
        prog=f"python -m benchmarks.{name}",
        description=first,
        epilog=rest.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


Main = TypeVar("Main", bound=Callable[..., int])


def answering(main: Main) -> Main:
    """Return `main` so that a fault of the user's or the disk's is one line and an exit code."""

    @functools.wraps(main)
    def answered(argv: Sequence[str] | None = None) -> int:
        try:
            with signals_as_exceptions():
                return main(argv)
        except (UserError, OSError) as error:
            message, code = str(error), EXIT_USER
        except ContextError as error:
            message, code = str(error), EXIT_NO_OPENGL
        except KeyboardInterrupt:
            message, code = "interrupted", EXIT_INTERRUPTED
        print(f"{Path(main.__code__.co_filename).stem}: {message}", file=sys.stderr)
        return code

    return cast(Main, answered)


def size_of(text: str) -> tuple[int, int]:
    """Return WxH in pixels: a type of arguments."""
    try:
        size: tuple[int, int] = parse(Settings, "size", text)
    except SettingError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("size = ")) from None
    return size


def positive(text: str) -> int:
    """Return a whole number from 1 on: a type of arguments."""
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text[:60]!r}: expected a whole number from 1 on")
    return int(text)


def check_scenes(names: Iterable[str]) -> None:
    """Raise SceneError if one is none, so that nobody waits for the others to hear it."""
    known = builtin_names()
    for name in names:
        if name not in known and not os.path.isfile(name):
            load_scene(name)
