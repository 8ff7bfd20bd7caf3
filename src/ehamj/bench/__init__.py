"""Timings as ratios within one process, one file each.

Each figure is the median of interleaved repetitions, so that a busy machine disturbs both sides alike.
"""
