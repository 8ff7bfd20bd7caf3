"""Everything about one isolator: each component's equation beside its settings and the fields that it has in memory.

Kernels take floats and small named tuples of floats by value, one equation each. Nothing here knows of the engine,
scenarios or files. Units are SI, the spool is in mA.
"""
