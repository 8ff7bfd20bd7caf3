"""Where a machine moves more than its floor: the axis, the bands, the place where it is worst, and by how much.

Along x, y and z it is held against the floor's loudest mount, and not against the mean of the mounts, as attenuation
is: what passes below them as a wave cancels in the mean, and a machine that moves less than every mount is no worse.
Roll, pitch and yaw are held against those of the rigid slab fitted to the floor.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Literal

from pydantic import Field

from ehamj.findings import Finding
from ehamj.judge.attenuation import LEAST_LEVEL, NOISE
from ehamj.judge.decisive import place_in_words
from ehamj.judge.isolation import Isolation
from ehamj.judge.levels import BANDS, SLAB
from ehamj.plant.axes import AXES

LEAST: Final = 1.0
"""Amplification that is worth a word [dB]. Two levels are compared, and what reads a level in a third-octave band by
class 1 of IEC 61260-1 may be wrong by 0.4 to 0.5 dB within it: less than their sum no measurement would show."""

MOTIONS: Final = {
    "z": "vertical motion",
    "x": "motion along x",
    "y": "motion along y",
    "rx": "roll",
    "ry": "pitch",
    "rz": "yaw",
}
"""The floor's motions in words."""


Cause = Literal["law", "mounts", "limits", ""]

CAUSES: Final[dict[Cause, str]] = {
    "law": "its law does it, with the valves held it would not be so",
    "mounts": "its mounts do it, with the valves held as well",
    "limits": "its valves are at a limit",
    "": "why is not known",
}
"""What makes a machine worse than its floor, in words."""


class Worse(Finding):
    """An axis along which the machine moves more than the floor, in bands that lie side by side."""

    axis: str
    place: str
    """Of the machine, where it is worst: ``machine`` (its centre of gravity), ``feet`` or a point."""
    band: str = Field(alias="band_hz")
    """Where it is worst."""
    amplification_db: float | None
    """Machine over the floor's loudest mount there, in rotations over the floor's slab; None where the floor does
    not move along the axis, and the machine does."""
    beside_db: float | None = None
    """Machine over the floor's strongest motion in that band, where the floor does not move along the axis."""
    beside: str | None = Field(None, alias="beside_axis")
    """The axis of that motion; None in a result that is older."""
    level: float | None
    """RMS velocity of the machine there [m/s]; None of rotations."""
    first_band: str = Field(alias="from_hz")
    last_band: str = Field(alias="to_hz")
    why: str = ""
    by: Cause = ""
    """What makes it so; empty where that is not known, and in a result that is older."""
    mode: str = ""
    """That is excited there, with its frequency; empty where there is none."""

    @property
    def made_worse(self) -> bool:
        """Whether the machine moves more than its floor does at all, and not only along an axis where that rests."""
        return self.amplification_db is not None or self.beside_db is None or self.beside_db > 0.0

    def briefly(self) -> str:
        """Axis, by how much, band, place and mode."""
        where = [place_in_words(self.place)] if self.axis in AXES else []
        where += [self.mode] if self.mode else []
        along = f"along {self.axis}" if self.axis in AXES else f"in {MOTIONS[self.axis]}"
        much = "where the floor rests" if self.amplification_db is None else f"by {self.amplification_db:.1f} dB"
        return f"{along} {much} at {self.band} Hz" + (f" ({'; '.join(where)})" if where else "")

    def in_words(self) -> str:
        """As a warning."""
        at = f" at {place_in_words(self.place)}" if self.axis in AXES else ""
        span = "" if self.first_band == self.last_band else f" ({self.first_band} to {self.last_band} Hz)"
        along = f"along {self.axis}" if self.axis in AXES else f"in {MOTIONS[self.axis]} ({self.axis})"
        if self.amplification_db is None:
            strongest = f"floor's {MOTIONS[self.beside]}" if self.beside else "floor's strongest motion there"
            said = (
                f"{along} the floor does not move; the machine does: {1e6 * (self.level or 0.0):.3g} µm/s in the "
                f"{self.band} Hz band{at}{span}, {abs(self.beside_db or 0.0):.1f} dB "
                f"{'above' if (self.beside_db or 0.0) > 0.0 else 'below'} the {strongest}"
            )
        else:
            mounts = " at any mount" if self.axis in AXES else ""
            said = (
                f"{along} the machine moves more than the floor{mounts}: by {self.amplification_db:.1f} dB in the "
                f"{self.band} Hz band{at}{span}"
            )
        return f"{said}; {self.why}" if self.why else said


