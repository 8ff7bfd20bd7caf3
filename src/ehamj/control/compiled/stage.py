"""The stage beside the laws, compiled: what is added to a wanted voltage so that a real valve gives the wanted flow.

At a sample the laws want the voltage u, which leads the spool's lag. Their wanted opening is thus what a spool of the
known valve makes of K_v·u; the real valve needs another one (`ehamj.control.compiled.opening`), and the spool must
stand to one side of it by its play. The difference c is led by the valve's lag as u is,

    Δ = (s²/ω² + 2ζ s/ω + 1)/(τ s + 1)²·c,

and the 2τ that this rolls off is led before, in the wanted opening. Where nothing is made good c is zero, and so is Δ.
It is queued, held and added as the output of a law is (the last in `ehamj.control.compiled.laws.Laws.table`).

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek
from ehamj.control.compiled.learning import (
    FROZEN,
    GATHERS,
    LEARNER,
    SLOW,
    USED,
    corrected,
    edge_slopes,
    learner,
    learns,
    learnt,
    paced,
)
from ehamj.control.compiled.opening import (
    FIELDS,
    SIZE,
    Pressures,
    edges_of,
    known,
    leaning,
    opening_for,
    range_of,
)
from ehamj.control.valves import Known

SUPPLY_1, PLAY_AT, OFFSET = (Known._fields.index(name) for name in ("supply_1", "play", "offset"))


class Moves(NamedTuple):
    """How the stage goes from sample to sample; follows what is `Known` of a valve in memory."""

    spool_from_spool: float
    spool_from_rate: float
    spool_from_target: float
    rate_from_spool: float
    rate_from_rate: float
    rate_from_target: float
    """The known valve, its target held."""
    lag_from_lag: float
    lag_from_slope: float
    lag_from_more: float
    slope_from_lag: float
    slope_from_slope: float
    slope_from_more: float
    """1/(τ s + 1)² of what is added, held."""
    ahead: float
    """2τ [s]."""
    led_more: float
    led_lag: float
    led_slope: float
    """What is added from itself and from what is rolled off."""


KNOWN: Final = SIZE + len(Moves._fields)
"""Numbers of a valve in memory."""
moves: Any = written(
    "numbers, at, lanes",
    f"return Moves({', '.join(f'peek(numbers, at + {SIZE + k} * len(lanes))' for k in range(len(Moves._fields)))})",
    Moves=Moves, peek=peek,
)  # fmt: skip
"""`Moves` of a valve whose numbers begin at a place."""


class Remembered(NamedTuple):
    """Of one valve, from sample to sample."""

    spool: float
    """Of the known valve [mA]."""
    spool_rate: float
    """[mA/s]"""
    opening: float
    """That the edges were to have [mA]."""
    lean: float
    """To which side of its play the spool stands, −1 to 1."""
    lagged: float
    """What is added, rolled off [mA]."""
    lagged_rate: float
    """[mA/s]"""


REMEMBERS: Final = len(Remembered._fields)


@kernel
def pressures_at(readings, channels, valve, lane, stated, lanes):  # type: ignore[no-untyped-def]
    """Pressures of a valve from the readings of a sample; ``stated`` is the supply's where it is not read."""
    if channels.size == 0:
        return Pressures(0.0, 0.0, stated)
    width = len(lanes)
    one, two = channels[2 * valve] * width + lane, channels[2 * valve + 1] * width + lane
    fed = readings[channels[channels.size - 1] * width + lane] if channels.size % 2 > 0 else stated
    return Pressures(readings[one], readings[two], fed)


@kernel
def ranged(total, share, readings, laws, memory, lost, lanes):  # type: ignore[no-untyped-def]
    """What fade and the valves' ranges take from the wanted voltages of each valve (and lane), applied − wanted.

    What laws that learn make of the wanted voltages is put in memory.
    """
    width, asked = len(lanes), memory.asked
    for i in range(total.size):
        valve, lane = i // width, i % width
        first = valve * KNOWN * width + lane
        own = known(memory.known, first, lanes)
        at = pressures_at(readings, laws.pressures, valve, lane, own.supply, lanes)
        low, high = range_of(at, own, memory.known, first + FIELDS * width, lanes)
        gain = 1.0
        asked[i] = total[i]
        if laws.learners.size > 0:
            used = learnt(memory.values, used_at(valve, lane, laws, lanes), lanes)
            slow = memory.gathered[valve * GATHERS * width + lane + SLOW * width]
            asked[i] = corrected(total[i], slow, learner(laws.learners, valve * LEARNER * width + lane, lanes), used)
            gain = used.flow_gain
        lost[i] = (min(max(share * asked[i], low), high) - asked[i]) * gain


