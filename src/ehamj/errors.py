"""The two ways things go wrong for a user, and what he should have been told."""

import difflib
from collections.abc import Iterable
from typing import Final

LONGEST_WORD: Final = 80
"""Letters of what was written that are compared."""


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """What stands before a list of what is allowed: what is nearest to the word that was written; empty if none is."""
    near = difflib.get_close_matches(word[:LONGEST_WORD], list(allowed), n=1)
    return f"did you mean {near[0]!r}? " if near else ""


class InputError(ValueError):
    """Bad input: the message names the key, the value and what is allowed. Nothing was computed or written."""


class SimulationFailed(RuntimeError):
    """The simulation itself failed: the message says what, where and when. What was computed until then is kept."""


class DerivedAnew(UserWarning):
    """A law was derived for a changed machine: it knows what it could not know of a machine within tolerances."""


class Recompiled(UserWarning):
    """Compiled code that was kept is damaged: it is compiled anew, which takes a while."""
