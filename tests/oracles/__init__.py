"""Independent oracles: a nonlinear SciPy machine and closed linear forms; neither imports the package under test."""
