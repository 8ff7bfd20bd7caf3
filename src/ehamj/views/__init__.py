"""What a scenario's machine is at rest, linear, and as a law meets it."""
