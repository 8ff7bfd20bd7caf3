"""What is being compiled and about how far that is, for those who wait; what the cache has is not told."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any

from numba.core import event

from ehamj.compiled import Kernel
from ehamj.compiled.identity import named

Told = Callable[[str, int, int], None]
"""Called with the name of what is compiled, and how many of how many functions of it are done; there may be more,
compiled for several types, or fewer, compiled before."""


class _Listener(event.Listener):
    """Counts what Numba compiles, by the function that somebody asked for."""

    def __init__(self, told: Told) -> None:
        self._told = told
        self._open, self._done, self._name, self._of = 0, 0, "", 1

    def on_start(self, event: Any) -> None:
        if not self._open:
            self._begin(event.data["dispatcher"].py_func)
        self._open += 1

    def on_end(self, event: Any) -> None:
        self._open -= 1
        self._done += 1
        self._told(self._name, min(self._done, self._of), self._of)

    def _begin(self, function: FunctionType) -> None:
        whole = _asked[-1] if _asked else function
        if whole.__name__ != self._name:
            self._name, self._done, self._of = whole.__name__, 0, len(_reached(whole, set()))
        self._told(self._name, min(self._done, self._of), self._of)


_asked: list[FunctionType] = []
"""What is compiled as one, where Numba does not say so itself."""


@contextmanager
def as_one(function: Any) -> Iterator[None]:
    """Within, what is compiled belongs to a function."""
    _asked.append(function)
    try:
        yield
    finally:
        _asked.pop()


@contextmanager
def telling(told: Told) -> Iterator[None]:
    """Within, tell what is compiled, by whichever thread."""
    listener = _Listener(told)
    event.register("numba:compile", listener)
    try:
        yield
    finally:
        event.unregister("numba:compile", listener)


def _reached(function: FunctionType, found: set[FunctionType]) -> set[FunctionType]:
    """A function and all kernels that it calls."""
    found.add(function)
    for _, value in named(function):
        if isinstance(value, Kernel) and value.py_func not in found:
            _reached(value.py_func, found)  # type: ignore[arg-type]
    return found
