"""A scenario: its fields, how it is read, and what a wrong one is told."""
