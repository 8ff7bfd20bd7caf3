"""What a MATLAB file of any version holds, as structs, lists, texts and numbers; nothing in it is ever run."""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from ehamj.plain.hdf5 import LARGEST as LARGEST_HDF5
from ehamj.plain.hdf5 import check_hdf5
from ehamj.records.files import existing, reading
from ehamj.records.matlab5 import HEADER, LARGEST, variables
from ehamj.records.matlab73 import Hdf5
from ehamj.records.matlab_values import Numbers, Opaque, Value

VERSION4 = ("f8", "f4", "i4", "i2", "u2", "u1")
"""Numbers of version 4, by the digit that tells them."""

HDF5 = b"\x89HDF\r\n\x1a\n"

OCTAVE = (b"# Created by Octave", b"Octave-1-")
"""How files begin that Octave saves in forms of its own, as text and binary."""
IN_OCTAVE = "it is in a form of Octave's own, not MATLAB's; save it in Octave with save('-v7', 'name.mat', 'variable')"


@contextmanager
def opened(path: Path, key: str = "ground.file", most: int | None = None) -> Iterator[dict[str, Value]]:
    """The file's variables.

    Args:
        path: of the file.
        key: that messages name.
        most: bytes that it may have, and unfold to; without, as many as records may.

    Raises:
        ValueError: where it cannot be read, or holds what MATLAB never writes.
    """
    existing(path, key)
    if most is not None and path.stat().st_size > most:
        raise ValueError(f"{key} = {path.name!r}: has {path.stat().st_size} bytes, {most} are allowed")
    with path.open("rb") as file:
        head = file.read(1024)
    if head.startswith(OCTAVE):
        with reading(path, " as a MATLAB file", key):
            raise ValueError(IN_OCTAVE)
    if head[:10] == b"MATLAB 7.3" or HDF5 in head:
        import h5py

        with reading(path, " as a MATLAB file", key):
            check_hdf5(path, most or LARGEST_HDF5)
            content = h5py.File(path, "r")
        with content:
            with reading(path, " as a MATLAB file", key):
                if any("OCTAVE_NEW_FORMAT" in item.attrs for item in content.values()):
                    raise ValueError(IN_OCTAVE)
                tree = Hdf5(path, content).variables()
            yield tree
        return
    with reading(path, " as a MATLAB file", key):
        known = len(head) >= HEADER and head[126:128] in (b"IM", b"MI")
        content = path.read_bytes()
        tree = variables(content, most or LARGEST) if known else _version4(content)
    yield tree


def _version4(content: bytes) -> dict[str, Value]:
    """Variables of a file of version 4: five whole numbers, a name and the values of each."""
    found: dict[str, Value] = {}
    at = 0
    while at + 20 <= len(content):
        order = next((o for o in "<>" if 0 <= struct.unpack_from(f"{o}i", content, at)[0] < 5000), "<")
        kind, rows, columns, imaginary, length = struct.unpack_from(f"{order}5i", content, at)
        thousands, numbers, text = kind // 1000, kind // 10 % 10, kind % 10
        if (
            thousands not in (0, 1)
            or kind // 100 % 10
            or numbers >= len(VERSION4)
            or text > 2
            or imaginary not in (0, 1)
        ):
            raise ValueError("it is no MATLAB file, or a damaged one")
        stored = np.dtype(order + VERSION4[numbers])
        count, start = rows * columns, at + 20 + length
        at = start + count * (1 + imaginary) * stored.itemsize
        if min(rows, columns, length) < 0 or at > len(content):
            raise ValueError(
                f"it is truncated or damaged: {rows} × {columns} numbers are stated, {len(content)} bytes held"
            )
        name = content[start - length : start].rstrip(b"\0").decode("latin-1")
        values = np.frombuffer(content, stored, count, start)
        if text == 0 and count:
            found[name] = Numbers((rows, columns), partial(values.reshape, (rows, columns), order="F"), bool(imaginary))
        elif text == 1:
            found[name] = "".join(chr(int(code) & 0xFFFF) for code in values)
        elif text == 2:
            found[name] = Opaque("sparse matrix of version 4")
    if not found:
        raise ValueError("it is no MATLAB file, or an empty one")
    return found
