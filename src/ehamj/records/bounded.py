"""Files that are read no further than they go."""

import io
import os
from pathlib import Path


class Bounded(io.BufferedReader):
    """A file that gives no more bytes than it has, so that nothing is allocated for a length that is damaged."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Bytes from here on, as many as are asked for and are there."""
        left = max(0, os.fstat(self.fileno()).st_size - self.tell())
        return super().read(left if size is None or size < 0 else min(size, left))


def bounded(path: Path) -> Bounded:
    """The file, opened to be read."""
    return Bounded(path.open("rb", buffering=0))
