"""The small-motion engine: the linear mechanics of the compiled model, and the isolators' own equations, in lanes.

A lane is one simulation. Those of equal structure advance together as structure of arrays, the lane last.
"""
