"""Timings as ratios within one process."""
