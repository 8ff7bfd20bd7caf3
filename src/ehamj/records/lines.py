"""Bytes of a text file to lines: byte order marks, encodings, ends of lines; what is binary is no text."""

import codecs
import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
"""Byte order marks; those of UTF-32 before those of UTF-16, with which they begin."""

CONTROL = re.compile("[\x00-\x08\x0e-\x1f]")
PLAIN = str.maketrans({"−": "-", "\xa0": " ", "\u202f": " ", "\u2009": " ", "\ufeff": "", "\x0b": " ", "\x0c": " "})
"""Typographers' minus, spaces that do not break, and marks within the text."""


class Text(NamedTuple):
    """Lines of a file as an editor numbers them (from 1), how they were encoded, and whether the last one ends."""

    lines: list[str]
    encoding: str
    ended: bool


def lines_of(path: Path, key: str, encoding: str | None = None) -> Text:
    """The lines of a text file.

    Without ``encoding`` a byte order mark says it, else what does not decode as UTF-8 is Windows' Western European
    (latin-1 but for typographers' marks). Raises ValueError, naming ``key``, where it cannot be read or is binary.
    """
    told = f"{key} = {path.name!r}"
    if path.exists() and not path.is_file():  # a pipe or a device may never end
        raise ValueError(f"{told} is no file ({path})")
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{told} cannot be read: {error.strerror} ({path})") from error
    found, text = _decoded(raw, told, encoding)
    text = text.removesuffix("\x1a").translate(PLAIN) if not text.isascii() else text.removesuffix("\x1a")
    control = CONTROL.search(text)
    if control:
        line = text.count("\n", 0, control.start()) + 1
        raise ValueError(
            f"{told} is no text: it holds the control character {ord(control[0]):#04x} in line {line}; it is binary, "
            "or damaged"
        )
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    ended = not lines[-1].strip()
    return Text(lines[:-1] if ended else lines, found, ended)


def encoding_of(raw: bytes) -> tuple[str, int]:
    """The encoding of a text by its beginning, and the length of its byte order mark."""
    for mark, name in MARKS:
        if raw.startswith(mark):
            return name, len(mark)
    for name, high in (("utf-16-le", raw[1:400:2]), ("utf-16-be", raw[0:400:2])):
        if high.count(0) > 0.9 * len(high) > 0:
            return name, 0
    with suppress(ValueError):
        codecs.getincrementaldecoder("utf-8")().decode(raw)
        return "utf-8", 0
    with suppress(ValueError):
        if any(0x80 <= byte < 0xA0 for byte in set(raw)):  # typographers' marks, which latin-1 does not have
            raw.decode("cp1252")
            return "cp1252", 0
    return "latin-1", 0


def _decoded(raw: bytes, told: str, encoding: str | None) -> tuple[str, str]:
    """Name of the encoding, and the text."""
    name, mark = encoding_of(raw) if encoding is None else (encoding, 0)
    try:
        return name, raw[mark:].decode(name).removeprefix("\ufeff")
    except ValueError as error:
        if encoding is not None:
            raise ValueError(f"{told} is not in the encoding {encoding!r} that is stated: {error}") from error
        raise ValueError(f"{told} begins as {name} and breaks it: {error}; it may be truncated") from error
