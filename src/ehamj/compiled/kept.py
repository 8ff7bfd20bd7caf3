"""Where compiled code is kept between runs, so that only the first run waits for it.

There is one folder per `ehamj.compiled.identity` of what was compiled, wherever its source lies. Where no folder can be
written, everything still works, uncached.
"""

import contextlib
import gc
import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, Self

import numba
from numba.core.caching import _CacheLocator
from platformdirs import user_cache_path

from ehamj.compiled import OPTIONS
from ehamj.compiled.identity import identity
from ehamj.compiled.told import as_one

_one_at_a_time = threading.Lock()
"""Where Numba keeps its code is the process's setting: of two threads that set it, one would take it from the other."""


@cache
def folder() -> Path | None:
    """The cache folder, or None if none can be written. ``EHAMJ_CACHE_DIR`` overrides the user's cache folder."""
    path = Path(os.environ.get("EHAMJ_CACHE_DIR") or user_cache_path("ehamj"))
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError:
        return None


class Locator(_CacheLocator):
    """Tells Numba where the code of a function is kept: by what the function is, not by its file."""

    def __init__(self, function: Any) -> None:
        self._stamp = identity(function)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self:
        return cls(py_func)

    def get_cache_path(self) -> str:
        return str((folder() or Path()) / self._stamp)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        return ""


@contextlib.contextmanager
def _located(function: Any) -> Iterator[bool]:
    """Within, functions decorated with ``cache=`` the yielded value keep their compiled code in `folder`."""
    with _one_at_a_time:
        before = numba.config.CACHE_LOCATOR_CLASSES
        try:
            numba.config.CACHE_LOCATOR_CLASSES = f"{__name__}.{Locator.__name__}"
            with uncollected(), as_one(function):
                yield folder() is not None
        finally:
            numba.config.CACHE_LOCATOR_CLASSES = before


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """Within, nothing is looked for that could be forgotten: a compiler makes much that it keeps, and the looking takes
    a tenth of its time."""
    collecting = gc.isenabled()
    try:
        gc.disable()
        yield
    finally:
        if collecting:
            gc.enable()


def compiled(function: Callable[..., Any], signature: Any = None) -> Any:
    """A function that Python calls, compiled together with all that it calls, or taken from where that is kept.

    Without a ``signature`` that happens when it is called, for the types that it is called with.
    """
    with _located(function) as kept:
        return numba.njit(signature and [signature], cache=kept, no_cfunc_wrapper=True, **OPTIONS)(function)


def compiled_callback(function: Callable[..., Any], signature: Any) -> Any:
    """The same as a function that C calls; its ``address`` is what C is given, and it must be kept alive."""
    with _located(function) as kept:
        return numba.cfunc(signature, cache=kept, nopython=True, error_model=OPTIONS["error_model"])(function)
