"""The margins that practitioners ask for, of a digital control loop around the machine (`ehamj.linear.loop.opened`).

Broken at one place only (a valve, a motion, a reading) while everything else stays closed, the loop gain is
1/S_kk − 1 of the sensitivity S there.

Margins of one place are classical; the disk margin of all valves at once (Seiler, Packard and Gahinet, "An introduction
to disk margins", IEEE Control Systems 40(5), 2020; balanced, σ = 0) tells how much gain and phase may change at all of
them together and independently, since one loop at a time misleads.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.control import Controller, LinearController
from ehamj.findings import finite
from ehamj.linear.loop import Loop, Opened, feeds_back, opened, own_readings
from ehamj.linear.machine import LinearModel
from ehamj.linear.unstable import UnstablePole, unstable_pole
from ehamj.plant.plant import Plant

VANISHED: Final = 1e-200
"""Sensitivity that is none."""
NARROW: Final = 0.05
"""Damping ratio below which a law's own resonance is looked at closely."""
ENDS: Final[tuple[Literal["low", "high"], ...]] = ("low", "high")
"""Of the ranges within which lines are followed."""


@dataclass(frozen=True)
class Margins:
    """Margins of one loop gain: infinite where it never crosses.

    ``gain`` [dB] is the smallest change of gain, up or down, to the stability boundary; ``phase`` [deg] likewise;
    ``disk`` the balanced disk margin α (2 at most); ``peak`` the largest sensitivity |1/(1 + L)| and ``peak_hertz``
    where it is; ``crossings`` the frequencies at which |L| = 1 [Hz].
    """

    gain: float
    phase: float
    disk: float
    peak: float
    peak_hertz: float
    crossings: tuple[float, ...]

    @classmethod
    def worst_of(cls, found: "Sequence[Margins]") -> "Margins":
        """The least of each margin among several loop gains; the peak with its frequency, and the crossings of the one
        with the least phase."""
        highest, latest = max(found, key=lambda one: one.peak), min(found, key=lambda one: one.phase)
        gain, disk = min(one.gain for one in found), min(one.disk for one in found)
        return cls(gain, latest.phase, disk, highest.peak, highest.peak_hertz, latest.crossings)

    def to_dict(self) -> dict[str, Any]:
        """As plain data; null where a margin is infinite."""
        return {
            "gain_db": finite(self.gain), "phase_deg": finite(self.phase), "disk": self.disk,
            "peak_sensitivity": self.peak, "peak_hz": self.peak_hertz, "crossings_hz": list(self.crossings),
        }  # fmt: skip


@dataclass(frozen=True)
class LoopReport:
    """What a closed loop has in hand.

    ``unstable`` is the pole of the sampled loop that grows, None where it is stable. ``valves``, ``motions`` (of
    the machine, and patterns that move nothing: `patterns_of`) and ``readings`` hold the margins at each place with the
    rest closed; ``disk`` is that of all valves at once. Valves of passive mounts have no loop.
    """

    unstable: UnstablePole | None
    disk: float
    valves: Mapping[str, Margins]
    motions: Mapping[str, Margins]
    readings: Mapping[str, Margins]

    @property
    def stable(self) -> bool:
        """By the eigenvalues of the sampled loop."""
        return self.unstable is None

    @property
    def worst(self) -> tuple[float, float, float]:
        """Least gain [dB], phase [deg] and disk margin over valves, motions and readings, and all valves at once."""
        gain, phase, disk = (one[0] for one in self.worst_places)
        return gain, phase, disk

    @property
    def worst_places(self) -> tuple[tuple[float, str], ...]:
        """The same margins, each with the place that has it."""
        kinds = (("valve ", self.valves), ("", self.motions), ("reading ", self.readings))
        found = [(f"{kind}{name}", one) for kind, places in kinds for name, one in places.items()]
        gain, phase, disk = (
            min((getattr(one, name), place) for place, one in found) for name in ("gain", "phase", "disk")
        )
        return gain, phase, min(disk, (self.disk, "all valves at once"))

    @classmethod
    def worst_of(cls, found: "Sequence[LoopReport]") -> "LoopReport":
        """The least of each margin at each place among several; the pole that grows fastest, if one does."""
        poles = [one.unstable for one in found if one.unstable is not None]

        def places(kind: str) -> dict[str, Margins]:
            tables = [getattr(one, kind) for one in found]
            return {name: Margins.worst_of([table[name] for table in tables]) for name in tables[0]}

        return cls(
            max(poles, key=lambda pole: pole.growth, default=None),
            min(one.disk for one in found),
            *map(places, ("valves", "motions", "readings")),
        )

    def to_dict(self, places: Sequence[str] = ("valves", "motions", "readings")) -> dict[str, Any]:
        """As plain data, with the margins at some kinds of ``places``."""
        gain, phase, disk = self.worst
        chosen = {name: {key: m.to_dict() for key, m in getattr(self, name).items()} for name in places}
        return {
            "stable": self.stable, "gain_db": finite(gain), "phase_deg": finite(phase), "disk": disk,
            "disk_all_valves": self.disk, **chosen, "unstable": self.unstable and self.unstable.to_dict(),
        }  # fmt: skip


