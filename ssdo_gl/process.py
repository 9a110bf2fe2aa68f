"""What the operating system does to a command, signals and streams, and what it is told."""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, TextIO, cast

from ssdo_gl.user_error import EarlyNote, UserError

EXIT_OK, EXIT_USER, EXIT_NO_OPENGL, EXIT_MISSED = 0, 2, 3, 4
EXIT_INTERRUPTED = 128 + signal.SIGINT
EXIT_BROKEN_PIPE = 128 + 13  # SIGPIPE, which Windows does not name
# How long to wait before it is looked again whether a signal can be heard.
RETRY_S = 0.001


class LostOutputError(UserError):
    """What a command had to say was lost."""


def home_folder() -> Path | None:
    """Return the user's own folder; None if there is none, as in a container."""
    try:
        return Path.home()
    except RuntimeError:
        return None


class _Stream:
    """A text stream that loses what cannot be written instead of ending the command.

    What the command is for stands in files; a full disk or a closed pipe behind its
    messages must not undo that. Attributes are those of the stream inside.
    """

    def __init__(self, stream: TextIO | None, nowhere: TextIO) -> None:
        # It is None where it was closed before the start.
        self.is_missing = stream is None
        self._stream = stream = stream or nowhere
        self.fault: OSError | ValueError | None = None
        self.is_fault_told = False
        if hasattr(stream, "reconfigure"):
            # Names hold letters that a terminal's encoding may lack.
            stream.reconfigure(errors="backslashreplace")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        if self.fault is None:
            try:
                self._stream.write(text)
            except (OSError, ValueError) as error:  # ValueError: it was closed
                self.lose(error)
        return len(text)

    def flush(self) -> None:
        if self.fault is None:
            try:
                self._stream.flush()
            except (OSError, ValueError) as error:
                self.lose(error)

    def lose(self, error: OSError | ValueError) -> None:
        """Write nothing more, and keep the reason."""
        self.fault = error
        try:
            # What is buffered would be tried again, and complained about, at exit.
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
        except (OSError, ValueError):
            pass


@contextmanager
def steadfast_output() -> Iterator[_Stream]:
    """Let no fault of standard output or error end the work; yields standard output."""
    before = sys.stdout, sys.stderr
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        out, err = (_Stream(stream, nowhere) for stream in before)
        sys.stdout, sys.stderr = cast(TextIO, out), cast(TextIO, err)
        try:
            yield out
        finally:
            out.flush()
            if out.fault is not None and not (out.is_fault_told or _is_broken_pipe(out.fault)):
                print(f"ssdo-gl: standard output: {out.fault}", file=sys.stderr)
            err.flush()
            sys.stdout, sys.stderr = before


def _is_broken_pipe(fault: OSError | ValueError) -> bool:
    return isinstance(fault, OSError) and fault.errno == errno.EPIPE


def check_said() -> None:
    """Raise LostOutputError, once, if something printed was lost: for what is there to be read.

    A reader who has left is no fault here.
    """
    out = sys.stdout
    out.flush()
    if not isinstance(out, _Stream) or out.fault is None or _is_broken_pipe(out.fault):
        return
    if not out.is_fault_told:
        out.is_fault_told = True
        raise LostOutputError(f"standard output: {out.fault}")


def exit_code(code: int, out: _Stream) -> int:
    """Return a command's exit code: that of a broken pipe where its reader has left."""
    out.flush()
    is_broken = code == 0 and out.fault is not None and _is_broken_pipe(out.fault)
    return EXIT_BROKEN_PIPE if is_broken else code


@contextmanager
def notes_at_once(*, quiet: bool) -> Iterator[None]:
    """Print each `EarlyNote` in one line, none if `quiet`; other warnings stay as they are."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if quiet else "always", EarlyNote)
        show = warnings.showwarning

        def said(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, EarlyNote):
                print(f"note: {message}", file=sys.stderr, flush=True)
            else:
                show(message, category, filename, lineno, file, line)

        warnings.showwarning = said
        yield


class Terminated(SystemExit):
    """SIGTERM; other exits, as of ``--help``, are none of a signal."""


def _end(number: int, _frame: FrameType | None) -> None:
    # Unwinds the stack, so that temporary files go.
    raise Terminated(128 + number)


@contextmanager
def signals_as_exceptions() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM unwind the stack instead of stopping the process dead."""
    handlers = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: _end}
    try:
        before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    except ValueError:  # only the main thread may
        yield
        return
    try:
        with _lost_signals_sent_again():
            yield
    except Exception as error:
        if (signalled := _signal_behind(error)) is None:
            raise
        raise signalled from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _signal_behind(error: BaseException) -> BaseException | None:
    """Return the signal's exception on whose way out `error` arose, if there was one.

    An import that is interrupted ends, once in some 200 times, in a KeyError of its locks.
    """
    found: BaseException | None = error
    while found is not None and not isinstance(found, (KeyboardInterrupt, Terminated)):
        found = found.__context__
    return found


@contextmanager
def _lost_signals_sent_again() -> Iterator[None]:
    """Send a signal again whose exception was raised in a finalizer, where Python drops it.

    Textures that are dropped are so often finalized that one signal in 300 met that in a bench.
    """
    before, is_busy = sys.unraisablehook, False

    def send_again(number: int) -> None:
        while is_busy:
            time.sleep(RETRY_S)
        signal.raise_signal(number)

    def hook(lost: sys.UnraisableHookArgs) -> None:
        nonlocal is_busy
        if isinstance(lost.exc_value, KeyboardInterrupt):
            number = signal.SIGINT
        elif isinstance(lost.exc_value, SystemExit):
            number = signal.SIGTERM
        else:
            before(lost)
            return
        # What a signal raises in here is dropped, too. Python looks for signals at calls and
        # jumps back, so that there is no such place after the last line.
        is_busy = True
        threading.Thread(target=send_again, args=(number,), daemon=True).start()
        is_busy = False

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def give_back_memory() -> None:
    """Return freed memory to the system, of which glibc keeps some tens of megabytes."""
    import ctypes

    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # another C library
        return
    trim(0)
