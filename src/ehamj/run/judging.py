"""What judges a run is imported while it is stepped, or after."""

import threading
from importlib import import_module

_importing = threading.Lock()


def import_judging() -> None:
    """Import what reads a run, for which no step waits; one thread at a time, since two would find each other's modules
    half made."""
    with _importing:
        for name in ("failures", "observe", "summarise"):
            import_module(f"ehamj.run.{name}")
