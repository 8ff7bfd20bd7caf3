"""Where compiled code is kept between runs, so that only the first run waits for it.

There is one folder per `ehamj.compiled.identity` of what was compiled, wherever its source lies. Where no folder can be
written, or its disk is full, everything still works, uncached. Each file ends with a digest of itself: one that is
damaged is compiled anew.
"""

import contextlib
import gc
import hashlib
import io
import threading
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

import numba
from numba.core import caching

from ehamj.caches import cache_folder
from ehamj.compiled import OPTIONS
from ehamj.compiled.identity import identity
from ehamj.compiled.told import as_one
from ehamj.errors import Recompiled

_one_at_a_time = threading.Lock()
"""Where Numba keeps its code is the process's setting: of two threads that set it, one would take it from the other."""


FORMAT = 2
"""Of the files: 2 with a digest at their end."""


class Locator(caching._CacheLocator):
    """Tells Numba where the code of a function is kept: by what the function is, not by its file."""

    def __init__(self, function: Any) -> None:
        self._stamp = f"{identity(function)}-{FORMAT}"

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self:
        return cls(py_func)

    def get_cache_path(self) -> str:
        return str((cache_folder() or Path()) / self._stamp)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        return ""


class _Checked(caching.IndexDataCacheFile):
    """Files of kept code of which none is understood that is not as it was written: what a damaged one would do is
    anything."""

    @contextlib.contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        with super()._open_for_write(filepath) as file, io.BytesIO() as content:
            yield content
            file.write(content.getvalue() + _digest(content.getvalue()))

    def save(self, key: Any, data: Any) -> None:
        with contextlib.suppress(OSError):
            super().save(key, data)

    def _load_index(self) -> dict[Any, str]:
        if not _sound(Path(self._index_path)):
            return {}
        try:
            return super()._load_index()
        except (AttributeError, ImportError):  # it names a class that another version of ehamj has, and this one not
            return {}

    def _load_data(self, name: str) -> Any:
        if not _sound(Path(self._data_path(name))):
            raise FileNotFoundError(name)  # Numba then compiles
        try:
            return super()._load_data(name)
        except (AttributeError, ImportError) as error:
            raise FileNotFoundError(name) from error


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _sound(path: Path) -> bool:
    """Whether a file is as it was written, or not there; one that is not goes, with a warning."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return True
    except OSError:
        return False
    size = hashlib.sha256().digest_size
    if content[-size:] == _digest(content[:-size]):
        return True
    warnings.warn(f"kept code was damaged and is compiled anew ({path})", Recompiled, stacklevel=2)
    with contextlib.suppress(OSError):
        path.unlink()
    return False


@contextlib.contextmanager
def _located(function: Any) -> Iterator[bool]:
    """Within, functions decorated with ``cache=`` the yielded value keep their compiled code in `cache_folder`."""
    with _one_at_a_time:
        before = numba.config.CACHE_LOCATOR_CLASSES, caching.IndexDataCacheFile
        try:
            numba.config.CACHE_LOCATOR_CLASSES = f"{__name__}.{Locator.__name__}"
            caching.IndexDataCacheFile = _Checked
            with uncollected(), as_one(function):
                yield cache_folder() is not None
        finally:
            numba.config.CACHE_LOCATOR_CLASSES, caching.IndexDataCacheFile = before


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
