"""The seismic formats that are read, by name: data formats of ObsPy, none of which runs code or opens other files.

ObsPy's own detection is never asked, since it tries every plugin it knows; among them is one that unpickles a file,
which runs whatever the file says. Of ObsPy's formats these are left out:

- PICKLE runs code; CSS and NNSA_KB_CORE open the files that they name.
- GSE1 and GSE2 have a decoder of our own, `ehamj.records.gse`: ObsPy's writes beyond its memory at damaged files.
- DMX and RG16 do not end where a file is damaged; ALSEP (the Moon's) is detected by too little.
- WAV has a reader of its own, `ehamj.records.wav`.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ehamj.plain.xml import check_xml, is_xml
from ehamj.records.gse import read_gse
from ehamj.records.orientation import UNSET

if TYPE_CHECKING:
    from obspy import Inventory, Stream

Kind = Literal["waveform", "inventory"]

LARGEST_INVENTORY = 2**28
"""Most that is read of a file of responses [byte]."""


def _sac_places(path: str) -> None:
    """Raise ValueError for places off the Earth, in search of which ObsPy turns around it without end."""
    from obspy.io.sac.arrayio import read_sac

    header = read_sac(path, headonly=True)[0]
    _on_earth(header)


def _sac_ascii_places(path: str) -> None:
    from obspy.io.sac.arrayio import read_sac_ascii

    _on_earth(read_sac_ascii(path, headonly=True)[0])


def _on_earth(header: Any) -> None:
    for at, what in ((31, "STLA"), (32, "STLO"), (35, "EVLA"), (36, "EVLO")):
        if not (abs(header[at]) <= 360.0 or header[at] == UNSET):
            raise ValueError(f"its header states {what} = {header[at]:g}, which is no place on Earth in degrees")


@dataclass(frozen=True)
class Format:
    """A format by ObsPy's name, what people call it, a check that comes before ObsPy reads, or who reads instead."""

    name: str
    title: str
    check: Callable[[str], None] = lambda path: None
    read: "Callable[[str], Stream] | None" = None


RECORDS = (
    Format("MSEED", "miniSEED 2"),
    Format("SAC", "SAC", _sac_places),
    Format("GSE2", "GSE2", read=partial(read_gse, version=2)),
    Format("GSE1", "GSE1", read=partial(read_gse, version=1)),
    Format("SEISAN", "SEISAN"),
    Format("SACXY", "SAC in text", _sac_ascii_places),
    Format("Q", "Seismic Handler Q"),
    Format("SH_ASC", "Seismic Handler text"),
    Format("SLIST", "SLIST text"),
    Format("TSPAIR", "TSPAIR text"),
    Format("Y", "Nanometrics Y"),
    Format("SEGY", "SEG-Y"),
    Format("SU", "Seismic Unix"),
    Format("SEG2", "SEG-2"),
    Format("WIN", "WIN"),
    Format("AH", "AH"),
    Format("PDAS", "PDAS"),
    Format("KINEMETRICS_EVT", "Kinemetrics EVT"),
    Format("GCF", "Güralp GCF"),
    Format("CYBERSHAKE", "CyberShake"),
    Format("KNET", "K-NET text"),
    Format("REFTEK130", "RefTek 130"),
)
"""Formats of records, in the order in which they are tried: by the files' content, whatever their names."""

INVENTORIES = (
    Format("STATIONXML", "StationXML"),
    Format("SCML", "SeisComP XML"),
    Format("INVENTORYXML", "ArcLink inventory XML"),
    Format("XSEED", "XML-SEED"),
    Format("SEED", "dataless SEED"),
    Format("RESP", "RESP"),
    Format("STATIONTXT", "FDSN station text"),
)
"""Formats of responses, in the order in which they are tried; those in XML for XML only."""

XML = frozenset({"STATIONXML", "SCML", "INVENTORYXML", "XSEED"})

PACKED = {
    b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"PK\x03\x04": "zip", b"\xfd7zXZ": "xz", b"7z\xbc\xaf": "7-zip",
    b"\x28\xb5\x2f\xfd": "zstd",
}  # fmt: skip
"""How archives begin. They are not unpacked: a small one may hold more than any disk."""


def record_format(path: Path) -> Format:
    """The format of a file by its content; raises ValueError if it is none that is known."""
    found = _format_of(str(path), "waveform", RECORDS)
    if found is None:
        raise ValueError(f"{_nature(path)}; known are {', '.join(one.title for one in RECORDS)}")
    return found


def read_record(path: Path, form: Format) -> "Stream":
    """The traces of a file; what ObsPy raises is the caller's to translate."""
    from obspy import Stream

    form.check(str(path))
    if form.read is not None:
        return form.read(str(path))
    return Stream(_function(form, "waveform", "readFormat")(str(path)).traces)


def read_inventory(path: Path) -> "Inventory":
    """The responses in a file; raises ValueError if its format is none that is known."""
    if path.stat().st_size > LARGEST_INVENTORY:
        raise ValueError(f"it has more than {LARGEST_INVENTORY / 2**20:g} MiB; keep the stations that are needed")
    data = path.read_bytes()
    xml = is_xml(data)
    if xml:
        check_xml(data)
    found = _format_of(data, "inventory", [one for one in INVENTORIES if (one.name in XML) == xml])
    if found is None:
        raise ValueError(f"{_nature(path)}; known are {', '.join(one.title for one in INVENTORIES)}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of places, dates and heights of stations, which nobody asks for
        return _function(found, "inventory", "readFormat")(BytesIO(data))


def _format_of(source: str | bytes, kind: Kind, formats: Sequence[Format]) -> Format | None:
    """The first format whose plugin says that the file is its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what a plugin thinks of files that are not its own
        for one in formats:
            try:
                if _function(one, kind, "isFormat")(source if isinstance(source, str) else BytesIO(source)):
                    return one
            except Exception:  # a plugin that stumbles does not know the file
                continue
    return None


def _nature(path: Path) -> str:
    """Why a file is none of the known formats, as far as its beginning tells."""
    with path.open("rb") as file:
        head = file.read(512)
    packed = next((name for mark, name in PACKED.items() if head.startswith(mark)), None)
    if packed is None and head[257:262] == b"ustar":
        packed = "tar"
    if packed is not None:
        return f"it is packed ({packed}); unpack it first"
    if head[:3] == b"MS\x03":
        return "it is miniSEED 3; write it as miniSEED 2 (with mseedconvert, for instance)"
    return "its content is of no known format"


def _function(one: Format, kind: Kind, name: str) -> Callable[..., Any]:
    """A function of ObsPy's plugin of that name."""
    from obspy.core.util.base import ENTRY_POINTS
    from obspy.core.util.misc import buffered_load_entry_point

    entry = ENTRY_POINTS[kind][one.name]
    return buffered_load_entry_point(entry.dist.name, f"obspy.plugin.{kind}.{one.name}", name)
