"""What the designs of a study tell: sensitivities, effects, regression. Arrays in, arrays out: no store, no page."""
