"""Run one scenario, or many."""
