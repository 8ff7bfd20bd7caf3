"""Why a machine moves more than its floor: what the linear machine says of it, and what it leaves open."""

from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from typing import Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import Made, Samples
from ehamj.errors import InputError
from ehamj.estimate.bands import Band
from ehamj.estimate.remembered import remembered
from ehamj.judge.actuation import PART, TILTING, WHOLE
from ehamj.judge.isolation import Isolation
from ehamj.judge.levels import BANDS, rms_in_bands
from ehamj.judge.summary import ByMount
from ehamj.judge.worse import MOTIONS, Cause, Worse, worse
from ehamj.linear.loop import Loop, feeds_back, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import Mode, modes
from ehamj.linear.response import machine_channels, rigid_floor
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import MOTIONS as UPRIGHT_MOTIONS
from ehamj.plant.levers import lever, levers
from ehamj.run.limits import WORDS
from ehamj.run.prepare import Prepared

PER_BAND: Final = 7
"""Frequencies of a band at which the linear machine answers."""
EXPLAINED: Final = 4.0
"""By how much the linear machine may stay below what was measured and still explain it [dB]: the floor's motions are
taken as independent of each other, and the band as white."""
AS_PASSIVE: Final = 3.0
"""By how much less, or more, the machine with held valves may amplify and still be said to do the same [dB]."""
NEAR: Final = 1.5
"""Octaves within which a mode may be what is excited."""
FLANK: Final = 0.5
"""Octaves from which it is the mode's flank, and not its resonance."""
TAKES_PART: Final = 0.01
"""Share of a mode's motion along the axis, turns at a metre, times that in what drives it, from which it takes part."""


def worsened(
    prepared: Prepared, dataset: xr.Dataset, isolated: Isolation, shares: dict[str, ByMount], unstable: bool = False
) -> list[Worse]:
    """Every axis that gets worse, with the reason as far as it is known; ``shares`` of the time at each limit."""
    found = worse(isolated)
    if unstable:  # no response is there to ask
        return [one.changed(why="the control loop is unstable", by="law") for one in found]
    if prepared.scenario.fault:  # there is no one linear machine to ask
        return [one.changed(why="the run is that of a machine before and after its faults") for one in found]
    reasons = Reasons(prepared, dataset, shares) if found else None
    return [reasons.of(one) if reasons else one for one in found]


