"""What variables of a MATLAB file are to the readers: structs, lists, texts, numbers, and what cannot be read."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MOST = 2**28
"""Numbers that one variable may hold: 2 GB, an hour of eight channels at 9 kHz."""

MOST_PARTS = 10_000
"""Variables, fields and cells that one file may hold."""

DEEPEST = 20
"""Structs within structs that are followed."""


@dataclass(frozen=True)
class Numbers:
    """An array of numbers, read when it is asked for; complex ones are not. Logical ones are 0 and 1."""

    shape: tuple[int, ...]
    read: Callable[[], np.ndarray] = field(repr=False)
    complex: bool = False
    logical: bool = False


@dataclass(frozen=True)
class Opaque:
    """What only MATLAB can read: objects, functions, tables."""

    kind: str


Value = dict[str, Any] | list[Any] | str | Numbers | Opaque
"""A struct, a struct array or cell array, a text, numbers, or what cannot be read; structs and lists hold values."""


def check_size(name: str, shape: Any, most: int = MOST) -> None:
    """Raise ValueError where an array would be larger than ``most``."""
    size = float(np.prod([float(n) for n in shape]))
    if not 0 <= size <= most:
        raise ValueError(f"{name} states {size:.3g} numbers; {most:.3g} are allowed; cut the record")


def dense(matrix: Any, name: str) -> np.ndarray:
    """A sparse matrix in full, after a look at its indices, which the compiled code trusts."""
    check_size(name, matrix.shape)
    try:
        matrix.check_format(full_check=True)
    except ValueError as error:
        raise ValueError(f"ground.file: the sparse matrix {name} is damaged: {error}") from None
    return np.asarray(matrix.toarray())
