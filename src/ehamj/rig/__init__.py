"""Virtual measurements of the simulated machine."""
