"""The command `ssdo-gl`: reads and checks arguments, and says what went wrong."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ssdo_gl.dispatch import carry_out, check_flags_used
from ssdo_gl.gpu.context import ContextError
from ssdo_gl.images.files import STDOUT, check_output, image_paths
from ssdo_gl.options.flags import (
    STREAM,
    CommandLine,
    UsageError,
    build_parser,
    flag_infos,
    read_command,
    wanted_aovs,
)
from ssdo_gl.options.resolve import camera_from_text, settings_for
from ssdo_gl.options.several_scenes import one_by_one
from ssdo_gl.process import (
    EXIT_INTERRUPTED,
    EXIT_NO_OPENGL,
    EXIT_USER,
    Terminated,
    check_said,
    exit_code,
    signals_as_exceptions,
    steadfast_output,
)
from ssdo_gl.settings import modes
from ssdo_gl.settings.loading import FIT
from ssdo_gl.user_error import UserError
from ssdo_gl.wording import printable

if TYPE_CHECKING:
    from ssdo_gl.gpu.warm_device import WarmDevice

__all__ = ["build_parser", "main", "run"]

# Windows are made by GLFW alone.
_WINDOW_BACKENDS = ("auto", "window")


def _with_preset(command: CommandLine) -> dict[str, Any]:
    """Return the given settings, and what the preset sets and no flag does."""
    given = dict(command.settings)
    if command.run.preset is None:
        return given
    from ssdo_gl.bench.presets import load_preset

    fields = load_preset(command.run.preset, given.get("method"))
    overrides = {**fields.get("overrides", {}), **given.get("overrides", {})}
    return {**fields, **given, "overrides": overrides}


def command_text(arguments: Sequence[str] | None) -> str:
    """Return the command line as one types it."""
    return shlex.join(["ssdo-gl", *(sys.argv[1:] if arguments is None else arguments)])


def _check_outputs(command: CommandLine, wanted: Sequence[str]) -> None:
    """Refuse outputs that cannot be written, before anybody waits for them."""
    run = command.run
    for flag in ("snapshot", "stats", "bench", "film"):
        if getattr(run, flag) == "":
            raise UsageError(f"--{flag} '': the name is empty")
    for flag in ("film", "bench", "out"):
        if getattr(run, flag) == STREAM:
            raise UsageError(f"--{flag} -: standard output takes the PNG of --snapshot alone")
    if run.scheduler is not None:
        from ssdo_gl.farm.scheduler import check_scheduler, silence_library

        check_scheduler(run.scheduler)
        silence_library()
        if STREAM in (command.scene, run.snapshot):
            raise UsageError("--scheduler: workers have no standard input or output (-)")
    if run.stats is not None:
        check_output(Path(run.stats), (".json",), new_folder=run.batch)
    if run.snapshot is not None:
        out = Path(run.snapshot)
        if out == STDOUT:
            if getattr(sys.stdout, "is_missing", False):
                raise UsageError("--snapshot -: standard output is closed")
            if sys.stdout.isatty():
                raise UsageError("--snapshot -: standard output is a terminal: pipe or name a file")
            if len(wanted) > 1:
                raise UsageError("--snapshot -: standard output takes one image of --aov")
            return
        for path in (out, *image_paths(out, wanted)):
            check_output(path, new_folder=run.batch)
    if run.film is not None:
        from ssdo_gl.headless.film import check_film

        check_film(Path(run.film), tuple(wanted), resume=run.resume)
    if run.serve and find_spec("aiohttp") is None:
        raise UsageError("--serve needs aiohttp: pip install 'ssdo_gl[serve]'")
    if modes.WINDOW in run.active and run.backend not in _WINDOW_BACKENDS:
        raise UsageError(
            f"--backend {run.backend} makes no window: it belongs to --snapshot OUT, --explain, "
            "--batch, --film OUT, --serve or --bench OUTDIR"
        )


def run(arguments: Sequence[str] | None = None) -> int:
    """Carry out one command line; raises the user-facing errors."""
    try:
        command = read_command(arguments)
    finally:  # --help and the like only print, and end
        check_said()
    wanted = wanted_aovs(command.run)
    commands = one_by_one(command)
    for item in commands:
        _check_outputs(item, wanted)
    options = command.run
    shots = None
    if options.film is not None:
        from ssdo_gl.film.shots import asked_shots

        shots = asked_shots(options, command.film)
    given = _with_preset(command)
    if options.camera not in (None, FIT, command.loading.camera):
        camera_from_text(options.camera)
    # Flags are checked before the scene is read, so that a typo costs no waiting.
    if "method" in given:
        check_flags_used(command, settings_for({}, given), wanted, is_scene_read=False)
    if options.batch or len(commands) > 1 or (options.snapshot and options.scheduler):
        work = partial(_reported_of_one, given=given, wanted=wanted)
        from ssdo_gl.farm.scenes import carry_out_all, render_batch

        return (render_batch if options.batch else carry_out_all)(commands, work)
    return carry_out(commands[0], given, wanted, command_text(arguments), shots)


def _reported_of_one(
    command: CommandLine, warm: WarmDevice, given: Mapping[str, Any], wanted: tuple[str, ...]
) -> int:
    work = partial(carry_out, command, given, wanted, warm=warm)
    return _reported(work, f"interrupted; of {command.scene} nothing was written")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code (0, 2, 3, 4, or 130 after Ctrl-C).

    Raises
    ------
    SystemExit
        After SIGTERM.
    """
    with steadfast_output() as out:
        try:
            return exit_code(_reported(partial(run, arguments)), out)
        except Terminated:
            print("ssdo-gl: terminated", file=sys.stderr)
            raise


def _reported(
    work: Callable[[], int], interrupted: str = "interrupted; nothing was written"
) -> int:
    """Return the code that `work` returns, or say its fault in one line and return that."""
    try:
        with signals_as_exceptions():
            return work()
    except (UserError, MemoryError) as error:
        message, code = _message_of(error), EXIT_USER
    except ContextError as error:
        message, code = str(error), EXIT_NO_OPENGL
    except KeyboardInterrupt as error:
        message, code = str(error) or interrupted, EXIT_INTERRUPTED
    # One line; blanks within it stay, because names of files may have several in a row.
    line = " ".join(part.strip() for part in message.splitlines() if part.strip())
    print(f"ssdo-gl: {printable(line)}", file=sys.stderr)
    return code


def _message_of(error: Exception) -> str:
    """Return what to say of a fault; of an argument, as of the flag that it came from."""
    message = str(error) if isinstance(error, UserError) else f"not enough memory: {error}"
    name, _, rest = message.partition(" ")
    found = flag_infos().get(name) if rest.startswith(("= ", "belongs ")) else None
    return message if found is None else f"{found[1].flag} {rest}"


if __name__ == "__main__":
    sys.exit(main())
