"""A process that draws frames by the program of one checkout, and is told which."""

from __future__ import annotations

import contextlib
import json
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

from benchmarks.checkout import ROOT
from ssdo_gl.user_error import UserError

START = "from benchmarks.frame_driver import main; main()"
# Until programs are compiled and averages are as long as they get.
WARM_UP = 12
# Where nothing moves, until nothing is left to later frames, too, at most so often.
MOST_WARM_UPS = 30
ENDS_WITHIN_S = 10.0


class SideError(UserError):
    """One line that says why a side draws nothing."""


class NoCaseError(Exception):
    """Why a side has nothing to draw of a case."""


class Side:
    """A process that draws frames of one scene by the program of one checkout.

    Parameters
    ----------
    name : str
        Of the checkout, for messages.
    job : mapping
        As `benchmarks.frame_driver` takes it.
    """

    def __init__(self, name: str, tree: Path, job: dict[str, Any]) -> None:
        self.name = name
        # In a session of its own, so that Ctrl-C reaches this process alone, which ends that one.
        self._process = subprocess.Popen(
            [sys.executable, "-c", START, str(tree), json.dumps(job)],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def loaded(self) -> None:
        """Wait until the scene is there; raises SideError."""
        self._answer()

    def warm(self, case: str) -> int:
        """Draw a case until its frames are alike; return the number of the next frame."""
        for turn in range(MOST_WARM_UPS if case == "still" else 1):
            if self._ask(case, turn * WARM_UP, WARM_UP)["is_settled"]:
                break
        return (turn + 1) * WARM_UP

    def frames_ms(self, case: str, first: int, count: int) -> float:
        """Return the mean processor time of frames."""
        return statistics.fmean(self._ask(case, first, count)["ms"])

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None and self._process.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            # It ends with the frames that it is drawing.
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(ENDS_WITHIN_S)
        finally:
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()

    def _ask(self, *request: Any) -> dict[str, Any]:
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        answer = json.loads(line) if line else {"error": "its process has ended"}
        if "error" in answer:
            raise SideError(f"{self.name}: {answer['error']}")
        if "none" in answer:
            raise NoCaseError(answer["none"])
        return dict(answer)
