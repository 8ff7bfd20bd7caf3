"""Parameters from measurements: scenario and tests → model → residuals → fit → statistics → outcome, one way."""
