"""Passes that several effects share, and what passes have in common."""
