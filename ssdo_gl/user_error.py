"""Faults of what a user gave, which the command says in one line."""

from __future__ import annotations


class UserError(Exception):
    """Input is at fault: the message names it, its value and the cure."""
