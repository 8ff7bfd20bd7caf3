"""How the kernels are compiled, and where compiled code is kept between runs, so that only the first run waits for it.

Kernels run without the GIL, and with IEEE division: a bad state becomes a NaN, not a crash. There is one folder per
state of their sources: Numba notices a changed file but not a changed file that it was compiled from. Where no folder
can be written, everything still works, uncached.
"""

import contextlib
import hashlib
import os
import tempfile
import threading
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import mujoco
import numba
from platformdirs import user_cache_path

kernel = numba.njit(nogil=True, error_model="numpy", forceinline=True)
"""Decorator of every kernel. Kernels are compiled into their callers, which hold the cache."""

COMPILED = (
    "isolator",
    "memory.py",
    "mujoco",
    "control/compiled",
    "compiled.py",
    "plant/axes.py",
)
"""Files and folders of the package that compiled code depends on; a change in any other compiles nothing anew."""


@cache
def fingerprint() -> str:
    """Hash of everything that the compiled code depends on."""
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for name in COMPILED:
        path = package / name
        for source in sorted(path.glob("*.py")) if path.is_dir() else [path]:
            digest.update(source.read_bytes())
    digest.update(repr((mujoco.__version__, numba.__version__)).encode())
    return digest.hexdigest()[:16]


@cache
def folder() -> Path | None:
    """The cache folder, or None if none can be written. ``EHAMJ_CACHE_DIR`` overrides the user's cache folder."""
    root = Path(os.environ.get("EHAMJ_CACHE_DIR") or user_cache_path("ehamj"))
    path = root / fingerprint()
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError:
        return None


_one_at_a_time = threading.Lock()
"""Numba's folder is the process's: of two threads that set it, one would take it from the other in mid-compilation."""


@contextlib.contextmanager
def compiled_here() -> Iterator[bool]:
    """Within, functions decorated with ``cache=`` the yielded value keep their compiled code in `folder`."""
    path = folder()
    with _one_at_a_time:
        before = numba.config.CACHE_DIR
        try:
            if path is not None:
                numba.config.CACHE_DIR = str(path)
            yield path is not None
        finally:
            numba.config.CACHE_DIR = before