def grid(law: LinearController, model: LinearModel | None = None, dense: int = 1) -> Array:
    """Frequencies at which loops are looked at [Hz]: 0.02 Hz to just below half the rate, dense about resonances, the
    law's own too; ``dense`` times as many for smooth pictures."""
    half = 0.5 / max(part.period for part in law.parts)
    found = [np.geomspace(0.02, 0.99 * half, 250 * dense), np.geomspace(20.0, min(700.0, 0.9 * half), 150 * dense)]
    if model is not None:
        poles = np.linalg.eigvals(model.A)
        for pole in poles[poles.imag > 0]:
            centre, width = abs(pole) / (2 * np.pi), abs(pole.real) / (2 * np.pi)
            found.append(centre + width * np.linspace(-4.0, 4.0, 17))
    for part in law.parts:
        found += [np.concatenate([centre - off, [centre], centre + off]) for centre, off in _resonances(part)]
    together = np.unique(np.concatenate(found))
    return together[(together >= 0.02) & (together < half)]


def _resonances(law: Controller) -> Iterator[tuple[float, Array]]:
    """Frequencies at which a law by itself rings for long [Hz], and distances from each over which its gain falls."""
    values = np.linalg.eigvals(law.A) if law.states else np.zeros(0)
    for pole in np.log(values[values.imag > 0.0]) / law.period:
        size = abs(pole)
        if -pole.real < NARROW * size:
            least = max(-pole.real, 1e-4 * size)
            yield pole.imag / (2 * np.pi), np.geomspace(0.3 * least, 0.3 * size, 24) / (2 * np.pi)


def patterns_of(plant: Plant) -> tuple[str, ...]:
    """The patterns in which the valves of active mounts move together: heave, roll, pitch and warp of four upright."""
    return plant.central.patterns


def of_active(sensitivity: ComplexArray, plant: Plant) -> ComplexArray:
    """The sensitivity (f, valve, valve) at the valves of active mounts; the others get nothing."""
    own = np.flatnonzero(plant.layout.active)
    return sensitivity if own.size == sensitivity.shape[1] else sensitivity[:, own[:, None], own]


def in_patterns(sensitivity: ComplexArray, plant: Plant) -> ComplexArray:
    """The sensitivity (f, valve, valve) as that of `patterns_of` a plant's valves, (f, pattern, pattern)."""
    basis = plant.obeying.central.pattern_basis
    return np.asarray(np.linalg.inv(basis) @ of_active(sensitivity, plant) @ basis, complex)


def loop_gains(model: LinearModel, loop: Loop, hertz: ArrayLike) -> dict[str, ComplexArray]:
    """Loop gain of each of `patterns_of` with the others closed, at frequencies below half the rate [Hz]."""
    moved = in_patterns(opened(model, loop, hertz).sensitivity, model.plant)
    return {name: loop_of(moved[:, k, k]) for k, name in enumerate(patterns_of(model.plant))}


def report(model: LinearModel, loop: Loop, hertz: ArrayLike | None = None) -> LoopReport:
    """Margins at every place where the loop can be broken; of a law that follows lines the least that any of three has
    there: with these where they are stated, and all at one end of their ranges, or the other.

    Args:
        model: linearised machine.
        loop: whose law measures something of the machine.
        hertz: frequencies [Hz]; `grid` without.

    Raises:
        ValueError: if the law only measures the ground: there is no loop.
    """
    if not feeds_back(loop.law):
        raise ValueError("the law measures nothing of the machine: there is no loop")
    found = [_report(model, loop, hertz)]
    if any(line.low < line.high for line in loop.law.lines):
        found += [_report(model, replace(loop, law=loop.law.turned(end)), hertz) for end in ENDS]
    return LoopReport.worst_of(found)


