"""The source paper: its actuator, its cases and claims, its figures."""
