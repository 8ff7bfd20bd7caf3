"""The response of a channel at a time: found in an inventory or in poles and zeros, and nothing else taken for it."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ehamj.records.choices import ResponseChoice
from ehamj.records.epochs import Epoch, check_throughout
from ehamj.records.evalresp import instrument_of
from ehamj.records.files import existing, reading
from ehamj.records.formats import read_inventory
from ehamj.records.instrument import Instrument, Sensed, agreed_response
from ehamj.records.orientation import Orientation
from ehamj.records.poles import PoleZeros, looks_like_poles, read_poles

if TYPE_CHECKING:
    from obspy import Inventory, Trace, UTCDateTime

Responses: TypeAlias = "Inventory | list[PoleZeros]"

MOST_LISTED = 8
"""So many channels are listed in a message."""


def open_responses(name: str) -> Responses:
    """The responses in a file; raises ValueError, naming the file, where it cannot be read."""
    path = existing(Path(name), "ground.inventory")
    with reading(path, " as a file of responses", "ground.inventory"):
        with path.open("rb") as file:
            head = file.read(2**16)
        return read_poles(path.read_bytes()) if looks_like_poles(head) else read_inventory(path)


def sensed_by(trace: "Trace", held: "Responses | None", choice: ResponseChoice | None, last: "UTCDateTime") -> Sensed:
    """What the instrument of a trace senses, and its response.

    Raises ValueError where there is no response, or more than one, at the trace's first sample, and where it changes
    before the channel's ``last``.
    """
    begin, name = trace.stats.starttime, trace.id
    if held is None:
        if "response" not in trace.stats:
            raise ValueError(
                f"ground.inventory is missing, and the file has no response of {name}; give a file with it, or set "
                "ground.remove_response = false and ground.unit (or ground.quantity, for samples in SI)"
            )
        return agreed_response(name, _instrument(trace, trace.stats.response), choice)
    if isinstance(held, list):
        return agreed_response(name, _of_poles(name, held, begin, last), choice)
    channels = list(_channels(held))
    same = [(title, one) for title, one in channels if title == name]
    fitting = [one for _, one in same if _epoch(name, one).covers(begin)]
    if len(fitting) != 1 or fitting[0].response is None:
        wrong = "has no response of" if not same else "has more than one response of"
        if same and not fitting:
            wrong = "has no epoch of"
        elif len(fitting) == 1:
            wrong = "names, but has no response of,"
        near = same or [(t, one) for t, one in channels if _alike(t, name)] or channels
        raise ValueError(
            f"ground.inventory {wrong} {name} at {begin}; {'of it' if same else 'it'} holds "
            f"{_listed([_epoch(t, one).title for t, one in near])}"
        )
    found = agreed_response(name, _instrument(trace, fitting[0].response), choice)
    others = [_epoch(name, one) for _, one in same if one is not fitting[0]]
    notes = check_throughout(name, _epoch(name, fitting[0]), others, begin, last)
    azimuth, dip = (None if one is None else float(one) for one in (fitting[0].azimuth, fitting[0].dip))
    orientation = None if azimuth is dip is None else Orientation(azimuth, dip, "the inventory")
    return found._replace(notes=(*found.notes, *notes), orientation=orientation)


def _instrument(trace: "Trace", response: Any) -> Instrument:
    return instrument_of(trace.id, response, trace.stats.sampling_rate, trace.data.dtype.kind in "iu")


def _of_poles(name: str, held: list[PoleZeros], begin: "UTCDateTime", last: "UTCDateTime") -> Instrument:
    """The one response that names the channel, or names none."""
    codes = tuple(part.strip("-") for part in name.split("."))
    same = [one for one in held if one.codes == codes] or [one for one in held if one.codes is None]
    fitting = [one for one in same if one.epoch.covers(begin)]
    if len(fitting) != 1:
        wrong = "more than one response" if fitting else "no response"
        raise ValueError(
            f"ground.inventory: the poles and zeros hold {wrong} of {name} at {begin}; they hold "
            f"{_listed([one.title for one in (fitting or held)])}"
        )
    found = fitting[0].instrument(name)
    others = [one.epoch for one in same if one is not fitting[0]]
    notes = (*found.notes, *check_throughout(name, fitting[0].epoch, others, begin, last))
    if fitting[0].codes is None:
        notes = (*notes, f"{name}: the poles and zeros name no channel: taken as its own")
    return replace(found, notes=notes)


def _channels(held: "Inventory") -> Any:
    for network in held:
        for station in network:
            for channel in station:
                yield f"{network.code}.{station.code}.{channel.location_code}.{channel.code}", channel


def _epoch(title: str, channel: Any) -> Epoch:
    """When a channel of an inventory holds."""
    start, end = (None if time is None else time.datetime for time in (channel.start_date, channel.end_date))
    return Epoch(f"{title} ({_when(channel.start_date)} to {_when(channel.end_date)})", start, end)


def _alike(title: str, name: str) -> bool:
    """Whether station and channel are the same: most often network or location are spelled in another way."""
    return title.split(".")[1::2] == name.split(".")[1::2]


def _when(time: "UTCDateTime | None") -> str:
    return "…" if time is None else str(time)[:19]


def _listed(titles: list[str]) -> str:
    more = len(titles) - MOST_LISTED
    return (", ".join(titles[:MOST_LISTED]) or "nothing") + (f" and {more} more" if more > 0 else "")
