"""The kinds of cases, and what each may end in."""

from dataclasses import dataclass

from fuzz.case import Maker
from fuzz.scenarios import mutated, valid


@dataclass(frozen=True)
class Kind:
    """A generator of cases, and how many a full run has."""

    make: Maker
    full: int
    about: str


KINDS = {
    "mutated": Kind(mutated, 20_000, "scenarios with values, keys or bytes as they must not be"),
    "valid": Kind(valid, 5_000, "scenarios drawn from the schema, short"),
}