def made_worse(found: Sequence[Worse]) -> str:
    """Where a machine is worse than its floor and what makes it so, as one sentence; empty where it is nowhere."""
    said = []
    for cause, words in CAUSES.items():
        if own := [one.briefly() for one in found if one.made_worse and one.by == cause]:
            said.append(f"{', '.join(own)}: {words}")
    return "; ".join(said)


def worse(isolated: Isolation) -> list[Worse]:
    """Every axis that gets worse, at any of the machine's places; bands side by side are one."""
    found = []
    for axis in SLAB:
        worst = {band.name: _most(isolated, axis, band.name) for band in BANDS}
        amplified = {name: at for name, at in worst.items() if at is not None and at[0] > LEAST}
        for group in _side_by_side(amplified):
            band = max(group, key=lambda name: amplified[name][0])
            above, place = amplified[band]
            found.append(
                Worse(
                    axis=axis,
                    place=place,
                    band=band,
                    amplification_db=above,
                    level=isolated.third_octave_velocity[place][axis][band] if axis in AXES else None,
                    first_band=group[0],
                    last_band=group[-1],
                )
            )
    return [*found, *_set_moving(isolated)]


def cancelled(isolated: Isolation, axis: str) -> tuple[str, ...]:
    """Bands in which attenuation along x, y or z is negative by more than `LEAST` though no place of the machine moves
    so much more than the floor's loudest mount: the mounts do not move as one there, and their mean is small."""
    levels = {place: table[axis] for place, table in isolated.third_octave_velocity.items()}
    floor, most = levels.pop("floor"), 10.0 ** (LEAST / 20.0)
    return tuple(
        band
        for band, least in isolated.attenuation_at_worst(axis).items()
        if least is not None and least < -LEAST
        if max(table.get(band) or 0.0 for table in levels.values()) <= most * (floor.get(band) or 0.0)
    )


def _set_moving(isolated: Isolation) -> Iterator[Worse]:
    """Axes along which only the machine moves, where it moves more than along those that the floor moves along."""
    levels = isolated.third_octave_velocity
    loudest = {axis: max((v for v in levels["floor"][axis].values() if v is not None), default=0.0) for axis in AXES}
    least = max(NOISE, LEAST_LEVEL * max(loudest.values()))
    still = [axis for axis in AXES if loudest[axis] <= least]
    driven = [axis for axis in AXES if axis not in still]
    for axis in still if driven else ():
        moved: dict[str, tuple[float, str]] = {}
        for band in BANDS:
            known = {p: v for p, t in levels.items() if p != "floor" and (v := t[axis][band.name]) is not None}
            beside = [t[a][band.name] or 0.0 for p, t in levels.items() if p != "floor" for a in driven]
            floor = levels["floor"][axis][band.name]
            decided = any(table.get(band.name) is not None for table in isolated.attenuation_db.values())
            if not known or floor is None or not decided:
                continue  # what the floor does not excite is what leaks from other bands
            place = max(known, key=lambda one: known[one])
            if known[place] > max(max(beside), floor):
                moved[band.name] = known[place], place
        for group in _side_by_side(moved):
            band_name = max(group, key=lambda name: moved[name][0])
            level, place = moved[band_name]
            strongest, along = max((levels["floor"][a][band_name] or 0.0, a) for a in driven)
            yield Worse(
                axis=axis,
                place=place,
                band=band_name,
                amplification_db=None,
                beside_db=20.0 * math.log10(level / strongest) if strongest > 0.0 else None,
                beside=along,
                level=level,
                first_band=group[0],
                last_band=group[-1],
            )


def _most(isolated: Isolation, axis: str, band: str) -> tuple[float, str] | None:
    """By how much the machine moves most over the floor in a band [dB], and the place; None where it is not known, or
    the floor shows only what leaks from elsewhere."""
    if axis not in AXES:
        quieter = isolated.attenuation_db.get(axis, {}).get(band)
        return None if quieter is None else (-quieter, "machine")
    tables = {place: table[axis] for place, table in isolated.third_octave_velocity.items()}
    floor = tables.pop("floor")
    least = max(NOISE, LEAST_LEVEL * max((v for v in floor.values() if v is not None), default=0.0))
    mount = floor.get(band)
    known = [(value, place) for place, table in tables.items() if (value := table.get(band))]
    if mount is None or mount <= least or not known:
        return None
    level, place = max(known)
    return 20.0 * math.log10(level / mount), place


def _side_by_side(chosen: Mapping[str, object]) -> Iterator[list[str]]:
    """Bands that lie side by side, from low to high."""
    group: list[str] = []
    for band in BANDS:
        if band.name in chosen:
            group.append(band.name)
        elif group:
            yield group
            group = []
    if group:
        yield group
