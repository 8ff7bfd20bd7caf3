"""The kinds of cases, and what each may end in."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

from fuzz.case import Maker
from fuzz.records import record
from fuzz.scenarios import mutated, valid
from fuzz.signals import interrupted
from fuzz.stored import law, result
from fuzz.worker import Outcome


@dataclass(frozen=True)
class Kind:
    """A generator of cases, or what tries one out by itself, and how many a full run has."""

    make: Maker | None
    """None of what tries itself out."""
    full: int
    about: str
    try_out: Callable[[Random, Path, Path], Outcome] | None = None


KINDS = {
    "mutated": Kind(mutated, 20_000, "scenarios with values, keys or bytes as they must not be"),
    "valid": Kind(valid, 5_000, "scenarios drawn from the schema, short"),
    "record": Kind(record, 5_000, "damaged records of every format"),
    "law": Kind(law, 1_000, "laws' files with values, keys or bytes as they must not be"),
    "result": Kind(result, 1_000, "results' folders damaged, renamed, mixed, before what opens them"),
    "signal": Kind(None, 200, "commands that are killed or interrupted at any moment", interrupted),
}
