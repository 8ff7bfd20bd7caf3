"""Files of records: which a path names, what goes wrong at them, and none is read further than it goes."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ehamj.plain.needs import check_memory
from ehamj.records.said import one_line


def existing(path: Path, key: str = "ground.file") -> Path:
    """The path; raises ValueError, naming ``key``, where there is no such file."""
    if not path.is_file():
        raise ValueError(f"{key} = {path.name!r}: there is no such file in {path.parent}")
    return path


def named_by(path: Path) -> list[Path]:
    """The files that ``path`` names, whose last part may hold wildcards, in the order of their names."""
    if path.is_file() or not set(path.name) & set("*?["):
        return [path] if path.is_file() else []
    return sorted(one for one in path.parent.glob(path.name) if one.is_file())


def matching(path: Path) -> list[Path]:
    """The files that ``path`` names, as `named_by`; raises ValueError where there is none."""
    return named_by(path) or [existing(path)]


SAMPLE_BYTES = 50
"""Memory that a sample takes from its file to the floor that it is [B]: detrended, transformed, splined."""


def check_samples(path: Path, samples: int) -> None:
    """Raise ValueError where so many samples need more memory than is free."""
    what = f"ground.file = {path.name!r}: of {samples:.3g} samples each component"
    check_memory(what, samples * SAMPLE_BYTES, "cut out of it what is needed")


@contextmanager
def reading(path: Path, how: str, key: str = "ground.file") -> Iterator[None]:
    """Turns whatever a library raises at a damaged file into a ValueError: it cannot be read ``how``."""
    try:
        yield
    except Exception as error:
        said = one_line(error)[:400]  # whatever the library quotes
        raise ValueError(f"{key} = {path.name!r} cannot be read{how}: {said}") from error


class Bounded(io.BufferedReader):
    """A file that gives no more bytes than it has, so that nothing is allocated for a length that is damaged."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Bytes from here on, as many as are asked for and are there."""
        left = max(0, os.fstat(self.fileno()).st_size - self.tell())
        return super().read(left if size is None or size < 0 else min(size, left))


def bounded(path: Path) -> Bounded:
    """The file, opened to be read."""
    return Bounded(path.open("rb", buffering=0))
