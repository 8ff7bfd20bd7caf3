"""Rows of a run that are too many for memory: block by block they become channels in a file."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from ehamj import columns, growing
from ehamj.belonging import RUN
from ehamj.errors import InputError
from ehamj.run.judging import import_judging
from ehamj.unfinished import NO_ROOM, beside, clear_leftovers

if TYPE_CHECKING:
    import xarray as xr

    from ehamj.mujoco.rows import Rows
    from ehamj.run.faults import Struck
    from ehamj.run.prepare import Prepared
    from ehamj.stopped import Stopped

AT_LEAST: Final = 64
"""Rows that follow a block, so that what is observed at once is never next to nothing: products of few rows round
otherwise."""
PLACE: Final = "ehamj-rows"
"""What the folder of such a file stands for, as `ehamj.unfinished` tells them apart."""


def ready(rows: int) -> bool:
    """Whether a block of so many rows that stand recorded may go."""
    return rows >= columns.ROWS + AT_LEAST


def room(steps: int) -> int:
    """Rows that there must be room for, where so many steps are taken at once."""
    return columns.ROWS + AT_LEAST + steps


def rows_of(prepared: "Prepared") -> int:
    """Rows of a run that comes to its end."""
    return prepared.steps // prepared.every + 1


class Stream:
    """The file of one run."""

    def __init__(self, prepared: "Prepared") -> None:
        """For a run whose rows are to come."""
        import_judging()
        within = prepared.within or Path(tempfile.gettempdir())
        within.mkdir(parents=True, exist_ok=True)
        clear_leftovers(within)
        self._prepared, self._rows = prepared, 0
        self.lost: Exception | None = None
        """Why nothing is added any more."""
        self._file = growing.Growing(beside(within / PLACE), columns.ROWS, rows_of(prepared))

    def add(self, rows: "Rows", struck: "Sequence[Struck]") -> None:
        """Append rows of a run, `ehamj.columns.ROWS` of them or the last ones; ``struck`` are its faults until then.

        Where some cannot be made or written, they and all later ones are left out, and `lost` says why.

        Raises:
            InputError: where already the first cannot be written: nothing of the run is kept.
        """
        from ehamj.run.observe import observe

        if self.lost is not None:
            return
        try:
            self._file.add(observe(self._prepared, rows, struck, self._rows))
        except Exception as error:  # whatever it is, what stands before it took its time to compute
            if self._rows:
                self.lost = error
                return
            if isinstance(error, OSError) and error.errno in NO_ROOM:
                raise InputError(
                    f"rows of the run cannot be written: {error.filename!r}: {error.strerror}; nothing of it is kept. "
                    "Lower record_rate or duration, or write where there is more room (--out)"
                ) from error
            raise
        self._rows += len(rows.qpos)

    def ended(self, stopped: "Stopped", lost: Exception | None = None) -> "tuple[growing.Kept, str | None]":
        """The channels, and what went wrong, in words; ``lost`` is why the run went no further, if it broke off."""
        from ehamj.run.failures import failure
        from ehamj.run.observe import identity

        failed: list[str | None] = []

        def complete(dataset: "xr.Dataset") -> dict[str, int | str]:
            failed.append(failure(self._prepared, stopped, dataset, self.lost or lost))
            return {"complete": int(failed[0] is None), RUN: identity(self._prepared, dataset)}

        return self._file.ended(complete), failed[0]


def streamed(prepared: "Prepared", rows: "Rows", struck: "Sequence[Struck]") -> Stream:
    """The file of rows that are in memory."""
    stream = Stream(prepared)
    for some in columns.blocks(len(rows.qpos)):
        stream.add(rows.part(some), struck)
    return stream
