"""Studies of many designs: what a study file states, which designs that makes, and what becomes of them."""