def _report(model: LinearModel, loop: Loop, hertz: ArrayLike | None) -> LoopReport:
    """Margins with lines where they stand."""
    law = loop.law
    f = grid(law, model) if hertz is None else np.atleast_1d(np.asarray(hertz, float))
    cut = opened(model, loop, f)
    sensitivity = cut.sensitivity
    moved, valves = in_patterns(sensitivity, model.plant), of_active(sensitivity, model.plant)
    at_readings = 1.0 + np.einsum("fki,fij,fjk->fk", cut.plant, sensitivity, cut.law, optimize=True)
    return LoopReport(
        unstable_pole(model, loop),
        disk_margin(valves),
        {mount: margins(f, loop_of(valves[:, k, k])) for k, mount in enumerate(model.plant.obeying.mounts)},
        {name: margins(f, loop_of(moved[:, k, k])) for k, name in enumerate(patterns_of(model.plant))},
        {law.inputs[k]: margins(f, loop_of(at_readings[:, k])) for k in own_readings(law)},
    )


def margins_behind(model: LinearModel, loop: Loop, factors: ArrayLike) -> Array:
    """Least gain [dB], phase [deg] and disk margin at valves and `patterns_of` them, each valve's gain times a factor.

    Args:
        model: linearised machine.
        loop: whose law measures something of the machine.
        factors: (n,), complex, as a describing function's.

    Returns:
        (n, 3).
    """
    f, found = grid(loop.law, model), []
    cut = opened(model, loop, f)
    for factor in np.atleast_1d(np.asarray(factors, complex)):
        sensitivity = Opened(factor * cut.law, cut.plant).sensitivity
        moved = in_patterns(sensitivity, model.plant), of_active(sensitivity, model.plant)
        each = [margins(f, loop_of(one[:, k, k])) for one in moved for k in range(one.shape[1])]
        found.append([min(m.gain for m in each), min(m.phase for m in each), min(m.disk for m in each)])
    return np.array(found)


def loop_of(sensitivity: NDArray[Any]) -> NDArray[Any]:
    """L of S = 1/(1 + L); where S is nothing to its last digit, one that is as large as numbers are."""
    return np.asarray(1.0 / np.where(np.abs(sensitivity) < VANISHED, VANISHED, sensitivity) - 1.0)


def disk_margin(sensitivity: ComplexArray) -> float:
    """Balanced disk margin of all loops at once: 1/max µ(S − 1/2), µ for complex, diagonal changes (SLICOT AB13MD).

    Args:
        sensitivity: S, (frequency, n, n).
    """
    from slycot import ab13md

    n = sensitivity.shape[1]
    blocks, kinds = np.ones(n, int), np.full(n, 2)
    centred = sensitivity - 0.5 * np.eye(n)
    # µ lies between the spectral radius and the largest singular value: where that is small, µ cannot be the largest.
    upper = np.linalg.norm(centred, 2, axis=(1, 2))
    lower = np.abs(np.linalg.eigvals(centred)).max(axis=1)
    worth = np.flatnonzero(upper >= lower.max() * (1.0 - 1e-9))
    mu = max(float(ab13md(np.ascontiguousarray(centred[k]), blocks, kinds)[0]) for k in worth)
    return 1.0 / max(mu, 0.5)


def margins(hertz: Array, loop: NDArray[Any]) -> Margins:
    """Margins of one loop gain (n,) at frequencies (n,) [Hz], interpolated between them."""
    size, turn = np.abs(loop), np.unwrap(np.angle(loop))
    sensitivity = 1.0 / (1.0 + loop)
    disk = 1.0 / max(float(np.abs(sensitivity - 0.5).max()), 0.5)
    log = np.log(np.maximum(size, 1e-300))
    crossed = np.flatnonzero(log[:-1] * log[1:] < 0)
    share = log[crossed] / (log[crossed] - log[crossed + 1])
    angle = turn[crossed] + share * (turn[crossed + 1] - turn[crossed])
    crossings = hertz[crossed] + share * (hertz[crossed + 1] - hertz[crossed])
    off = np.abs((angle + 2 * np.pi) % (2 * np.pi) - np.pi)  # distance to −180°
    halves = np.floor((turn + np.pi) / (2 * np.pi))
    through = np.flatnonzero(halves[:-1] != halves[1:])
    target = np.maximum(halves[through], halves[through + 1]) * 2 * np.pi - np.pi
    part = (target - turn[through]) / (turn[through + 1] - turn[through])
    level = log[through] + part * (log[through + 1] - log[through])
    worst = int(np.argmax(np.abs(sensitivity)))
    return Margins(
        gain=float(np.abs(20.0 / np.log(10.0) * level).min(initial=np.inf)),
        phase=float(np.degrees(off.min(initial=np.inf))),
        disk=disk,
        peak=float(np.abs(sensitivity[worst])),
        peak_hertz=float(hertz[worst]),
        crossings=tuple(float(value) for value in crossings),
    )
