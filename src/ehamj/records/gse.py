"""GSE1 and GSE2, headers by ObsPy and samples by a decoder of our own.

ObsPy's decoder, in C, writes beyond its memory where a file is damaged. The format is that of the Group of Scientific
Experts (*Conference Room Paper 243*, 1995), compression CM6: differences of second order, each of one or more
characters of six bits; the first has a bit that another follows, a sign and four bits, the others that bit and five.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from obspy import Stream

ALPHABET = b"+-0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
MORE, MINUS = 0x20, 0x10
MOST_CHARACTERS = 7
"""Of a sample: 4 + 6·5 bits hold more than 32."""
MODULO = 100_000_000
"""Of the checksum."""

_CODES = np.full(256, -1, np.int64)
_CODES[list(ALPHABET)] = np.arange(64)


def read_gse(path: str, version: int) -> "Stream":
    """The traces of a file of GSE ``version`` 1 or 2.

    Raises:
        ValueError: where samples are not what header and checksum say.
    """
    from obspy import Stream, Trace
    from obspy.io.gse2 import libgse1, libgse2

    library = libgse1 if version == 1 else libgse2
    stream = Stream()
    with Path(path).open("rb") as file:
        while True:
            try:
                header = library.read_header(file)
            except EOFError:
                return stream
            kind, count = header[f"gse{version}"]["datatype"], header["npts"]
            text, checksum = _data(file, version)
            if kind in ("CM6", "CMP6"):
                samples = cm6(text)
            elif kind in ("INT", "INTV"):
                samples = np.array(text.split(), np.int64)
            else:
                raise ValueError(f"its samples are stored as {kind!r}; CM6 and INT are read")
            if samples.size != count:
                raise ValueError(f"{count} samples are announced, {samples.size} follow")
            if abs(checksum) != _checksum(samples):  # some writers keep the sign, which the format drops
                raise ValueError(f"its checksum is {checksum}, its samples make {_checksum(samples)}")
            stream.append(Trace(samples.astype(np.int32), header))


def cm6(text: bytes) -> NDArray[np.int64]:
    """The samples of compressed characters, shape (n,); raises ValueError where they are damaged."""
    codes = _CODES[np.frombuffer(b"".join(text.split()), np.uint8)]
    if codes.size == 0:
        return np.empty(0, np.int64)
    last = (codes & MORE) == 0
    if (codes < 0).any() or not last[-1]:
        raise ValueError("its compressed samples are damaged")
    ends = np.flatnonzero(last)
    begins = np.concatenate([[0], ends[:-1] + 1])
    if (ends - begins).max() >= MOST_CHARACTERS:
        raise ValueError("its compressed samples are damaged")
    first = np.zeros(codes.size, bool)
    first[begins] = True
    behind = np.repeat(ends, ends - begins + 1) - np.arange(codes.size)
    parts = np.where(first, codes & 0x0F, codes & 0x1F) << (5 * behind)
    sign = np.where(codes[begins] & MINUS, -1, 1)
    differences = sign * np.add.reduceat(parts, begins)
    # As 32 bits wrap around, which sums of more bits would not.
    return np.cumsum(np.cumsum(differences)).astype(np.int32).astype(np.int64)


def _data(file: BinaryIO, version: int) -> tuple[bytes, int]:
    """The characters between the heading of the data and their checksum, and that."""
    mark, end = f"DAT{version}".encode(), re.compile(rf"CHK{version}\s+(-?\d{{1,18}})\s*".encode())
    for line in file:
        if line.startswith(mark):
            break
    lines: list[bytes] = []
    for line in file:
        if (found := end.fullmatch(line)) is not None:  # compressed samples may begin with the same letters
            return b" ".join(lines), int(found[1])
        lines.append(line)
    raise ValueError("it breaks off before the checksum of its samples")


def _checksum(samples: NDArray[np.int64]) -> int:
    """The sum of the samples, each and all within ± 10⁸."""
    found = 0
    for value in np.fmod(samples, MODULO).tolist():
        found += value
        if abs(found) >= MODULO:
            found -= int(found / MODULO) * MODULO
    return abs(found)