@kernel
def used_at(valve, lane, laws, lanes):  # type: ignore[no-untyped-def]
    """Where in the laws' memory what is learnt of a valve begins."""
    return (laws.table[laws.table.size - 1].states_at + valve * USED) * len(lanes) + lane


@kernel
def added(share, readings, laws, memory, place, lanes):  # type: ignore[no-untyped-def]
    """Put what is added to what the laws want of each valve (and lane) [V] at a place of the laws' memory."""
    width, valves, kept = len(lanes), memory.totals.size // 2, memory.stage
    for i in range(valves):
        valve, lane = i // width, i % width
        first, state = valve * KNOWN * width + lane, valve * REMEMBERS * width + lane
        own, step = known(memory.known, first, lanes), moves(memory.known, first, lanes)
        at = pressures_at(readings, laws.pressures, valve, lane, own.supply, lanes)
        spool, rate = kept[state], kept[state + width]
        lag, slope = kept[state + 4 * width], kept[state + 5 * width]
        target = own.valve_gain * (memory.asked[i] + memory.totals[valves + i])
        wanted = spool + step.ahead * rate
        edges = opening_for(wanted, at, own, memory.known, first + FIELDS * width, lanes)
        lean = leaning(kept[state + 2 * width], edges, kept[state + 3 * width], own)
        more = edges + own.play * lean - share * own.offset - wanted
        led = step.led_more * more + step.led_lag * lag + step.led_slope * slope
        memory.values[place + i] = led / own.valve_gain + share * (memory.asked[i] - memory.totals[i])
        kept[state + 2 * width], kept[state + 3 * width] = edges, lean
        kept[state] = step.spool_from_spool * spool + step.spool_from_rate * rate + step.spool_from_target * target
        rate = step.rate_from_spool * spool + step.rate_from_rate * rate + step.rate_from_target * target
        kept[state + width] = rate
        kept[state + 4 * width] = step.lag_from_lag * lag + step.lag_from_slope * slope + step.lag_from_more * more
        slope = step.slope_from_lag * lag + step.slope_from_slope * slope + step.slope_from_more * more
        kept[state + 5 * width] = slope
        if laws.learners.size > 0:
            learn(spool, lean, at, own, i, readings, laws, memory, lanes)


@kernel
def learn(spool, lean, at, own, i, readings, laws, memory, lanes):  # type: ignore[no-untyped-def]
    """Let one mount learn from a sample, and take what it finds into what is known of its valve."""
    width, valves = len(lanes), memory.totals.size // 2
    valve, lane = i // width, i % width
    first, place = valve * LEARNER * width + lane, valve * GATHERS * width + lane
    of, pace = learner(laws.learners, first, lanes), paced(laws.learners, first, lanes)
    where = used_at(valve, lane, laws, lanes)
    used = learnt(memory.values, where, lanes)
    if memory.totals[valves + i] != 0.0:
        memory.gathered[place + FROZEN * width] = pace.settling
    slow = place + SLOW * width
    applied = memory.totals[i] + memory.totals[valves + i]
    memory.gathered[slow] += pace.slow * (applied - memory.gathered[slow])
    edges = edges_of(at, own)
    through = edges.supply_1 + edges.tank_2 if spool >= 0.0 else edges.tank_1 + edges.supply_2
    overlap = 0.5 * (min(own.supply_1, own.tank_2) + min(own.tank_1, own.supply_2))
    by_overlap, by_play = edge_slopes(spool, own.band, overlap, lean, through)
    force = of.area_1 * at.pressure_1 - of.area_2 * at.pressure_2
    stroke = readings[laws.strokes[valve] * width + lane]
    now = learns(memory.gathered, place, (spool, by_overlap, by_play), force, stroke, used, of, pace, width)
    take_in(now, used, memory.known, valve * KNOWN * width + lane, width)
    for k in range(USED):
        memory.values[where + k * width] = now[k]


@kernel
def take_in(now, used, valves, at, width):  # type: ignore[no-untyped-def]
    """Change what is known of a valve by what is learnt more of it."""
    for k in range(SUPPLY_1, SUPPLY_1 + 4):
        valves[at + k * width] += now.overlap - used.overlap
    valves[at + PLAY_AT * width] += now.play - used.play
    valves[at + OFFSET * width] += now.null_offset - used.null_offset
