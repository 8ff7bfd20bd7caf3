"""A case: files, commands before which they are put, and the keys that a refusal of it may name."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

MARK = "mark"
"""Name of the file that hostile content would write."""


@dataclass(frozen=True)
class Case:
    """What stands in an otherwise empty folder, and what is called there, one command after the other."""

    files: dict[str, bytes]
    commands: tuple[tuple[str, ...], ...]
    keys: tuple[str, ...] = ()
    """Of what was changed; empty where everything may be named."""
    told: str = ""
    """What was done, in words."""
    folders: dict[str, Path] = field(default_factory=dict)
    """Folders that are copied there, by name."""
    damaged: bool = False
    """Whether bytes were damaged, so that a place in the file is what can be named."""

    def lay(self, folder: Path) -> None:
        """Put everything into a folder."""
        for name, source in self.folders.items():
            shutil.copytree(source, folder / name)
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)


Maker = Callable[[Random, Path], Case]
"""Makes a case by chance; the folder keeps what is made once and serves many."""


def chance(kind: str, seed: int, number: int) -> Random:
    """What case ``number`` of a kind is drawn from: it is repeated by these three."""
    return Random(f"{kind} {seed} {number}")
