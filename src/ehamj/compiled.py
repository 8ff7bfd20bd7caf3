"""How the kernels are compiled: without the GIL, and with IEEE division: a bad state becomes a NaN, not a crash."""

import numba

kernel = numba.njit(nogil=True, error_model="numpy", forceinline=True)
"""Decorator of every kernel. Kernels are compiled into their callers, which hold the cache."""
