"""Plans: which designs a study looks at."""
