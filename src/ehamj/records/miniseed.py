"""miniSEED record by record: whether each is whole, and what is left where some are not."""

import io
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from obspy import Stream, UTCDateTime

SHORTEST = 128
"""Least length of a miniSEED record [byte]; all are powers of two (FDSN, *SEED Reference Manual 2.4*)."""

LONGEST = 2**20
BEYOND = 2**21
"""How far a header can lead beyond a record [byte]: 2¹⁶ to its samples, and 2¹⁶ samples of 8 bytes; with room."""

SECOND_WAYS = 8
"""Into so many parts a run of records is cut where it cannot be read as one."""


@dataclass(frozen=True)
class Piece:
    """One record: its place in the file [byte], and what its header says, if it can be read."""

    begin: int
    end: int
    name: str = ""
    start: "UTCDateTime | None" = None


def check_whole(path: Path) -> None:
    """Raise ValueError where a file breaks off within a record; some that do go without a warning of ObsPy's."""
    from obspy.io.mseed.util import get_record_information

    offset, size = 0, path.stat().st_size
    while size % SHORTEST == 0 and offset < size:
        information = get_record_information(str(path), offset)
        length = information["record_length"]
        step = length * (1 if information["excess_bytes"] else information["number_of_records"])
        if step < SHORTEST:
            raise ValueError(f"its record at byte {offset} has no length")
        offset += step
    if size % SHORTEST or offset > size:
        raise ValueError("its last record is truncated")


def read_strictly(data: bytes) -> "Stream":
    """The traces of records; ObsPy's warnings of damage are raised, since it leaves out what it warns of.

    libmseed follows what a damaged header says beyond the end of what it was given; there it finds zeros of ours.
    """
    from obspy import Stream
    from obspy.io.mseed import InternalMSEEDWarning
    from obspy.io.mseed.core import _read_mseed

    guarded = np.zeros(len(data) + BEYOND, np.int8)
    guarded[: len(data)] = np.frombuffer(data, np.int8)
    with warnings.catch_warnings(), _unraisable() as lost:
        warnings.simplefilter("error", InternalMSEEDWarning)
        found = _read_mseed(guarded[: len(data)])
    if lost:  # ObsPy cannot decode what libmseed says of a record whose name is no text, and forgets it
        raise ValueError(f"a damaged record: {lost[0]}")
    return Stream(found.traces)


@contextmanager
def _unraisable() -> Iterator[list[str]]:
    """What goes wrong where Python cannot raise it, such as in calls back from C; else it is printed."""
    lost: list[str] = []
    before = sys.unraisablehook
    sys.unraisablehook = lambda what: lost.append(str(what.exc_value))
    try:
        yield lost
    finally:
        sys.unraisablehook = before


def read_skipping(path: Path) -> tuple["Stream", list[str]]:
    """The traces of a file without its damaged records, and a remark that names those.

    Raises ValueError where none is whole.
    """
    from obspy import Stream

    data = path.read_bytes()
    pieces = _pieces(data)
    bad: list[Piece] = []
    stream = Stream()
    runs = [pieces]
    while runs:
        run = runs.pop()
        try:
            if any(piece.start is None for piece in run):
                raise ValueError("no header")
            stream += read_strictly(b"".join(data[piece.begin : piece.end] for piece in run))
        except Exception:  # ObsPy raises what it likes
            if len(run) == 1:
                bad += run
                continue
            step = max(1, -(-len(run) // SECOND_WAYS))
            runs += [run[k : k + step] for k in range(0, len(run), step)]
    if not stream:
        raise ValueError("none of its records is whole")
    return stream, [_told(path.name, bad, len(pieces))] if bad else []


def _pieces(data: bytes) -> list[Piece]:
    """Places of the records: each by its own length, where its header can be read, else by that of the one before."""
    from obspy.io.mseed.util import get_record_information

    pieces, offset, length = [], 0, 0
    while offset < len(data):
        name, start = "", None
        try:
            information = get_record_information(io.BytesIO(data[offset : offset + LONGEST]))
            own = int(information["record_length"])
            head = data[offset : offset + 7]
            if not (head[:6].strip(b"0123456789 \0") == b"" and head[6:] in (b"D", b"R", b"Q", b"M")):
                raise ValueError("no sequence number and quality")
            if SHORTEST <= own <= LONGEST and offset + own <= len(data):
                length = own
                name = ".".join(str(information[key]) for key in ("network", "station", "location", "channel"))
                start = information["starttime"]
        except Exception:  # a header that cannot be read is what is looked for
            pass
        end = min(len(data), offset + (length or SHORTEST))
        pieces.append(Piece(offset, end, name, start))
        offset = end
    return pieces


def _told(label: str, bad: list[Piece], total: int) -> str:
    bad = sorted(bad, key=lambda piece: piece.begin)
    known = [piece for piece in bad if piece.start is not None]
    whose = ", ".join(sorted({piece.name for piece in known}))
    if known:
        times = sorted(str(piece.start) for piece in known)
        where = f" of {whose}, from {times[0]}" + (f" to {times[-1]}" if len(times) > 1 else "")
    else:
        where = ""
    nameless = f"; {len(bad) - len(known)} have no header that can be read" if len(known) < len(bad) else ""
    return (
        f"{label}: {len(bad)} damaged record{'s' if len(bad) > 1 else ''} of {total} left out{where} (bytes "
        f"{bad[0].begin} to {bad[-1].end}){nameless}"
    )
