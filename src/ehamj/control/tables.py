"""Numbers that a law's file holds by name."""

from collections.abc import Mapping
from typing import Any

from ehamj.errors import InputError


def numbers_in(table: Any, names: tuple[str, ...], where: str) -> list[float]:
    """The numbers of a table in the order of their ``names``; ``where`` in the file it stands.

    Raises:
        InputError: if a key is missing or unknown, or an entry is no number.
    """
    if not isinstance(table, Mapping) or set(table) != set(names):
        raise InputError(f"{where}: each must be a table of {', '.join(names)}")
    try:
        return [float(table[name]) for name in names]
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{where}: {error}; every entry must be a number") from error
