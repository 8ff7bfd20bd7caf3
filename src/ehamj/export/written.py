"""What an export says of the files that it wrote."""

from collections.abc import Mapping
from typing import NamedTuple


class Written(NamedTuple):
    """What was written."""

    files: Mapping[str, str]
    """By its name (within its folder): what a file is and how to open it, one line; ``{path}`` stands for where it is
    in the end. Those that explain themselves need not be told."""
    notes: tuple[str, ...] = ()
    """What a person should know, a sentence each."""
