"""What a command is doing: a spinner with words where a person looks on, a line now and then where nobody does."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from rich.markup import escape

from ehamj.cli.frame import log

EVERY: Final = 5.0
"""Least time between two lines where standard error is no terminal [s]."""


@contextmanager
def doing(title: str) -> Iterator[Callable[[str], None]]:
    """Say on standard error what is being done while the block lasts; call what it gives with each step's name.

    On a terminal the words stand behind a spinner and go when they are done. Elsewhere there are lines without any
    control characters: the title, then a step's name whenever `EVERY` seconds have passed since the last line.
    """
    if log.is_terminal:
        with log.status(escape(title)) as status:
            yield lambda step: status.update(f"{escape(title)}: {escape(step)}")
        return
    last = -math.inf

    def line(step: str) -> None:
        nonlocal last
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            log.print(f"{title}: {step}" if step else title, markup=False, highlight=False, soft_wrap=True)

    line("")
    yield line
