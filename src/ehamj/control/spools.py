"""What a law knows of the spool of one valve, behind whose position a loop of its own is closed: numbers that its file
holds, and the loop that they make."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple, Self

import numpy as np
import scipy

from ehamj.arrays import Array
from ehamj.control.blocks import Block
from ehamj.control.clock import SHORTEST
from ehamj.control.instruments import Instrument
from ehamj.control.tables import numbers_in
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant

POSITIVE: Final = ("valve_gain", "valve_frequency", "valve_damping", "drive_limit", "rolloff", "limit", "period")
"""What must be positive of a known spool; the others must not be negative."""


MOST_DELAY: Final = 2e-3
"""Of a loop about a spool [s]: with more, none that is worth its sensor is stable."""


class KnownSpool(NamedTuple):
    """What is known of one valve's spool, and how it is fed back; the compiled part is
    `ehamj.control.compiled.spools`."""

    valve_gain: float
    """K_v [mA/V]."""
    valve_frequency: float
    """ω [rad/s]."""
    valve_damping: float
    """ζ."""
    drive_limit: float
    """a_max [mA/s²]."""
    crossing: float
    """ω_c [rad/s]; 0: not fed back, as of a mount that does not obey."""
    rolloff: float
    """τ [s]."""
    lag: float
    """T_m, delay of the position's reading at low frequency [s]."""
    limit: float
    """Most that is added [V]."""
    period: float
    """Sampling period [s]."""
    delay: float
    """From a sample to its voltage [s]."""
    edges: float
    """1 where the sensor shows the metering edges, 0 where it shows the spool's driven end."""

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return self._asdict()

    @classmethod
    def from_dict(cls, table: Any) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or unknown, or a number is not one, or out of its range.
        """
        numbers = cls(*numbers_in(table, cls._fields, "controller.spools"))
        for name, value in numbers._asdict().items():
            if not math.isfinite(value) or value < 0.0 or (name in POSITIVE and value == 0.0):
                allowed = "positive" if name in POSITIVE else "zero or positive"
                raise InputError(f"controller.spools: {name} = {value:g} must be finite and {allowed}")
        if numbers.period < SHORTEST or numbers.delay > MOST_DELAY:
            raise InputError(
                f"controller.spools: period = {numbers.period:g} s and delay = {numbers.delay:g} s must be at least "
                f"{SHORTEST:g} s and at most {MOST_DELAY:g} s"
            )
        return numbers


def positions(spools: Sequence[KnownSpool], mounts: Sequence[str]) -> tuple[str, ...]:
    """Channels of the positions that are fed back, one per mount; none where none is."""
    return tuple(f"{'edges' if one.edges else 'spool'} {name}" for one, name in zip(spools, mounts, strict=False))


def followed(plant: Plant, spools: Sequence[KnownSpool]) -> Plant:
    """The plant as laws have it where spools are fed back: each follows its command as the known valve does, without
    the threshold, and without the play that its sensor sees beyond."""
    if not spools:
        return plant
    own = []
    for actuator, spool in zip(plant.actuators, spools, strict=True):
        gone = {"valve_gain": spool.valve_gain, "threshold": 0.0} | ({"hysteresis": 0.0} if spool.edges else {})
        changed = {name: value for name, value in gone.items() if value != getattr(actuator, name)}
        own.append(actuator.with_values(changed) if changed and spool.crossing else actuator)
    return replace(plant, actuators=tuple(own))


def opened(own: KnownSpool, sensor: Instrument | None, valve: Actuator | None = None) -> Block:
    """The loop about a spool cut open, from sample to sample: what it adds over its error, then the valve (without one,
    as it is known) and its ``sensor`` over that, with delay and hold."""
    return controller(own).then(_delayed(own, sensor, own if valve is None else valve))


def runs_away(loop: Block) -> float:
    """By which factor a loop that is `opened` grows when it is closed, from sample to sample; below 1 it is stable."""
    return float(np.abs(np.linalg.eigvals(loop.A - loop.B @ loop.C)).max())


def controller(own: KnownSpool) -> Block:
    """What is added over the error [V/mA], from sample to sample."""
    q, taps = kept(own), np.array(taps_of(own))
    lag = Block(np.array([[q]]), np.array([[1.0]]), np.array([[q * (1.0 - q)]]), np.array([[1.0 - q]]))
    inverse = Block(np.array([[0.0, 0.0], [1.0, 0.0]]), np.eye(2, 1), taps[None, 1:], taps[None, :1])
    return lag.then(lag).then(inverse).then(Block(*(np.eye(1),) * 4))


def kept(own: KnownSpool) -> float:
    """q = e^(−h/τ)."""
    return math.exp(-own.period / own.rolloff)


def taps_of(own: KnownSpool) -> tuple[float, ...]:
    """What is added, before it is summed, over the rolled-off errors of a sample and of the two before it [V/mA]."""
    damped = np.roots([1.0, 2.0 * own.valve_damping * own.valve_frequency, own.valve_frequency**2])
    inverse = np.poly(np.exp(damped * own.period)).real
    return tuple((own.crossing * own.period / own.valve_gain * inverse / inverse.sum()).tolist())


def _delayed(own: KnownSpool, sensor: Instrument | None, true: KnownSpool | Actuator) -> Block:
    """Reading of the position of a ``true`` valve over the voltage that is computed [mA/V], from sample to sample."""
    omega = true.valve_frequency
    valve = Block(
        np.array([[0.0, 1.0], [-(omega**2), -2.0 * true.valve_damping * omega]]),
        np.array([[0.0], [true.valve_gain * omega**2]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)),
    )  # fmt: skip
    machine = valve if sensor is None else valve.then(sensor.block())
    whole, part = divmod(own.delay / own.period + 1e-9, 1.0)
    waits, n = int(whole) + 1, len(machine.A)
    late, soon = (_held(machine, share * own.period) for share in (part, 1.0 - part))
    # Over a sample what waits longest acts first, for a part of it, then what follows.
    A, B = np.zeros((n + waits, n + waits)), np.zeros((n + waits, 1))
    A[:n, :n], A[:n, n] = soon[0] @ late[0], soon[0] @ late[1]
    A[n : n + waits - 1, n + 1 :] = np.eye(waits - 1)
    B[-1] = 1.0
    if waits > 1:
        A[:n, n + 1] = soon[1]
    else:
        B[:n, 0] = soon[1]
    return Block(A, B, np.hstack([machine.C, np.zeros((1, waits))]), np.zeros((1, 1)))


def _held(machine: Block, time: float) -> tuple[Array, Array]:
    """States after a time over those before, and over what is held meanwhile."""
    n = len(machine.A)
    step = scipy.linalg.expm(np.block([[machine.A, machine.B], [np.zeros((1, n + 1))]]) * time)
    return step[:n, :n], step[:n, n]
