"""Pure compiled kernels of the hydraulics: plain floats in, plain floats out, one equation each.

numpy and numba only; nothing here knows of MuJoCo, scenarios or files. Units are SI, the spool is in mA.
"""
