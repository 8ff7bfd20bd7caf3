"""How kernels are written: functions that compiled code calls, and that Python can call to try them.

Kernels run without the GIL, and with IEEE division: a bad state becomes a NaN, not a crash. They stand beside the
settings that they take; so that a scenario can be read without a compiler, Numba is imported when the first of them is
called or compiled.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, Final

OPTIONS: Final = {"nogil": True, "error_model": "numpy"}
"""How everything is compiled."""
PART: Final = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""How a kernel is: inlined into its callers, which hold the cache."""


class Kernel:
    """A function that compiled code can call; see `kernel`."""

    def __init__(self, function: Callable[..., Any], counts: bool) -> None:
        self.py_func, self.counts = function, counts
        update_wrapper(self, function)

    @cached_property
    def _part(self) -> Any:
        import numba

        from ehamj.compiled.parts import PartCompiler

        return numba.njit(pipeline_class=PartCompiler, _nrt=self.counts, **PART, **OPTIONS)(self.py_func)

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes it for where compiled code names it."""
        return self._part._numba_type_

    @cached_property
    def _whole(self) -> Any:
        import numba

        return numba.njit(**OPTIONS)(self.py_func)

    def __call__(self, *arguments: Any) -> Any:
        """What Python gets that tries it."""
        return self._whole(*arguments)


def kernel(function: Callable[..., Any]) -> Any:
    """Decorator of every kernel that gives no array.

    References to arrays are not counted in it, which would cost more than many a kernel: its callers keep them.
    """
    return Kernel(function, counts=False)


def giving_arrays(function: Callable[..., Any]) -> Any:
    """Decorator of kernels that give arrays or views."""
    return Kernel(function, counts=True)


def written(arguments: str, *body: str, **scope: Any) -> Any:
    """A kernel from source, for what Numba has no loop over: the fields of a record."""
    exec(f"def written({arguments}):\n    " + "\n    ".join(body), scope)
    return kernel(scope["written"])


@kernel
def copy(values, result):  # type: ignore[no-untyped-def]
    """result = values, element by element: what assigns to a slice takes a second to compile, for its errors."""
    for k in range(result.size):
        result[k] = values[k]