class Reasons:
    """Asks the linear machine, with its valves held and under the law, what it makes of the floor's motion."""

    def __init__(self, prepared: Prepared, dataset: xr.Dataset, shares: dict[str, ByMount]) -> None:
        self.scenario, self.law, self.shares = prepared.scenario, prepared.law, shares
        self.noisy, self.python = prepared.noise is not None, prepared.law is None and prepared.controller is not None
        ground = dataset["ground_velocity"].variable
        fit = np.linalg.pinv(levers(prepared.scenario.plant.positions))
        self.floor = Made(
            (ground.shape[0], len(DOFS)), lambda rows: (own := ground[rows].values).reshape(len(own), -1) @ fit.T
        )
        """Velocity of the rigid floor that is nearest to the mounts', (time, DOFS) [m/s, rad/s]."""

    def of(self, one: Worse) -> Worse:
        """With the reason: the mode that is excited and by what, or the limit that was reached."""
        if self.model is None or self.python:
            return self._not_linear(one, "")
        held, ruled = self._levels(one, None), self._levels(one, self.loop)
        level = self._measured(one)
        held_db, ruled_db = (20.0 * np.log10(np.hypot.reduce(part) / level + 1e-12) for part in (held, ruled))
        if ruled_db < -EXPLAINED:
            return self._not_linear(one, *self._excited(one, one.axis))
        motion = DOFS[int(np.argmax(ruled))]
        by = "" if motion == one.axis else f", driven by the floor's {MOTIONS[motion]}"
        follows = "the linear machine amplifies it" if motion == one.axis else "the machine follows"
        excited, mode = self._excited(one, motion)
        said = f"{excited or follows}{by}"
        if self.law is None:
            return one.changed(why=said, by="mounts", mode=mode)
        over = _over(one, level, held)
        if held_db < ruled_db - AS_PASSIVE:
            why = f"{said} by the law: with the valves held it is {over}{self._late(one)}"
            return one.changed(why=why, by="law", mode=mode)
        if held_db > max(ruled_db, 0.0) + AS_PASSIVE:
            why = f"{said}; with the valves held it would be {over}, {held_db:.0f} dB more"
        else:
            why = f"{said}, with the valves held as well ({over}){self._reach(one.axis)}"
        return one.changed(why=why, by="mounts", mode=mode)

    def _reach(self, axis: str) -> str:
        """That the valves do not drive a motion, where they do not, and what they drive of it."""
        layout = self.scenario.plant.layout
        driven = layout.share(axis)
        if driven > PART:
            return "" if driven > WHOLE else "; the valves drive that motion in part only"
        upright = layout.motions == UPRIGHT_MOTIONS
        acting = (
            "the valves act vertically" if upright else f"the valves drive {', '.join(layout.motions) or 'nothing'}"
        )
        tilts = axis in TILTING and layout.share(TILTING[axis]) > PART
        return f"; {acting}, and {'reach it only by tilting the machine' if tilts else 'do not reach it'}"

    @cached_property
    def model(self) -> LinearModel | None:
        """None where the machine has no rest to linearise about."""
        with suppress(InputError):
            return linear_under(self.scenario.plant, self.law)
        return None

    @cached_property
    def loop(self) -> Loop | None:
        return Loop.of(self.scenario, self.law)

    @cached_property
    def modes(self) -> Sequence[Mode]:
        assert self.model is not None
        return modes(self.model, self.loop if feeds_back(self.law) else None)

    def _row(self, one: Worse) -> Array:
        """The machine's motion along the axis at the place, from its six degrees of freedom, (6,).

        Of the feet the mean of squares counts, of which (4, 6).
        """
        if one.axis not in AXES:
            return np.eye(len(DOFS))[[DOFS.index(one.axis)]]
        plant, axis = self.scenario.plant, AXES.index(one.axis)
        points = {"machine": [plant.machine.cg], "feet": plant.positions}
        places = points.get(one.place) or [self.scenario.points[one.place]]
        return np.array([lever(place)[axis] for place in places])

    def _levels(self, one: Worse, loop: Loop | None) -> Array:
        """Level of the machine by each of the floor's motions [m/s, rad/s], (DOFS,)."""
        assert self.model is not None
        band = _band(one)
        hertz = np.geomspace(*band.edges, 2 * PER_BAND + 1)[1::2]
        answer = rigid_floor(self.model, hertz, loop, machine_channels("mounts")).response
        along = np.abs(self._row(one) @ answer) ** 2  # (f, place, DOFS)
        floor = _floor_levels(self.floor, self.scenario.record_rate, band)
        return np.asarray(np.sqrt(along.mean(axis=0).max(axis=0)) * np.nan_to_num(floor))

    def _measured(self, one: Worse) -> float:
        """The machine's level [m/s, rad/s]."""
        if one.level is not None:
            return one.level
        floor = _floor_levels(self.floor, self.scenario.record_rate, _band(one))[DOFS.index(one.axis)]
        return float(floor) * 10.0 ** ((one.amplification_db or 0.0) / 20.0)

    def _excited(self, one: Worse, motion: str) -> tuple[str, str]:
        """The mode that one of the floor's motions excites most along the axis, by its shape and its resonance: that
        it is excited, and its name with its frequency; "" where there is none within `NEAR`."""
        band, row = _band(one), self._row(one)

        def share(mode: Mode) -> float:
            """Of the mode's motion along the axis at the place, times that in what drives it."""
            shape = np.abs(mode.shape) / np.abs(mode.shape).max()
            along = np.abs(row @ mode.shape).max() / np.abs(mode.shape).max()
            return float(along * shape[DOFS.index(motion)])

        def answer(mode: Mode) -> float:
            ratio = float(np.clip(mode.frequency, *band.edges)) / mode.frequency
            return share(mode) / abs(1.0 - ratio**2 + 2j * mode.damping_ratio * ratio)

        def octaves(mode: Mode) -> float:
            return abs(float(np.log2(mode.frequency / band.centre)))

        taking = [m for m in self.modes if m.machine_moves and octaves(m) <= NEAR and share(m) >= TAKES_PART]
        mode = max(taking, key=answer, default=None)
        if mode is None:
            return "", ""
        short = f"{mode.name} at {mode.frequency:.3g} Hz"
        named = f"{short} (damping {mode.damping_ratio:.2g})"
        return (f"it lies on the flank of {named}" if octaves(mode) > FLANK else f"{named} is excited"), short

    def _late(self, one: Worse) -> str:
        """That the valves no longer follow in the band, where they do not."""
        corner = min(actuator.valve_frequency for actuator in self.scenario.plant.actuators) / (2 * np.pi)
        band = _band(one)
        return f"; the valves follow up to {corner:.3g} Hz only" if band.edges[1] > 0.5 * corner else ""

    def _not_linear(self, one: Worse, excited: str, mode: str = "") -> Worse:
        """With what this run has and the linear machine does not, and the mode that is ``excited``, if any."""
        reached = {name: max(of_mount.values()) for name, of_mount in self.shares.items()}
        found = [f"{WORDS[name]} for {100 * share:.2g} % of the time" for name, share in reached.items() if share > 0]
        if self.scenario.force:
            found.append("forces act on the machine")
        if any(slide.moves for slide in self.scenario.slide):
            found.append("slides move on the machine")
        if self.noisy:
            found.append("the sensors have noise")
        if self.python:
            found.append("a Python function commands the valves")
        by: Cause = "limits" if any(share > 0 for share in reached.values()) else ""
        why = "the linear machine would not: it is the valves' nonlinearity, or what moves in other bands"
        if found:
            why = f"the linear machine would not, and in this run {', '.join(found)}{f'; {excited}' if excited else ''}"
        return one.changed(why=why, by=by, mode=mode)


@remembered(16)
def _floor_levels(floor: Samples, rate: float, band: Band) -> Array:
    """Whole-run RMS in a band of the rigid floor's velocity (time, DOFS), which variants share, (DOFS,)."""
    return rms_in_bands(floor, rate, (band,))[0]


def _band(one: Worse) -> Band:
    return next(band for band in BANDS if band.name == one.band)


def _over(one: Worse, level: float, held: Array) -> str:
    """Machine over floor with the valves held [dB], or the level where the floor does not move along the axis."""
    own = float(np.hypot.reduce(held))
    if one.amplification_db is None:
        return f"{1e6 * own:.3g} µm/s"
    return f"{one.amplification_db + 20.0 * np.log10(own / level + 1e-12):.1f} dB"
