"""Which reader takes a file: by the ending of its name, else by how it begins."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ehamj.records.channel import Record
from ehamj.records.choices import Choices
from ehamj.records.esm import looks_esm, read_esm
from ehamj.records.files import named_by
from ehamj.records.ide import read_ide
from ehamj.records.matlab import read_matlab
from ehamj.records.peer import looks_peer, read_peer
from ehamj.records.seismic import read_seismic
from ehamj.records.tables import looks_like_table, read_table_record
from ehamj.records.tdms import read_tdms
from ehamj.records.uff import read_uff
from ehamj.records.wav import read_wav
from ehamj.registry import Registry


@dataclass(frozen=True)
class Reader:
    """Reads the files of one format.

    ``looks`` tells by a file's first `HEAD` bytes whether it is of that format, for files whose ending says nothing.
    """

    title: str
    read: Callable[[Path, Choices], Record]
    endings: tuple[str, ...] = ()
    looks: Callable[[bytes], bool] | None = None
    uses: frozenset[str] = frozenset()
    """Keys of the user's choices that this reader understands, and not every other does."""


HEAD = 4096
"""Bytes of a file by which its format is told."""

READERS: Registry[Reader] = Registry("reader")
READERS.add("uff", Reader("universal file", read_uff, (".uff", ".unv")))
READERS.add("matlab", Reader("MATLAB file", read_matlab, (".mat",)))
READERS.add("tdms", Reader("TDMS file", read_tdms, (".tdms",)))
READERS.add("ide", Reader("IDE file", read_ide, (".ide",)))
READERS.add("peer", Reader("record of the PEER database", read_peer, (".at2", ".vt2", ".dt2"), looks_peer))
READERS.add("esm", Reader("record of the ESM or ITACA database", read_esm, looks=looks_esm))
READERS.add("wav", Reader("WAV file", read_wav, (".wav",)))
TABLES = (".csv", ".tsv", ".tab", ".prn")
"""Endings of names that only tables have; others are tables by how they begin."""
READERS.add("table", Reader("text table", read_table_record, TABLES, looks_like_table, frozenset(("table", "damaged"))))
SEISMIC = frozenset(("inventory", "response", "overlap", "damaged"))
"""Keys for counts of an instrument, and for traces in pieces."""
READERS.add("seismic", Reader("record in a seismic format", read_seismic, uses=SEISMIC))


def reader_of(path: Path) -> Reader:
    """The reader of a file; the last one, of seismic formats, takes what no other does."""
    ending = path.suffix.lower()
    found = next((reader for reader in READERS.values() if ending in reader.endings), None)
    files = named_by(path)
    if found is None and files:
        with files[0].open("rb") as file:
            head = file.read(HEAD)
        found = next((reader for reader in READERS.values() if reader.looks is not None and reader.looks(head)), None)
    return found or READERS["seismic"]


def check_used(path: Path, reader: Reader, choices: Choices) -> None:
    """Raise ValueError, naming the key, where the user chooses what the file's reader does not understand."""
    for key in sorted(set().union(*(one.uses for one in READERS.values())) - reader.uses):
        value = getattr(choices, key)
        if value != Choices.model_fields[key].default:
            told = f"ground.{key}" + (f" = {Path(value).name!r}" if isinstance(value, str) else "")
            users = " or a ".join(one.title for one in READERS.values() if key in one.uses)
            raise ValueError(
                f"{told} is of use with a {users} only, and {path.name!r} is a {reader.title}; leave it out"
            )
