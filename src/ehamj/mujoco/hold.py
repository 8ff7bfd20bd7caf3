"""The context manager that installs the callbacks, and leaves the process as it was."""

import contextlib
import ctypes
import threading
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

import mujoco

from ehamj.mujoco.callbacks import callbacks

_OURS = ("passive", "act_dyn", "act_bias")
_lock = threading.Lock()
_depth = 0
_timer: int | None = None
_log: int | None = None

LOG_ERROR: Final = 3
"""Level of a message of MuJoCo's after which the process ends."""


class ForeignCallbackError(RuntimeError):
    """Somebody else's callback is installed in MuJoCo; ehamj does not replace it."""


@cache
def library() -> ctypes.CDLL:
    """The MuJoCo library that the bindings use."""
    folder = Path(mujoco.__file__).parent
    found = sorted(folder.glob("libmujoco*")) + sorted(folder.glob("mujoco.dll"))
    if not found:
        raise RuntimeError(f"mujoco {mujoco.__version__}: its shared library is not in {folder}")
    return ctypes.CDLL(str(found[0]))


@cache
def _slot(name: str) -> ctypes.c_void_p:
    """The global variable that holds the address of a callback."""
    return ctypes.c_void_p.in_dll(library(), f"mjcb_{name}")


def installed() -> dict[str, bool]:
    """Which of the three callbacks are set, by whomever."""
    return {name: _slot(name).value is not None for name in _OURS}


@contextlib.contextmanager
def default_timer(off: bool) -> Iterator[None]:
    """Within, the profiling timer that the bindings install is ``off`` or as it was; for timings only."""
    slot = _slot("time")
    before = slot.value
    try:
        if off:
            slot.value = None
        yield
    finally:
        slot.value = before


class _Message(ctypes.Structure):
    """How a message of MuJoCo's begins (mjLogMessage)."""

    _fields_ = (("level", ctypes.c_int), ("topic", ctypes.c_int), ("subject", ctypes.c_char * 1024))


@cache
def _log_handler() -> Any:
    """Takes MuJoCo's messages: its own way is to print them, and to write MUJOCO_LOG.TXT where the user stands. What it
    warns of, it counts in MjData; the run reads it there (`ehamj.mujoco.warned`)."""
    handler = ctypes.CFUNCTYPE(None, ctypes.POINTER(_Message))

    def heard(message: Any) -> None:
        if message.contents.level >= LOG_ERROR and _log is not None:
            handler(_log)(message)

    return handler(heard)


@cache
def _set_log_handler() -> Any:
    exchange = library().mju_setLogHandler
    exchange.argtypes, exchange.restype = [ctypes.c_void_p], ctypes.c_void_p
    return exchange


def _exchange_log(handler: Any) -> int | None:
    """Let a handler take MuJoCo's messages; the address of the one before."""
    before: int | None = _set_log_handler()(
        handler if isinstance(handler, int) else ctypes.cast(handler, ctypes.c_void_p)
    )
    return before


@contextlib.contextmanager
def hydraulics() -> Iterator[None]:
    """Within, MuJoCo's user actuators are ehamj's hydraulics. Re-entrant, and shared by threads.

    The bindings' profiling timer is off meanwhile: reading the clock takes a fifth of a step of so small a model.
    MuJoCo warns nobody by itself, and writes no file.

    Raises:
        ForeignCallbackError: if one of the callbacks is taken.
    """
    global _depth, _timer, _log
    with _lock:
        if _depth == 0:
            taken = [name for name, is_set in installed().items() if is_set]
            if taken:
                raise ForeignCallbackError(
                    f"MuJoCo's callback mjcb_{taken[0]} is set by other code; set it to None while ehamj simulates"
                )
            ours = callbacks()
            timer = _slot("time")
            _timer, timer.value = timer.value, None
            _log = _exchange_log(_log_handler())
            for name, callback in zip(_OURS, ours, strict=True):
                _slot(name).value = callback.address
        _depth += 1
    try:
        yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                for name in _OURS:
                    _slot(name).value = None
                _slot("time").value = _timer
                _exchange_log(_log)
