"""Spool feedback, compiled: a loop about each valve's spool, at a rate of its own, behind the laws and their stage.

Of the voltage u that all others hold the spool is to make what the known valve would, r = K_v·u behind its lag. What is
measured of it, p, is held against the reference as its sensor would show it, a delay later. From sample to sample, with
q = e^(−h/τ) and a₁, a₀ of the known valve's poles, z² + a₁ z + a₀,

    e = r − T_m ṙ − p,    Δ = ω_c h/(1 − z⁻¹)·(1 + a₁ z⁻¹ + a₀ z⁻²)/(1 + a₁ + a₀)·((1 − q)/(1 − q z⁻¹))²·e/K_v,

an integral behind the valve's inverse, is added to u. A valve as it is known has no error, for the reference is driven
no harder than its spool. The sum is held where the loop's own range or the converter ends, and the error fades in as
the commands do.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek
from ehamj.control.spools import KnownSpool


class Paces(NamedTuple):
    """How a loop goes from sample to sample; follows what is `KnownSpool` in memory."""

    spool_from_spool: float
    spool_from_rate: float
    spool_from_target: float
    rate_from_spool: float
    rate_from_rate: float
    rate_from_target: float
    """The known valve, its target held."""
    kept: float
    """q."""
    now: float
    """What is added over the rolled-off error of this sample, of the last, and of the one before [V/mA]."""
    last: float
    before: float


class Followed(NamedTuple):
    """Of one valve, from sample to sample."""

    spool: float
    """The reference [mA]."""
    spool_rate: float
    """[mA/s]"""
    rolled: float
    """The error, rolled off once [mA]."""
    error: float
    """Twice."""
    last: float
    """That of the sample before."""
    sum: float
    """What is added [V]."""


FIELDS: Final = len(KnownSpool._fields)
SPOOL: Final = FIELDS + len(Paces._fields)
"""Numbers of a valve in memory."""
FOLLOWS: Final = len(Followed._fields)


def _reader(kind: Any, first: int) -> Any:
    entries = ", ".join(f"peek(numbers, at + {first + k} * len(lanes))" for k in range(len(kind._fields)))
    return written("numbers, at, lanes", f"return {kind.__name__}({entries})", **{kind.__name__: kind}, peek=peek)


spool_known: Any = _reader(KnownSpool, 0)
spool_paces: Any = _reader(Paces, FIELDS)
spool_states: Any = _reader(Followed, 0)
"""What there is of a valve whose numbers begin at a place."""


@kernel
def fed_back(share, readings, laws, memory, number, place, lanes):  # type: ignore[no-untyped-def]
    """Let the loop about each spool take a sample, and put what it adds [V] at a place of the laws' memory; ``number``
    is that of its own row in the table."""
    width = len(lanes)
    for i in range(memory.totals.size // 2):
        valve, lane = i // width, i % width
        volts = 0.0
        for k in range(laws.table.size):
            if k != number:
                volts += memory.values[laws.table[k].held * width + i]
        limit = min(laws.converter.limit, laws.ranges[i])
        position = readings[laws.positions[valve] * width + lane]
        first, at = valve * SPOOL * width + lane, valve * FOLLOWS * width + lane
        memory.values[place + i] = follow(share, volts, limit, position, laws.spools, first, memory.spools, at, lanes)


@kernel
def follow(share, volts, limit, position, numbers, first, kept, at, lanes):  # type: ignore[no-untyped-def]
    """What is added [V] beside what others hold, within the converter's ``limit``; the loop's states go on."""
    width = len(lanes)
    own, step = spool_known(numbers, first, lanes), spool_paces(numbers, first, lanes)
    state = spool_states(kept, at, lanes)
    away = own.valve_gain * min(max(volts, -limit), limit) - state.spool
    most = own.drive_limit / (own.valve_frequency * own.valve_frequency)
    target = state.spool + min(max(away, -most), most)
    error = share * (state.spool - own.lag * state.spool_rate - position)
    rolled = step.kept * state.rolled + (1.0 - step.kept) * error
    error = step.kept * state.error + (1.0 - step.kept) * rolled
    total = state.sum + (step.now * error + step.last * state.error + step.before * state.last)
    total = min(max(total, max(-own.limit, min(-limit - volts, 0.0))), min(own.limit, max(limit - volts, 0.0)))
    kept[at] = (
        step.spool_from_spool * state.spool + step.spool_from_rate * state.spool_rate + step.spool_from_target * target
    )
    kept[at + width] = (
        step.rate_from_spool * state.spool + step.rate_from_rate * state.spool_rate + step.rate_from_target * target
    )
    kept[at + 2 * width], kept[at + 3 * width], kept[at + 4 * width] = rolled, error, state.error
    kept[at + 5 * width] = total
    return total
