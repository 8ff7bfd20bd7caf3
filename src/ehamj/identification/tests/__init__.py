"""Kinds of test that identification knows: what each measured, and how far the model is from it."""
