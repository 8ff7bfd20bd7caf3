"""Where finished designs are kept: one SQLite file in the study's folder, a row for each design.

SQLite, since a block of designs is there whole or not at all however the process ends, a number cannot be there twice,
and nothing else is needed to write it; pandas, xarray (`ehamj.campaign.tables`) and any language open it. With parts in
Parquet each of these would be ours to see to. A rollback journal that is synchronised in full survives a power failure
as well, and leaves one file. The table is wide, one column for each value and merit, named by it:
``pandas.read_sql("select * from designs", sqlite3.connect("designs.sqlite"))``.
"""

import errno
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.held import held, myself
from ehamj.campaign.rows import Column, Row
from ehamj.errors import InputError
from ehamj.merits.merit import Failed

STORE_FILE: Final = "designs.sqlite"
FORMAT: Final = 0x65_68_61_01
"""What the file says of itself (``PRAGMA application_id``): "eha", and the version of its layout."""
FIXED: Final = ("number", "stage", "parent", "status", "reason", "seconds")
"""Columns that every store has."""
MOST: Final = 1990
"""Values and merits that a row may have; SQLite takes 2000 columns."""
PATIENCE: Final = 60.0
"""How long a block waits for those who read [s]."""
WORDS: Final = ("true", "false", "null")
_LAYOUT: Final = """
CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE columns (place INTEGER PRIMARY KEY, name TEXT NOT NULL, role TEXT NOT NULL, unit TEXT NOT NULL,
    text TEXT NOT NULL, label TEXT NOT NULL);
CREATE TABLE designs (number INTEGER PRIMARY KEY, stage TEXT NOT NULL, parent INTEGER,
    status TEXT NOT NULL CHECK (status IN ('done', 'failed')), reason TEXT, seconds REAL NOT NULL{columns});
"""


