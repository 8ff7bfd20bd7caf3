"""What a study is: all that its results depend on, checked before it is resumed."""

import hashlib
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

from ehamj.errors import InputError
from ehamj.scenario.keys import differences

PACKAGES: Final = ("ehamj", "numpy", "scipy", "numba", "llvmlite", "mujoco", "control", "slycot", "SALib", "pymoo")
"""Of which another version may give other results; llvmlite is what compiles the kernels."""
SHOWING: Final = ("bench", "cli", "pages", "plots", "replay", "report", "studies", "verify", "views", "study_files")
"""Rooms of ehamj that show results, or use them, and change none."""
NAMED: Final = 4
"""Differences that a message names."""


@cache
def versions() -> Mapping[str, str]:
    """What runs here, as far as results depend on it: Python, packages, and a hash of ehamj's own code."""
    found = {"Python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found | {"code of ehamj": _code()}


def _code() -> str:
    """A hash of the source of all that computes."""
    digest = hashlib.sha256()
    for name, text in sorted(_sources(resources.files("ehamj"), "")):
        digest.update(name.encode() + b"\0" + text + b"\0")
    return digest.hexdigest()[:12]


def _sources(folder: Any, before: str) -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            if before or entry.name not in SHOWING:
                yield from _sources(entry, f"{before}{entry.name}/")
        elif entry.name.endswith(".py"):
            yield f"{before}{entry.name}", entry.read_bytes()


def check_same(stored: Mapping[str, Any], own: Mapping[str, Any], said: str) -> None:
    """Refuse to resume a study as another one.

    Args:
        stored: what the study was, plain data in nested tables.
        own: what it would be.
        said: what messages begin with.

    Raises:
        InputError: which names what differs.
    """
    found = differences(stored, own)
    if not found:
        return
    told = [f"{key} was {_short(ours)} and is {_short(theirs)}" for key, (ours, theirs) in list(found.items())[:NAMED]]
    more = f", and {len(found) - NAMED} more" if len(found) > NAMED else ""
    only_versions = all(key.startswith("versions.") for key in found)
    way_out = "resume it with those versions" if only_versions else "resume it as it was"
    raise InputError(
        f"{said}: cannot be resumed, since results would not belong together: {'; '.join(told)}{more}; {way_out}, or "
        "begin a new one in another folder"
    )


def _short(value: Any) -> str:
    text = "absent" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:59]}…"
