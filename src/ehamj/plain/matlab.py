"""MATLAB files of bounded size: what is compressed in them is unfolded once, and counted, before it is kept."""

import zlib
from pathlib import Path
from typing import BinaryIO

from ehamj.plain.hdf5 import LARGEST, check_hdf5

COMPRESSED = 15
"""Type of an element that is compressed (MathWorks, *MAT-File Format*, 2023, table 1-1)."""
CHUNK = 2**20


def check_matlab(path: Path) -> None:
    """Raise ValueError where a MATLAB file unfolds to more than `LARGEST`, or draws in other files (HDF5)."""
    with path.open("rb") as file:
        head = file.read(128)
        if len(head) == 128 and head[125 if head[126:] == b"IM" else 124] == 2:
            return check_hdf5(path)
        if 0 in head[:4] or len(head) < 128:
            return None  # version 4 has nothing compressed
        order = "little" if head[126:] == b"IM" else "big"
        room = LARGEST
        while len(tag := file.read(8)) == 8:
            kind, size = (int.from_bytes(part, order) for part in (tag[:4], tag[4:]))  # type: ignore[arg-type]
            if kind == COMPRESSED:
                room -= _unfolded(file, size, room)
            else:
                file.seek(size, 1)
    return None


def _unfolded(file: BinaryIO, size: int, room: int) -> int:
    """Bytes that the next ``size`` bytes unfold to; raises ValueError where they are more than ``room``."""
    inflate, left, found = zlib.decompressobj(), size, 0
    while left > 0 and (chunk := file.read(min(CHUNK, left))):
        left -= len(chunk)
        while chunk:
            try:
                found += len(inflate.decompress(chunk, CHUNK))
            except zlib.error as error:
                raise ValueError(f"it is damaged: {error}") from None
            if found > room:
                raise ValueError(f"its variables unfold to more than {LARGEST / 2**30:g} GiB; cut it into parts")
            chunk = inflate.unconsumed_tail
    return found
