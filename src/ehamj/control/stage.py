"""The stage beside the laws made ready for the stepping loop; see `ehamj.control.compiled.stage`."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control.channels import SUPPLY
from ehamj.control.compiled.stage import Moves
from ehamj.control.valves import Known, KnownValve, chambers_of


class Stage(NamedTuple):
    """The stage as one more law: it samples with the fastest, and what it adds waits as long."""

    period: float
    """[s]"""
    latency: float
    """[s]"""
    states: int = 0
    inputs: tuple[str, ...] = ()

    @classmethod
    def beside(cls, parts: Sequence[Any]) -> Self:
        """Beside laws that have a period and a latency [s]."""
        fastest = min(parts, key=lambda part: (part.period, part.latency))
        return cls(fastest.period, fastest.latency)


def numbers_of(valves: Sequence[KnownValve], period: float, voltage_limit: float) -> Array:
    """What is known, as the compiled stage takes it every ``period`` [s] behind a converter of ±``voltage_limit`` [V],
    (valve·KNOWN)."""
    rows = []
    for own, curve in valves:
        bounded = own._replace(reach=min(own.reach, own.valve_gain * voltage_limit))
        rows.append((*bounded, *curve, *_moves(own, period)))
    return np.array(rows, float).ravel()


def _moves(own: Known, period: float) -> Moves:
    """The stage's states from sample to sample, exact for what is held between."""
    natural, time = own.valve_frequency, own.rolloff
    spool = _held(-(natural**2), -2.0 * own.valve_damping * natural, natural**2, period)
    lag = _held(-1.0 / time**2, -2.0 / time, 1.0 / time**2, period)
    share = 1.0 / (natural * time) ** 2
    led = share, 1.0 - share, 2.0 * own.valve_damping / natural - 2.0 * time * share
    return Moves._make([*spool, *lag, 2.0 * time, *led])


def _held(stiffness: float, damping: float, gain: float, period: float) -> list[float]:
    """ẍ = stiffness·x + damping·ẋ + gain·u with u held: x⁺ and ẋ⁺ of x, ẋ and u each."""
    step = scipy.linalg.expm(np.array([[0.0, 1.0, 0.0], [stiffness, damping, gain], [0.0, 0.0, 0.0]]) * period)
    return [float(number) for number in step[:2].ravel()]


def pressure_places(valves: Sequence[KnownValve], mounts: Sequence[str], channels: Sequence[str]) -> NDArray[np.int64]:
    """Where among ``channels`` are the chamber pressures of each valve, −1 where they are not read, and the supply's;
    empty where none is read."""
    if not any(valve.reads_pressure for valve in valves):
        return np.zeros(0, np.int64)
    at = {name: k for k, name in enumerate(channels)}
    names = (*(name for mount in mounts for name in chambers_of(mount)), SUPPLY)
    return np.array([at.get(name, -1) for name in names], np.int64)
