"""Measurements of a test on a rig: components of a logger's file as ehamj's channels, in SI and on one clock."""
