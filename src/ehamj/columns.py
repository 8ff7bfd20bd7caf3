"""Samples over time, of which a column or some rows are read when they are asked for.

What a long run holds is on disk. Whoever reads it takes one column after the other, or rows block by block, so that
memory is that of a few columns, however many there are. In memory and on disk the same is read in the same pieces,
and what comes out is the same to the bit.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from typing import Any, Final, Protocol

import numpy as np

from ehamj.arrays import Array

ROWS: Final = 2**15
"""Rows of a block: a column of them is 256 KiB, which a disk reads as fast as any more, and all columns of a wide
machine's rows take some hundred megabytes."""


class Samples(Protocol):
    """What is read by columns: an array, a channel of a result, or what is made of such on the way (`Made`)."""

    @property
    def shape(self) -> tuple[int, ...]:
        """(time, …)."""

    def __getitem__(self, key: Any, /) -> Any:
        """Some of it."""


@dataclass(frozen=True, eq=False)
class Made:
    """Columns (time, n) that are made of other samples, a block of rows at a time, each time that one is asked for."""

    shape: tuple[int, int]
    rows: Callable[[slice], Array]
    """Some rows of all columns."""

    def __getitem__(self, key: tuple[slice, int]) -> Array:
        """One column; ``key`` is all of the time, and which."""
        found = np.empty(self.shape[0])
        for rows in blocks(self.shape[0]):
            found[rows] = self.rows(rows)[:, key[1]]
        return found

    @cached_property
    def known_by(self) -> bytes:
        """See `fingerprint`."""
        found = blake2b()
        for rows in blocks(self.shape[0]):
            found.update(np.ascontiguousarray(self.rows(rows)).data)
        return found.digest()


@dataclass(frozen=True, eq=False)
class Picked:
    """Some columns of samples, (time, n)."""

    samples: Samples
    at: Sequence[tuple[int, ...]]

    @property
    def shape(self) -> tuple[int, int]:
        """(time, n)."""
        return self.samples.shape[0], len(self.at)

    def __getitem__(self, key: tuple[slice, int]) -> Array:
        """One column; ``key`` is all of the time, and which."""
        return column(self.samples, *self.at[key[1]])


def blocks(count: int) -> Iterator[slice]:
    """So many rows, block by block."""
    for first in range(0, count, ROWS):
        yield slice(first, min(first + ROWS, count))


def column(samples: Samples, *at: int) -> Array:
    """One column, (time,), contiguous."""
    return np.ascontiguousarray(np.asarray(samples[(slice(None), *at)]), float)


def places(samples: Samples) -> Iterator[tuple[int, ...]]:
    """Where columns stand, in order."""
    return np.ndindex(samples.shape[1:])


def columns(samples: Samples) -> Iterator[Array]:
    """One column after the other."""
    return (column(samples, *at) for at in places(samples))


def of_each(samples: Samples, compute: Callable[[Array], Any]) -> Array:
    """A number of each column, shaped as the columns are."""
    return np.array([compute(one) for one in columns(samples)], float).reshape(samples.shape[1:])


def peaks(samples: Samples) -> Array:
    """Largest absolute value of each column, shaped as the columns are; NaN where one has it."""
    return of_each(samples, lambda one: np.abs(one).max())


def finite(samples: Samples) -> bool:
    """Whether all of it is finite."""
    return all(bool(np.isfinite(one).all()) for one in columns(samples))


def fingerprint(samples: Samples) -> tuple[tuple[int, ...], bytes]:
    """Shape of samples, and what they are told by."""
    return samples.shape, samples.known_by if isinstance(samples, Made) else _known_by(samples)


def _known_by(samples: Samples) -> bytes:
    if samples.shape[0] <= ROWS and not isinstance(samples, Picked):
        return digest(np.asarray(samples[:]))
    return blake2b(b"".join(map(digest, columns(samples)))).digest()


def digest(values: Array) -> bytes:
    """What an array of that shape is told by."""
    return blake2b(np.ascontiguousarray(values).data).digest()
