"""The epochs for which responses hold: one of them must cover a record from its first to its last sample."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from obspy import UTCDateTime

ROUNDED = timedelta(seconds=1)
"""So long before the last sample an epoch may end that no other follows: ends are often written in whole seconds."""


class Epoch(NamedTuple):
    """When a response holds, from ``start`` to before ``end`` (UTC; None: open), and how messages call it."""

    title: str
    start: datetime | None
    end: datetime | None

    def covers(self, moment: "UTCDateTime") -> bool:
        """Whether a moment is in it."""
        time = moment.datetime
        return (self.start is None or self.start <= time) and (self.end is None or time < self.end)


def check_throughout(
    name: str, own: Epoch, others: Sequence[Epoch], begin: "UTCDateTime", last: "UTCDateTime"
) -> tuple[str, ...]:
    """Remarks on the epoch ``own`` that holds at a record's first sample, ``begin``, up to its ``last``.

    Raises ValueError, naming both, where another of the channel begins within the record, and where its own ends there.
    """
    way_out = (
        "cut the record's file there (ground.start does not), or keep in the file of responses the one epoch that "
        "holds for all of it"
    )
    for other in others:
        if other.start is not None and begin.datetime < other.start <= last.datetime:
            raise ValueError(
                f"ground.inventory: the response of {name} changes at {other.start.isoformat()}, within the record "
                f"({begin} to {last}), from {own.title} to {other.title}; {way_out}"
            )
    if own.end is None or last.datetime < own.end:
        return ()
    ends = f"the epoch of its response, {own.title}, ends at {own.end.isoformat()}, within the record"
    if last.datetime - own.end >= ROUNDED:
        raise ValueError(f"ground.inventory: {name}: {ends} ({begin} to {last}), and no other follows; {way_out}")
    return (f"{name}: {ends}; it is used for the last {(last.datetime - own.end).total_seconds():.3g} s too",)
