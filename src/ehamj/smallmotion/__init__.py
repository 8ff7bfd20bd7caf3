"""The small-motion engine: the compiled machine as constant matrices about its equilibrium.

`probe` moves the compiled model and reads its forces, `machine` makes matrices of them, `slides` how they follow slides
that move.
"""
