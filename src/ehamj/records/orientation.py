"""Where a seismometer's component points, as metadata and headers state it, against what its name says.

Azimuth [°] clockwise from north, dip [°] down from the horizontal (FDSN, *StationXML*; *SEED Reference Manual 2.4*): a
vertical component whose motion counts upwards has a dip of -90°. SAC states the angle from the vertical instead.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from obspy import Trace

TOLERANCE = 5.0
"""How far a component may point off its name without a word [°]: a sensor is levelled and turned by hand."""

NAMED = {"E": (90.0, 0.0), "N": (0.0, 0.0), "Z": (0.0, -90.0)}
"""Azimuth and dip [°] of components by the last letter of their code."""

UNSET = -12345.0
"""What SAC writes for nothing."""


class Orientation(NamedTuple):
    """Azimuth and dip of a component [°], None where they are not stated, and who states them."""

    azimuth: float | None
    dip: float | None
    source: str

    @property
    def direction(self) -> np.ndarray | None:
        """Unit vector to east, north and up, None where it is not known or no angle."""
        dip = 0.0 if self.dip is None else self.dip
        if self.azimuth is None and abs(dip) != 90.0:
            return None
        azimuth, down = np.radians([self.azimuth or 0.0, dip])
        found = np.array([np.cos(down) * np.sin(azimuth), np.cos(down) * np.cos(azimuth), -np.sin(down)])
        return found if np.isfinite(found).all() and abs(dip) <= 90.0 else None


def of_header(trace: "Trace") -> Orientation | None:
    """What a SAC header states of a trace; None elsewhere, and where it states nothing."""
    header = trace.stats.get("sac", {})
    azimuth, incidence = (float(header.get(key, UNSET)) for key in ("cmpaz", "cmpinc"))
    if UNSET in (azimuth, incidence):
        return None
    return Orientation(azimuth, incidence - 90.0, "the header (CMPAZ, CMPINC)")


def turned(name: str, channel: str, stated: Orientation | None) -> tuple[float, tuple[str, ...]]:
    """The factor, 1 or -1, that makes a component count as its name says, and a remark where it does not by itself."""
    if stated is None or (direction := stated.direction) is None or (channel[-1:] == "Z" and stated.dip is None):
        return 1.0, ()
    told = f"{name}: {stated.source} states {_angles(stated)}"
    if channel[-1:] not in NAMED:
        return 1.0, (f"{told}; it is taken as ground.axes says, and not turned",)
    wanted = Orientation(*NAMED[channel[-1:]], "").direction
    assert wanted is not None
    off = float(np.degrees(np.arccos(np.clip(direction @ wanted, -1.0, 1.0))))
    if off <= TOLERANCE:
        return 1.0, ()
    if off >= 180.0 - TOLERANCE:
        return -1.0, (f"{told}, against its name: its sign is turned",)
    return 1.0, (f"{told}, {off:.0f}° off its name: it is taken as named, and not turned",)


def _angles(stated: Orientation) -> str:
    parts = (("azimuth", stated.azimuth), ("dip", stated.dip))
    return " and ".join(f"{what} {value:g}°" for what, value in parts if value is not None)
