"""What a digital controller does within a step, compiled."""
