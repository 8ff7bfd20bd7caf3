"""Linear analysis: the single actuator of the paper, the whole machine at its operating point."""
