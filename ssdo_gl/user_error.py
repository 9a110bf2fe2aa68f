"""What the command says in one line: faults of what a user gave, and what will come of it."""

from __future__ import annotations


class UserError(Exception):
    """Input is at fault: the message names it, its value and the cure."""


class EarlyNote(UserWarning):
    """What a user should know before the work is done, which may take hours."""
