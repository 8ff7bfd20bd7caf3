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
from typing import Any

import mujoco
import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from platformdirs import user_cache_path

kernel = numba.njit(nogil=True, error_model="numpy", forceinline=True, no_cfunc_wrapper=True)
"""Decorator of every kernel. Kernels are compiled into their callers, which hold the cache."""


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), codegen


@kernel
def view(address, n, dtype):  # type: ignore[no-untyped-def]
    """``n`` numbers or records that lie from an address on, as an array."""
    return numba.carray(_pointer(address), n, dtype)


@kernel
def copy(values, result):  # type: ignore[no-untyped-def]
    """result = values, element by element: what assigns to a slice takes a second to compile, for its errors."""
    for k in range(result.size):
        result[k] = values[k]


def c_function(result: types.Type, *kinds: types.Type) -> Any:
    """A call, in compiled code, of C functions of this type: (address, tuple of arguments) → result."""

    @intrinsic
    def call(typing_context: Any, address: Any, arguments: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            returned = ir.VoidType() if result is types.void else context.get_value_type(result)
            kind = ir.FunctionType(returned, [context.get_value_type(each) for each in kinds])
            function = builder.inttoptr(values[0], ir.PointerType(kind))
            found = builder.call(function, cgutils.unpack_tuple(builder, values[1]))
            return context.get_dummy_value() if result is types.void else found

        return result(types.intp, types.Tuple(kinds)), codegen

    return call


COMPILED = (
    "isolator",
    "memory.py",
    "mujoco",
    "smallmotion",
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
