"""Measurements of the project itself; not in the wheel."""
