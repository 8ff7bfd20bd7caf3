"""What readers of texts with a header and a list of numbers share."""

import numpy as np

from ehamj.records.units import motion_unit
from ehamj.signals import Array


def numbers(label: str, lines: list[str], first: int, stated: int, key: str) -> Array:
    """The numbers of all lines from ``first`` on, shape (n,).

    Raises ValueError where one is none, or where they are not as many as the header states under ``key``.
    """
    where = f"ground.file = {label!r}"
    words = " ".join(lines[first:]).split()
    try:
        found = np.array(words, float)
    except ValueError:
        for number, line in enumerate(lines[first:], first + 1):
            for word in line.split():
                try:
                    float(word)
                except ValueError:
                    raise ValueError(f"{where}: line {number} holds {word[:40]!r}, which is not a number") from None
        raise
    if found.size != stated:
        cut = "; it may be truncated" if found.size < stated else ""
        raise ValueError(f"{where} holds {found.size} samples, and its header states {key} = {stated}{cut}")
    return found


def check_quantity(where: str, quantity: str, unit: str) -> None:
    """Raise ValueError where ``unit`` is unknown or of another quantity than the header says."""
    try:
        found = motion_unit(unit)[0]
    except ValueError as error:
        raise ValueError(f"{where}: the unit in its header: {error}") from None
    if found != quantity:
        raise ValueError(f"{where}: its header says {quantity} in {unit!r}, which is a unit of {found}")