class Store:
    """A study's finished designs, by number. Made by `create` and `opened`, which close it."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        found = connection.execute("SELECT name, role, unit, text, label FROM columns ORDER BY place").fetchall()
        self.columns: tuple[Column, ...] = tuple(Column(name, unit, role, text) for name, role, unit, text, _ in found)
        """Values, then merits."""
        self.labels: Mapping[str, str] = {name: label for name, *_, label in found}
        """What the table calls each of them: its name, unless another one differs from it in capitals only."""
        marks = ", ".join("?" * (len(FIXED) + len(found)))
        names = ", ".join(_quoted(name) for name in (*FIXED, *self.labels.values()))
        self._insert = f"INSERT INTO designs ({names}) VALUES ({marks})"

    def said(self, key: str) -> Any:
        """What the store says of its study under a key; None if nothing."""
        found = self._connection.execute("SELECT value FROM study WHERE key = ?", (key,)).fetchone()
        return None if found is None else json.loads(found[0])

    def execute(self, query: str, given: Sequence[Any] = ()) -> sqlite3.Cursor:
        """Ask the file itself."""
        with told(self.path):
            return self._connection.execute(query, given)

    def say(self, **said: Any) -> None:
        """Keep plain data of the study by keys, at once."""
        with self._whole():
            entries = [(key, json.dumps(value)) for key, value in said.items()]
            self._connection.executemany("INSERT OR REPLACE INTO study VALUES (?, ?)", entries)

    def append(self, rows: Sequence[Row]) -> None:
        """Keep rows, all of them or, whatever happens, none.

        Raises:
            OSError: if they cannot be written; what was there stays.
            ValueError: if one is there already.
        """
        try:
            with self._whole():
                self._connection.executemany(self._insert, (self._cells(row) for row in rows))
        except sqlite3.IntegrityError as error:
            raise ValueError(f"{self.path}: designs {rows[0].number} to {rows[-1].number}: {error}") from error

    def count(self, first: int = 0, stop: int | None = None, failed: bool = False) -> int:
        """How many of the designs from ``first`` up to ``stop`` are there, or have failed."""
        failures = " AND status = 'failed'" if failed else ""
        last = -1 if stop is None else stop
        query = f"SELECT count(*) FROM designs WHERE number >= ? AND (? < 0 OR number < ?){failures}"
        return int(self._connection.execute(query, (first, last, last)).fetchone()[0])

    def numbers(self, stage: str) -> range:
        """Numbers of a stage's designs, which follow one another."""
        query = "SELECT min(number), max(number) + 1 FROM designs WHERE stage = ?"
        first, stop = self._connection.execute(query, (stage,)).fetchone()
        return range(0) if first is None else range(first, stop)

    def merits(self, first: int, stop: int, names: Sequence[str]) -> Array:
        """Merits (design, name) of the designs from ``first`` up to ``stop``, all there; NaN of those that failed."""
        cells = ", ".join(["status", *(_quoted(self.labels[name]) for name in names)])
        query = f"SELECT {cells} FROM designs WHERE number >= ? AND number < ? ORDER BY number"
        found = np.full((stop - first, len(names)), np.nan)
        for at, (status, *merits) in enumerate(self._connection.execute(query, (first, stop))):
            if status == "done":
                found[at] = [np.nan if merit is None else merit for merit in merits]
        return found

    def rows(self, first: int = 0, stop: int | None = None) -> Iterator[Row]:
        """Rows of the designs from ``first`` up to ``stop`` that are there, by number, one after the other."""
        names = ", ".join(_quoted(name) for name in (*FIXED, *self.labels.values()))
        query = f"SELECT {names} FROM designs WHERE number >= ? AND number < ? ORDER BY number"
        for cells in self._connection.execute(query, (first, 2**62 if stop is None else stop)):
            number, stage, parent, status, reason, seconds = cells[: len(FIXED)]
            of = {"value": dict[str, Any](), "merit": dict[str, Any]()}
            for column, cell in zip(self.columns, cells[len(FIXED) :], strict=True):
                if cell is not None:
                    of[column.role][column.name] = value_of(cell)
            failed = Failed(reason) if status == "failed" else None
            yield Row(number, stage, parent, of["value"], of["merit"], failed, seconds)

    def _cells(self, row: Row) -> tuple[Any, ...]:
        unknown = (row.values.keys() | row.merits.keys()) - self.labels.keys()
        if unknown:
            raise ValueError(f"{self.path}: design {row.number} has {sorted(unknown)}, for which there is no column")
        of = {"value": row.values, "merit": row.merits}
        own = (of[column.role].get(column.name) for column in self.columns)
        reason = None if row.failed is None else row.failed.reason
        status = "done" if row.failed is None else "failed"
        return (row.number, row.stage, row.parent, status, reason, row.seconds, *(cell_of(value) for value in own))

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """One transaction."""
        with told(self.path):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:  # SQLite has ended it itself where the disk is full
                    self._connection.execute("ROLLBACK")
                raise


@contextmanager
def writing(folder: Path, columns: Sequence[Column], about: Mapping[str, Any]) -> Iterator[tuple[Store, bool]]:
    """The store in a folder, to be written to by this process alone, and whether it was there before.

    Args:
        folder: of the study; made where it is not there.
        columns: what rows have, for a store that is made.
        about: what a new store says of its study, plain data by key.

    Raises:
        InputError: if another process writes to it, or the file is no store.
        OSError: if it cannot be written.
    """
    check_columns(columns)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / STORE_FILE
    with held(folder, lambda: holder(folder)), closing(_connected(path)) as connection:
        with told(path):
            there = _is_store(path, connection)
            if not there:
                _make(connection, columns, about)
        store = Store(path, connection)
        store.say(holder=myself())
        yield store, there


@contextmanager
def reading(folder: Path) -> Iterator[Store]:
    """The store in a folder, to be read; a study may be at work on it.

    Raises:
        InputError: if there is none.
    """
    path = folder / STORE_FILE
    if not path.is_file():
        raise InputError(f"study {str(folder)!r}: holds no {STORE_FILE}")
    with closing(_connected(path)) as connection:
        with told(path):
            if not _is_store(path, connection):
                raise InputError(f"study {str(folder)!r}: {STORE_FILE} is empty; no study has begun there")
        yield Store(path, connection)


def holder(folder: Path) -> str:
    """Who holds the store in a folder, in words."""
    try:
        with reading(folder) as store:
            return str(store.said("holder") or "another study")
    except InputError:  # it has only begun
        return "another study"


