"""Records in seismic formats, through ObsPy, with the instrument's response."""

import re
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ehamj.records.channel import Record, Response
from ehamj.records.choices import SILENT, Choices, GapChoice
from ehamj.records.clock import filled
from ehamj.records.components import Component, Loaded, existing, reading, record_of
from ehamj.records.formats import read_inventory, read_record
from ehamj.records.units import Quantity
from ehamj.signals import Array

if TYPE_CHECKING:
    from obspy import Inventory, Stream, Trace

EXAMPLE = "example:BW.RJOB"

SENSED: dict[str, tuple[Quantity, str]] = {
    "": ("displacement", "DISP"),
    "/S": ("velocity", "VEL"),
    "/S2": ("acceleration", "ACC"),
}
"""What an instrument senses by its unit over the metre, and what ObsPy calls that."""


def read_seismic(path: Path, choices: Choices = SILENT) -> Record:
    """A record in any format ObsPy reads; the last part of ``path`` may hold wildcards, or it is `EXAMPLE`.

    Counts stay counts: each channel carries the response that the processing divides by. Raises ValueError for a file
    that is missing, truncated or damaged, for gaps, overlaps, several stations, and a missing response.
    """
    label = path.name
    stream, responses = _open(path, choices.inventory)
    beginning = min(trace.stats.starttime for trace in stream)
    by_name: dict[str, list[Trace]] = {}
    for trace in stream:
        by_name.setdefault(trace.id, []).append(trace)

    def load(name: str) -> Loaded:
        trace, notes = _join(by_name[name], label, choices.gaps)
        unit, response = _response(trace, responses) if choices.remove_response else (None, None)
        if not choices.remove_response and trace.stats.calib != 1:
            notes.append(
                f"{name} states a calibration factor of {trace.stats.calib:g}, which is not applied (ground.scale can)"
            )
        stated = None if unit is None else (unit, 1.0)
        time = float(trace.stats.starttime - beginning)
        samples = np.asarray(trace.data, float)
        return Loaded(samples, trace.stats.sampling_rate, stated, time, response, tuple(notes))

    components = [
        Component(name, partial(load, name), (channel, channel[-1:]), name.rsplit(".", 2)[0])
        for name, channel in ((name, traces[0].stats.channel) for name, traces in by_name.items())
    ]
    return record_of(label, components, choices, "let ground.remove_response find out")


def _open(source: Path, inventory: str | None) -> tuple["Stream", "Inventory | None"]:
    """The traces of all files and the responses."""
    import obspy

    if str(source) == EXAMPLE:
        return obspy.read(), obspy.read_inventory() if inventory is None else _open_inventory(inventory)
    paths = [source] if source.is_file() else sorted(source.parent.glob(source.name))
    if not paths:
        raise ValueError(f"ground.file = {source.name!r}: there is no such file in {source.parent}")
    stream = obspy.Stream()
    for path in paths:
        stream += _open_file(path)
    return stream, None if inventory is None else _open_inventory(inventory)


def _open_file(path: Path) -> "Stream":
    from obspy.io.mseed import InternalMSEEDWarning
    from obspy.io.mseed.util import get_record_information

    with reading(path, ", neither as a seismic format nor as *.csv; it may be truncated or damaged"):
        # ObsPy only warns of a record that breaks off or fails its checksum and leaves the rest out.
        with warnings.catch_warnings():
            warnings.simplefilter("error", InternalMSEEDWarning)
            stream, form = read_record(path)
        if form == "MSEED":
            # Some records that break off go without a warning, so see whether they fill the file.
            offset, size = 0, path.stat().st_size
            while size % 128 == 0 and offset < size:
                information = get_record_information(str(path), offset)
                offset += information["record_length"] * (
                    1 if information["excess_bytes"] else information["number_of_records"]
                )
            if size % 128 or offset > size:
                raise ValueError("its last record is truncated")
    for trace in stream:
        if trace.data.dtype.kind not in "iuf":
            raise ValueError(f"ground.file = {path.name!r}: channel {trace.id} holds text or the like, not samples")
    return stream


def _open_inventory(name: str) -> "Inventory":
    path = existing(Path(name), "ground.inventory")
    with reading(path, " as a file of responses", "ground.inventory"):
        return read_inventory(path)


def _join(traces: "list[Trace]", label: str, gaps: GapChoice) -> "tuple[Trace, list[str]]":
    """One trace of the traces of a channel; remarks on gaps that were filled."""
    import obspy

    stream = obspy.Stream(traces)
    try:
        stream.merge(method=-1)
        holes = stream.get_gaps()
        overlaps = [hole for hole in holes if hole[6] < 0]
        if overlaps:
            raise ValueError(f"traces of {'.'.join(overlaps[0][:4])} overlap by {-overlaps[0][6]:.4g} s")
        if not holes:
            return stream[0], []
    except Exception as error:  # ObsPy raises Exception itself, such as for rates that differ within a channel
        raise ValueError(f"ground.file = {label!r}: {error}; each channel must be one trace") from error
    recorded = sum(trace.stats.npts * trace.stats.delta for trace in stream)
    note = filled(label, len(holes), sum(hole[6] for hole in holes), recorded, gaps)
    stream.merge(method=1, fill_value="interpolate")
    return stream[0], [note]


def _response(trace: "Trace", inventory: "Inventory | None") -> tuple[Quantity, Response]:
    """What the instrument senses, and its response in counts per SI unit of that."""
    if inventory is None and "response" not in trace.stats:
        raise ValueError(
            f"ground.inventory is missing, and the file has no response of {trace.id}; give a file with it, or set "
            "ground.remove_response = false and ground.quantity for samples in SI"
        )
    try:
        found = trace.stats.response if inventory is None else inventory.get_response(trace.id, trace.stats.starttime)
    except Exception as error:  # ObsPy raises Exception itself
        raise ValueError(f"ground.inventory has no response of {trace.id} at {trace.stats.starttime}") from error
    stated = (found.instrument_sensitivity, *found.response_stages)
    units = next((str(part.input_units) for part in stated if part is not None and part.input_units), "")
    per = re.sub(r"\*\*|\^|[()\s]", "", units.upper()).replace("SEC", "S").replace("S/S", "S2")
    kind = re.fullmatch(r"[NUMC]?M(|/S|/S2)", per)
    if kind is None:
        raise ValueError(f"ground.inventory: {trace.id} senses {units!r}; known are M, M/S and M/S**2")
    quantity, output = SENSED[kind[1]]

    def evaluate(frequency: Array) -> np.ndarray:
        try:
            return found.get_evalresp_response_for_frequencies(frequency, output=output)
        except Exception as error:  # evalresp raises what it likes
            raise ValueError(f"ground.inventory: the response of {trace.id} cannot be evaluated: {error}") from error

    return quantity, evaluate
