"""Measured modes beside computed ones as a person reads them: which is which, how far apart, and what has no pair."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.identification.modal.compared import alike, at_sensors, groups, likely
from ehamj.identification.modal.computed import Computed
from ehamj.linear.pairing import likely_pairs
from ehamj.measured.modes import MeasuredModes
from ehamj.measured.rigid import misplaced

RIGID: Final = 0.7
"""Share of a measured shape below which it is no motion of a rigid machine."""


@dataclass(frozen=True)
class Pair:
    """One measured mode, and the computed one that it is, if any.

    ``mac`` is that of their shapes at the sensors; ``together`` the share of the measured shape that lies in the
    computed ones of its group of close modes, where there is more than one. NaN: nothing was measured that tells it.
    """

    frequency: float
    frequency_deviation: float
    damping_ratio: float
    damping_deviation: float
    name: str
    """Of the computed mode; "" where there is none."""
    computed_frequency: float = float("nan")
    computed_damping_ratio: float = float("nan")
    mac: float = float("nan")
    together: float = float("nan")
    why: str = ""
    """Why it has no pair."""

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "frequency_hz": self.frequency,
            "frequency_deviation_hz": self.frequency_deviation,
            "damping_ratio": finite(self.damping_ratio),
            "damping_ratio_deviation": finite(self.damping_deviation),
            "name": self.name or None,
            "computed_frequency_hz": finite(self.computed_frequency),
            "computed_damping_ratio": finite(self.computed_damping_ratio),
            "mac": finite(self.mac),
            "mac_of_close_modes": finite(self.together),
            "why": self.why or None,
        }


@dataclass(frozen=True)
class Pairing:
    """All measured modes beside the computed ones."""

    pairs: tuple[Pair, ...]
    measured: tuple[str, ...]
    """What the measured modes are called, (k,)."""
    computed: tuple[str, ...]
    """Names of the computed modes, (m,)."""
    mac: Array
    """Of their shapes, (k, m)."""
    missed: tuple[str, ...]
    """Computed modes that were not measured, with their frequencies."""
    words: str
    """What was measured, and how modes were found in it."""
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "modes": [pair.to_dict() for pair in self.pairs],
            "mac": {"measured": list(self.measured), "computed": list(self.computed), "values": self.mac.tolist()},
            "not_measured": list(self.missed),
            "method": self.words,
            "notes": list(self.notes),
        }


def rigid_shares(measured: MeasuredModes, positions: Array) -> Array:
    """Share of each measured shape that a rigid machine can have at these sensors, (k,); one where there are too few
    sensors to tell."""
    rows = measured.sensors.rows(positions)
    basis = np.linalg.svd(rows, full_matrices=False)
    kept = basis[0][:, basis[1] > 1e-9 * basis[1].max(initial=1.0)]
    if kept.shape[1] >= rows.shape[0]:
        return np.ones(measured.frequency.size)
    inside = np.linalg.norm(kept.T @ measured.shape.T, axis=0)
    return np.asarray((inside / np.linalg.norm(measured.shape, axis=1)) ** 2)


def check_places(measured: MeasuredModes, positions: Array) -> None:
    """Refuse sensors that are not where or as they are said to be (`ehamj.measured.rigid`).

    Raises:
        InputError: naming which, where there were enough of them to tell.
    """
    sensors = measured.sensors
    moving = np.flatnonzero(sensors.turns == 0)
    if moving.size and (
        said := misplaced(
            [sensors.names[int(k)] for k in moving],
            sensors.at(positions)[moving],
            sensors.directions[moving],
            measured.shape.T[moving],
        )
    ):
        raise InputError(f"measurement: {said}")


def left_out(measured: MeasuredModes, positions: Array) -> dict[int, str]:
    """Measured modes that no rigid machine has, and why."""
    shares = rigid_shares(measured, positions)
    return {
        int(k): f"{shares[k]:.0%} of its shape is a motion of a rigid machine: a part of it bends, or a disturbance"
        for k in np.flatnonzero(shares < RIGID)
    }


def pairing(measured: MeasuredModes, computed: Computed) -> Pairing:
    """Which measured mode is which computed one.

    Raises:
        InputError: if none is like any, or a sensor is not as it is said to be: the message says what to check.
    """
    check_places(measured, computed.positions)
    strange = left_out(measured, computed.positions)
    like = likely(measured, computed)
    like[list(strange)] = 0.0
    pairs, similar = likely_pairs(like), alike(measured, computed)
    if not pairs:
        raise InputError(nothing_alike(measured, computed))
    together = _together(measured, computed, pairs)
    rows = []
    for k in range(measured.frequency.size):
        own = (
            float(measured.frequency[k]),
            float(measured.frequency_deviation[k]),
            float(measured.damping_ratio[k]),
            float(measured.damping_deviation[k]),
        )
        if k not in pairs:
            rows.append(Pair(*own, "", why=strange.get(k, "no computed mode is like it")))
            continue
        at = pairs[k]
        mac = float(similar[k, at]) if measured.sensors.names else float("nan")
        values = float(computed.frequency[at]), float(computed.damping_ratio[at])
        rows.append(Pair(*own, computed.names[at], *values, mac, together.get(k, float("nan"))))
    missed = tuple(
        f"{name} ({hertz:.4g} Hz)"
        for at, (name, hertz) in enumerate(zip(computed.names, computed.frequency, strict=True))
        if at not in pairs.values()
    )
    return Pairing(tuple(rows), measured.names, computed.names, similar, missed, measured.words, measured.notes)


def nothing_alike(measured: MeasuredModes, computed: Computed) -> str:
    """What a user is told where no mode is like any."""
    found, expected = (
        (f"{hertz.min():.4g} to {hertz.max():.4g} Hz") for hertz in (measured.frequency, computed.frequency)
    )
    return (
        f"file: none of its modes ({found}) is like one of the machine's ({expected}): check the sensors' places and "
        "directions (measurement), that frequencies are in Hz, and the machine's mass and stiffnesses"
    )


def _together(measured: MeasuredModes, computed: Computed, pairs: Mapping[int, int]) -> dict[int, float]:
    """Share of each measured shape in the computed ones of its group, where that has several."""
    shapes: ComplexArray = at_sensors(measured, computed)
    found = {}
    for group in groups(measured):
        own = [k for k in group if k in pairs]
        if len(own) < 2:
            continue
        basis = np.linalg.qr(shapes[:, [pairs[k] for k in own]])[0]
        for k in own:
            inside = np.linalg.norm(basis.conj().T @ measured.shape[k])
            found[k] = float((inside / np.linalg.norm(measured.shape[k])) ** 2)
    return found
