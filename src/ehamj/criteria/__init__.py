"""Vibration criteria: one module per norm, and the third-octave bands that they share."""
