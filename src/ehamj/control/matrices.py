"""The matrices of laws in memory: full, or row by row what is not zero of laws that are made of blocks."""

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control.compiled.laws import Laws

FULL: Final = 0.3
"""Share of numbers that are not zero above which whole columns are added faster than single numbers (measured)."""

Integers = NDArray[np.int64]


class Matrices:
    """The matrices of several laws, one after the other: A, B, C, D and perhaps anti-windup of each."""

    def __init__(self) -> None:
        self._values: list[Array] = [np.zeros(0)]
        self._columns: list[Integers] = [np.zeros(0, np.int64)]
        self._rows: list[Integers] = [np.zeros(0, np.int64)]
        self._size = self._row_count = 0

    def put(self, law: Any, own: Sequence[Array]) -> None:
        """Append a law's matrices, in the form that is faster for one machine alone."""
        filled = sum(np.count_nonzero(matrix) for matrix in own)
        if filled < FULL * sum(matrix.size for matrix in own):
            self.put_rows(law, own, (matrix != 0.0 for matrix in own))
        else:
            self._put_full(law, own)

    def _put_full(self, law: Any, own: Sequence[Array]) -> None:
        law["matrices"], law["rows"], law["windup"] = self._size, -1, -1
        if len(own) > 4:
            law["windup"] = self._size + sum(matrix.size for matrix in own[:4])
        for matrix in own:
            self._append(matrix.T.ravel(), np.zeros(matrix.size, np.int64))

    def put_rows(self, law: Any, own: Sequence[Array], where: Iterable[NDArray[np.bool_]]) -> None:
        """Append a law's matrices row by row, of each what stands ``where``."""
        law["matrices"], law["rows"], law["windup"] = self._size, self._row_count, -1
        for number, (matrix, there) in enumerate(zip(own, where, strict=True)):
            if number == 4:
                law["windup"] = self._row_count
            counts = np.concatenate([[0], np.cumsum(there.sum(axis=1))]).astype(np.int64)
            self._rows.append(self._size + counts)
            self._row_count += counts.size
            self._append(matrix[there], np.nonzero(there)[1].astype(np.int64))

    def _append(self, values: Array, columns: Integers) -> None:
        self._values.append(np.asarray(values, np.float64))
        self._columns.append(columns)
        self._size += values.size

    @property
    def tables(self) -> tuple[Array, Integers, Integers]:
        """Numbers, where rows begin, and columns: fields of `Laws`."""
        return np.concatenate(self._values), np.concatenate(self._rows), np.concatenate(self._columns)


def by_rows(laws: Laws) -> Laws:
    """The same laws with all matrices row by row, zeros of full ones too: what serves several machines side by side."""
    if bool((laws.table["rows"] >= 0).all()):
        return laws
    matrices, table, valves = Matrices(), laws.table.copy(), laws.ranges.size
    for law in table:
        n, p = int(law["states"]), int(law["inputs"])
        shapes = [(n, n), (n, p), (valves, n), (valves, p), *([(n, valves)] if law["windup"] >= 0 else [])]
        if law["rows"] < 0:
            parts = np.split(
                laws.matrices[law["matrices"] :][: sum(rows * columns for rows, columns in shapes)],
                np.cumsum([rows * columns for rows, columns in shapes])[:-1],
            )
            own = [part.reshape(columns, rows).T for part, (rows, columns) in zip(parts, shapes, strict=True)]
            matrices.put_rows(law, own, (np.ones(shape, bool) for shape in shapes))
        else:
            kept = list(_rows_of(laws, int(law["rows"]), shapes))
            matrices.put_rows(law, [matrix for matrix, _ in kept], [there for _, there in kept])
    values, rows, columns = matrices.tables
    return laws._replace(table=table, matrices=values, rows=rows, columns=columns)


def _rows_of(laws: Laws, at: int, shapes: Sequence[tuple[int, int]]) -> Iterable[tuple[Array, NDArray[np.bool_]]]:
    """The matrices of a law that are kept row by row, and where they hold a number."""
    for rows, columns in shapes:
        matrix, there = np.zeros((rows, columns)), np.zeros((rows, columns), bool)
        for row in range(rows):
            held = slice(int(laws.rows[at + row]), int(laws.rows[at + row + 1]))
            matrix[row, laws.columns[held]], there[row, laws.columns[held]] = laws.matrices[held], True
        yield matrix, there
        at += rows + 1
