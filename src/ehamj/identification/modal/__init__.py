"""Measured modes beside the model's: which is which, and how far apart they are."""
