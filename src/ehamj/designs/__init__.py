"""Closed forms for many designs at once."""
