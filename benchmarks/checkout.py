"""Another commit of this repository, checked out for a while."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ssdo_gl.user_error import UserError

ROOT = Path(__file__).parent.parent


class CommitError(UserError, ValueError):
    """One line that says why there is no such checkout."""


def git(*arguments: str) -> str:
    """Return what git prints, run in this repository; raises CommitError."""
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    except FileNotFoundError:
        raise CommitError("git: there is no such command") from None
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise CommitError(f"git {arguments[0]}: {lines[-1]}")
    return done.stdout.strip()


def full_name(commit: str) -> str:
    """Return the hash of a commit, branch or tag; raises CommitError."""
    git("rev-parse", "--git-dir")
    try:
        return git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{commit}^{{commit}}")
    except CommitError:
        raise CommitError(f"{commit[:60]!r}: there is no such commit here") from None


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Yield a folder that holds a commit; it is removed at the end, whatever ended it."""
    name = full_name(commit)
    with tempfile.TemporaryDirectory(prefix="ssdo-gl-commit-") as folder:
        # Git calls a work tree by the last part: two at a time have two names.
        tree = Path(folder) / Path(folder).name
        try:
            git("worktree", "add", "--detach", "--quiet", str(tree), name)
            yield tree
        finally:
            # Also what an interrupted `add` has left.
            subprocess.run(
                ["git", "worktree", "remove", "--force", "--force", str(tree)],
                cwd=ROOT,
                capture_output=True,
            )
