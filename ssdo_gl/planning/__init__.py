"""Decides from scene and view what a frame runs, and why."""
