"""The stage beside the laws made ready for the stepping loop; see `ehamj.control.compiled.stage`."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple, Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control.channels import SUPPLY
from ehamj.control.compiled.learning import FROZEN, GATHERS, USED, Paced
from ehamj.control.compiled.stage import Moves
from ehamj.control.learners import STATED, Learner
from ehamj.control.spools import KnownSpool, kept, taps_of
from ehamj.control.valves import Known, KnownValve, chambers_of

SETTLED = 3.0
"""Periods of the band's lower end after which its filters have forgotten: e^(−6π)."""
LASTING = 0.5
"""Time over which it is taken how much opening is wanted [s]."""
AT_START = 1.0
"""What is taken to have been wanted before the start, RMS [mA]: much."""
SEEN = 1.0
"""Time over which the power of the flow is taken [s]."""


class Stage(NamedTuple):
    """The stage as one more law: it samples with the fastest, and what it adds waits as long. Of laws that wait longer
    it takes what they want then, ahead of its time at the valves."""

    period: float
    """[s]"""
    latency: float
    """[s]"""
    states: int = 0
    inputs: tuple[str, ...] = ()
    lines: tuple[Any, ...] = ()

    @classmethod
    def beside(cls, parts: Sequence[Any], learners: int) -> Self:
        """Beside laws that have a period and a latency [s]; its states are what its ``learners`` have learnt."""
        fastest = min(parts, key=lambda part: (part.period, part.latency))
        return cls(fastest.period, fastest.latency, USED * learners)


class Inner(NamedTuple):
    """The loops about the spools as one more law."""

    period: float
    """[s]"""
    latency: float
    """[s]"""
    states: int = 0
    inputs: tuple[str, ...] = ()
    lines: tuple[Any, ...] = ()

    @classmethod
    def of(cls, spools: Sequence[KnownSpool]) -> Self:
        """Of spools of one period and delay [s]."""
        return cls(spools[0].period, spools[0].delay)


def spool_numbers(spools: Sequence[KnownSpool]) -> Array:
    """What is known of spools, as the compiled loops take it, (valve·SPOOL)."""
    rows = [(*own, *_valve_moves(own, own.period), kept(own), *taps_of(own)) for own in spools]
    return np.array(rows, float).ravel()


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
    natural, time, spool = own.valve_frequency, own.rolloff, _valve_moves(own, period)
    lag = _held(-1.0 / time**2, -2.0 / time, 1.0 / time**2, period)
    share = 1.0 / (natural * time) ** 2
    led = share, 1.0 - share, 2.0 * own.valve_damping / natural - 2.0 * time * share
    return Moves._make([*spool, *lag, 2.0 * time, *led, -math.expm1(-period / LASTING)])


def _valve_moves(own: Known | KnownSpool, period: float) -> tuple[float, ...]:
    """The known valve's spool and its rate from sample to sample, its target held."""
    return _held(
        -(own.valve_frequency**2), -2.0 * own.valve_damping * own.valve_frequency, own.valve_frequency**2, period
    )


@lru_cache(maxsize=64)
def _held(stiffness: float, damping: float, gain: float, period: float) -> tuple[float, ...]:
    """ẍ = stiffness·x + damping·ẋ + gain·u with u held: x⁺ and ẋ⁺ of x, ẋ and u each."""
    step = scipy.linalg.expm(np.array([[0.0, 1.0, 0.0], [stiffness, damping, gain], [0.0, 0.0, 0.0]]) * period)
    return tuple(float(number) for number in step[:2].ravel())


def pressure_places(
    valves: Sequence[KnownValve], mounts: Sequence[str], channels: Sequence[str], learning: bool = False
) -> NDArray[np.int64]:
    """Where among ``channels`` are the chamber pressures of each valve, −1 where they are not read, and the supply's;
    empty where none is read."""
    if not learning and not any(valve.reads_pressure for valve in valves):
        return np.zeros(0, np.int64)
    at = {name: k for k, name in enumerate(channels)}
    names = (*(name for mount in mounts for name in chambers_of(mount)), SUPPLY)
    return np.array([at.get(name, -1) for name in names], np.int64)


def paces_of(learners: Sequence[Learner], valves: Sequence[KnownValve], stage: Stage) -> Array:
    """What learners know and how they learn, as the compiled part takes it, (mount·LEARNER).

    Args:
        learners: one per mount.
        valves: what is known of each mount's valve.
        stage: that they learn in.
    """
    rows = [(*own, *_pace(own, valve.numbers.rolloff, stage)) for own, valve in zip(learners, valves, strict=True)]
    return np.array(rows, float).ravel()


def _pace(own: Learner, rolloff: float, stage: Stage) -> Paced:
    """How one mount learns from block to block."""
    every, ahead = own.samples(stage.period, stage.latency), own.ahead(stage.latency)
    block = every * stage.period
    late = int(ahead / stage.period + 0.5)
    rest = ahead - late * stage.period
    ranges = [max(abs(low), abs(high)) for low, high in zip(own.ranges[::2], own.ranges[1::2], strict=True)]
    ranges = [max(ranges[0] - 1.0, 0.0), ranges[2], ranges[3], max(ranges[1] - 1.0, 0.0)]
    return Paced(
        block=block,
        every=every,
        late=late,
        rest=rest,
        rest_play=rest + 2.0 * rolloff,
        rest_force=own.stroke_lag - own.pressure_lag,
        smooth_low=-math.expm1(-2.0 * math.pi * own.low * block),
        smooth_high=-math.expm1(-2.0 * math.pi * own.high * block),
        kept=math.exp(-block / own.memory),
        seen=-math.expm1(-block / SEEN),
        follow=-math.expm1(-block / own.pace),
        slow=-math.expm1(-own.creep * stage.period),
        settling=math.ceil(SETTLED / (own.low * block)),
        **dict(zip(Paced._fields[-4:], (own.prior / max(one, 1e-9) ** 2 for one in ranges), strict=True)),
    )


def begun(learners: Sequence[Learner], paces: Array) -> Array:
    """What learners remember at the start: nothing, and that no filter has settled, (mount·GATHERS)."""
    gathered = np.zeros((len(learners), GATHERS))
    if len(learners):
        settling = paces.reshape(len(learners), -1)[:, len(Learner._fields) + Paced._fields.index("settling")]
        gathered[:, FROZEN] = settling
    return gathered.ravel()


def stated(learners: Sequence[Learner]) -> Array:
    """What is used before anything is learnt, (mount·USED)."""
    return np.tile(STATED, len(learners)).astype(float)
