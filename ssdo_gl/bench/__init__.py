"""Measures error against time: sweeps, truths, statistics, presets."""
