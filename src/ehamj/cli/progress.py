"""What a command is doing: a spinner with words where a person looks on, a line now and then where nobody does."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from rich.markup import escape

from ehamj.cli.frame import log

if TYPE_CHECKING:
    from ehamj.campaign.standing import Standing

EVERY: Final = 5.0
"""Least time between two lines where standard error is no terminal [s]."""


@contextmanager
def doing(title: str, steps: bool = False) -> Iterator[Callable[[str], None]]:
    """Say on standard error what is being done while the block lasts; call what it gives with each step's name.

    On a terminal the words stand behind a spinner and go when they are done. Elsewhere there are lines without any
    control characters: the title, then a step's name whenever `EVERY` seconds have passed since the last line.

    Args:
        title: of it all.
        steps: whether machines are stepped, for which a first run compiles what later ones find: that is said too.
    """
    with _words(title) as say:
        if not steps:
            yield say
            return
        from ehamj.compiled.told import telling

        with telling(lambda what, done, of: say(f"compiling {what}, once, {done} of {of}")):
            yield say


@contextmanager
def _words(title: str) -> Iterator[Callable[[str], None]]:
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


@contextmanager
def counting(title: str) -> Iterator[tuple[Callable[[str], None], Callable[["Standing"], None]]]:
    """Say on standard error how far a study of many designs is while the block lasts.

    It gives what is called with the name of a step, and with a `Standing` of its designs. On a terminal a bar stands
    with designs done, rate, time left, and the best so far below it; elsewhere there is a line now and then.
    """
    if not log.is_terminal:
        with doing(title) as line:

            def told(standing: "Standing") -> None:
                if not _stopped(standing):
                    line(standing.words)

            yield line, told
        return
    from rich.console import Group
    from rich.live import Live
    from rich.progress import BarColumn, Progress, TextColumn
    from rich.text import Text

    bar = Progress(
        TextColumn("{task.description}"), BarColumn(30), TextColumn("{task.percentage:>3.0f} %"), console=log
    )
    task = bar.add_task(escape(title), total=None)
    with Live(bar, console=log, transient=True, refresh_per_second=8) as live:

        def step(words: str) -> None:
            live.update(Group(bar, Text(words, "dim")))

        def progress(standing: "Standing") -> None:
            if _stopped(standing):
                return
            bar.update(task, description=escape(f"{title}, {standing.stage}"), total=standing.total,
                       completed=standing.done)  # fmt: skip
            live.update(Group(bar, Text(standing.words, "dim")))

        yield step, progress


def _stopped(standing: "Standing") -> bool:
    """Whether the user stops a study here, which is said, once and for good."""
    if standing.interrupted:
        log.print(standing.words, markup=False, highlight=False, soft_wrap=True)
    return standing.interrupted
