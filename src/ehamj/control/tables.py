"""What a law's file holds: keys that are known, numbers that are no texts."""

import reprlib
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar

from ehamj.errors import InputError, did_you_mean
from ehamj.plain.text import json_of

T = TypeVar("T")


def numbers_in(table: Any, names: tuple[str, ...], where: str) -> list[float]:
    """The numbers of a table in the order of their ``names``; ``where`` in the file it stands.

    Raises:
        InputError: if a key is missing or unknown, or an entry is no number.
    """
    if not isinstance(table, Mapping) or set(table) != set(names):
        raise InputError(f"{where}: each must be a table of {', '.join(names)}")
    return [number_in(table[name], f"{where}.{name}") for name in names]


def number_in(value: Any, where: str) -> float:
    """A number of a law's file; ``where`` in it.

    Raises:
        InputError: if it is none.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{where} = {reprlib.repr(value)}: must be a number")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{where}: is beyond what a number can be") from None


def check_keys(where: str, table: Mapping[str, Any], known: Sequence[str]) -> None:
    """Refuse what stands in a law's file and means nothing there: with another key it may have been meant.

    Raises:
        InputError: which names the key and those that are known.
    """
    for key in table:
        if key not in known:
            raise InputError(f"{where}.{key}: unknown key; {did_you_mean(key, known)}allowed: {', '.join(known)}")


def names_in(names: Any) -> tuple[str, ...]:
    """Names of channels in a law's file; raises InputError where they are none."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"controller.inputs = {reprlib.repr(names)}: must be a list of channels' names")
    return tuple(names)


def flag_in(value: Any) -> bool:
    """Whether a law reads from rest, as its file says; raises InputError where it does not."""
    if not isinstance(value, bool):
        raise InputError(f"controller.from_rest = {reprlib.repr(value)}: must be true or false")
    return value


def read_table(path: str | Path) -> dict[str, Any]:
    """The JSON object in a file.

    Raises:
        InputError: if there is none.
    """
    try:
        table = json_of(Path(path))
    except (OSError, ValueError) as error:
        raise InputError(f"control.file = {str(path)!r}: cannot be read as a controller ({error})") from error
    if not isinstance(table, dict):
        raise InputError(f"control.file = {str(path)!r}: must hold one JSON object")
    return table


def law_in(
    path: str | Path, made: Callable[[dict[str, Any]], T], read: Callable[[Path], dict[str, Any]] = read_table
) -> T:
    """What is ``made`` of the table in a law's file, as it is ``read``.

    Raises:
        InputError: which names the file too.
    """
    table = read(Path(path))
    try:
        return made(table)
    except InputError as error:
        raise InputError(f"control.file = {str(path)!r}: {error}") from error
