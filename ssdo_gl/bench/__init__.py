"""Measures error against time: sweeps, references, statistics, presets."""