def check_columns(columns: Sequence[Column]) -> None:
    """Refuse columns that no row can have.

    Raises:
        InputError: if there are too many, or two of one name.
    """
    names = [column.name for column in columns]
    twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
    if twice:
        raise InputError(f"{twice!r}: is both a parameter and a figure of merit; name the function otherwise")
    if len(columns) > MOST:
        raise InputError(
            f"{len(columns)} parameters and merits: a study may have {MOST} together; ask for fewer merits"
        )


def cell_of(value: Any) -> Any:
    """What stands in the file for a value: itself where it is a number or a word, else JSON."""
    if isinstance(value, str):
        return json.dumps(value) if value[:1] in ("[", "{", '"') or value in WORDS else value
    if value is None:
        return None
    if isinstance(value, bool | list | tuple | Mapping):
        return json.dumps(value)
    return int(value) if isinstance(value, int | np.integer) else float(value)


def value_of(cell: Any) -> Any:
    """The value that a cell stands for."""
    said = isinstance(cell, str) and (cell[:1] in ("[", "{", '"') or cell in WORDS)
    return json.loads(cell) if said else cell


@contextmanager
def told(path: Path) -> Iterator[None]:
    """What SQLite answers, said as the system's own errors are, with the file.

    Raises:
        OSError: if the file cannot be read or written.
        InputError: if it is damaged.
    """
    try:
        yield
    except sqlite3.IntegrityError:
        raise
    except sqlite3.DatabaseError as error:
        code = (getattr(error, "sqlite_errorcode", None) or 0) & 0xFF
        if code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
            raise InputError(f"{str(path)!r}: is damaged, or no store of designs ({error})") from error
        if code == sqlite3.SQLITE_FULL:
            raise OSError(errno.ENOSPC, "no space is left; finished designs are kept", str(path)) from error
        if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN):
            raise OSError(errno.EACCES, f"cannot be written ({error})", str(path)) from error
        if code == sqlite3.SQLITE_BUSY:
            said = f"cannot be written, since another program has read it for {PATIENCE:g} s; finished designs are kept"
            raise OSError(errno.EACCES, said, str(path)) from error
        if code == sqlite3.SQLITE_IOERR:
            raise OSError(errno.EIO, f"cannot be written ({error}); finished designs are kept", str(path)) from error
        raise


def _connected(path: Path) -> sqlite3.Connection:
    with told(path):
        connection = sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.execute("PRAGMA synchronous = FULL")
        return connection


def _is_store(path: Path, connection: sqlite3.Connection) -> bool:
    """Whether a file is a store; an empty one is one that is not made yet."""
    found = connection.execute("PRAGMA application_id").fetchone()[0]
    if found != FORMAT and connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
        raise InputError(f"{str(path)!r}: is no store of designs that this version of ehamj reads; name another folder")
    return bool(found == FORMAT)


def _make(connection: sqlite3.Connection, columns: Sequence[Column], about: Mapping[str, Any]) -> None:
    """Make the tables, all of them or none."""
    taken, labels = set(FIXED), list[str]()
    for column in columns:
        label = next(
            f"{column.name}{more}" for more in ("", *_numbered()) if f"{column.name}{more}".lower() not in taken
        )
        taken.add(label.lower())
        labels.append(label)
    kinds = ("" if column.role == "value" else " REAL" for column in columns)
    cells = "".join(f", {_quoted(label)}{kind}" for label, kind in zip(labels, kinds, strict=True))
    connection.execute("BEGIN IMMEDIATE")
    try:
        for statement in _LAYOUT.format(columns=cells).split(";\n"):
            connection.execute(statement)
        table = [
            (at, one.name, one.role, one.unit, one.text, label)
            for at, (one, label) in enumerate(zip(columns, labels, strict=True))
        ]
        connection.executemany("INSERT INTO columns VALUES (?, ?, ?, ?, ?, ?)", table)
        connection.executemany(
            "INSERT INTO study VALUES (?, ?)", [(key, json.dumps(one)) for key, one in about.items()]
        )
        connection.execute(f"PRAGMA application_id = {FORMAT}")
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _numbered() -> Iterator[str]:
    return (f"#{number}" for number in range(2, MOST + 2))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
