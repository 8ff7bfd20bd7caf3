"""Seismic files made up for tests: traces, and metadata of instruments whose response is known by hand."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from obspy import Stream, Trace, UTCDateTime
from obspy.core.inventory import Channel, Inventory, Network, Response, Site, Station
from obspy.core.inventory.response import InstrumentSensitivity, PolesZerosResponseStage

BEGIN = UTCDateTime(2026, 1, 5)
TAU = 2 * np.pi


def trace(samples: Any, channel: str = "HHZ", rate: float = 100.0, begin: float = 0.0, **header: Any) -> Trace:
    stats = {"network": "XX", "station": "ONE", "channel": channel, "sampling_rate": rate, "starttime": BEGIN + begin}
    return Trace(np.asarray(samples), {**stats, **header})


def write(path: Path, *traces: Trace, kind: str = "MSEED", **options: Any) -> Path:
    Stream(list(traces)).write(str(path), format=kind, **options)
    return path


def flat(gain: float, unit: str, overall: float | None = None, overall_unit: str | None = None) -> Response:
    """An instrument without poles: ``gain`` counts per unit by its stage, ``overall`` by its sensitivity."""
    stage = PolesZerosResponseStage(
        1, gain, 1.0, unit, "COUNTS", "LAPLACE (RADIANS/SECOND)", 1.0, [], [], normalization_factor=1.0
    )
    return Response(
        instrument_sensitivity=InstrumentSensitivity(
            gain if overall is None else overall, 1.0, overall_unit or unit, "COUNTS"
        ),
        response_stages=[stage],
    )


def inventory(
    path: Path, *held: tuple[str, Response | None, Any, Any], station: str = "ONE", location: str = ""
) -> Path:
    """StationXML of channels: code, response, and its epoch."""
    channels = [
        Channel(
            code, location, 0, 0, 0, 0, azimuth=0, dip=-90, sample_rate=100, response=response, start_date=start,
            end_date=end,
        )
        for code, response, start, end in held
    ]  # fmt: skip
    stations = [Station(station, 0, 0, 0, channels=channels, site=Site("made up"))]
    Inventory([Network("XX", stations=stations)]).write(str(path), format="STATIONXML")
    return path


def metadata(path: Path, response: Response | None, codes: Sequence[str] = ("HHZ",)) -> Path:
    """StationXML of channels that share a response, for all times."""
    return inventory(path, *((code, response, None, None) for code in codes))
