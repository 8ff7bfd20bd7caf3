"""The small-motion engine: the compiled machine as matrices about its equilibrium, its isolators in lanes.

`probe` moves the compiled model and reads its forces, `machine` makes matrices of them, `slides` how they follow slides
that move. A lane is one simulation; those of equal structure advance together as structure of arrays, the lane last.
"""
