"""What a kernel is: a hash of all that its machine code depends on, and of nothing else.

Not its source, of which comments, docstrings, names of files and numbers of lines are no part of what runs, but its
byte code and constants, and those of everything that it names: other kernels, numbers, records, named tuples,
intrinsics. So the compiled code of an older release serves a newer one that changed none of them.
"""

import hashlib
import inspect
from collections.abc import Iterator
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.extending import _Intrinsic

from ehamj.compiled import OPTIONS, PART, Kernel, parts

_LIBRARIES = ("numba", "numpy", "llvmlite", "math")
"""Their functions are what their name says; a change of Numba's version compiles everything anew."""

_known: dict[int, tuple[FunctionType, bytes]] = {}
"""What was found for each function (its name, while it is looked at), and the function, so that numbers stay theirs."""


def identity(function: FunctionType) -> str:
    """The hash of a function that is compiled together with all that it calls.

    Raises:
        TypeError: if it names something that this file does not know how to tell from a changed one.
    """
    return hashlib.sha256(_digest(function) + repr((PART, OPTIONS, inspect.getsource(parts))).encode()).hexdigest()[:16]


def _digest(function: FunctionType) -> bytes:
    if id(function) not in _known:
        _known[id(function)] = (function, function.__qualname__.encode())  # what a recursive function sees of itself
        digest = hashlib.sha256()
        for part in _parts(function):
            digest.update(part)
        _known[id(function)] = (function, digest.digest())
    return _known[id(function)][1]


def _parts(function: FunctionType) -> Iterator[bytes]:
    """Code and defaults, and whatever its names stand for."""
    yield _told(_code(function.__code__, function.__doc__))
    yield _told(function.__defaults__)
    yield from map(_told, named(function))


def named(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Names that the code of a function uses and does not define, and what they stand for."""
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents
    for name in sorted(set(_names(function.__code__)) & function.__globals__.keys()):
        yield name, function.__globals__[name]


def _code(code: CodeType, documentation: str | None = None) -> tuple[Any, ...]:
    constants = tuple(_code(one) if isinstance(one, CodeType) else one for one in code.co_consts)
    own = tuple(one for one in constants if documentation is None or one != documentation)
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return (code.co_code, own, *names, code.co_argcount, code.co_flags)


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _names(one)


def _told(value: Any) -> bytes:
    """Bytes that differ where compiled code would."""
    if isinstance(value, Kernel | Dispatcher):
        return _told((getattr(value, "counts", None), value.py_func))
    if isinstance(value, _Intrinsic):
        return _told(value._defn)
    if isinstance(value, FunctionType | BuiltinFunctionType | np.ufunc | type):
        return _named(value)
    if isinstance(value, ModuleType):
        return value.__name__.encode()
    if isinstance(value, tuple):
        return b"(%b:%b)" % (_told(type(value)), b",".join(map(_told, value)))
    if isinstance(value, np.ndarray):
        return repr((value.dtype, value.shape, value.tobytes())).encode()
    if value is None or isinstance(
        value, bool | int | float | complex | str | bytes | np.dtype | np.generic | numba.types.Type
    ):
        return repr(value).encode()
    raise TypeError(f"compiled code names {value!r}, a {type(value).__name__}: tell ehamj.compiled.identity what it is")


def _named(value: Any) -> bytes:
    """A function or a class: its name, and what of it compiled code may depend on."""
    name = f"{value.__module__}.{value.__name__}" if hasattr(value, "__module__") else value.__name__
    if isinstance(value, FunctionType) and name.split(".")[0] not in _LIBRARIES:
        return _digest(value)
    fields = getattr(value, "_fields", ())
    return f"{name}{fields if isinstance(fields, tuple) else ()}".encode()
