"""The stage beside the laws, compiled: what is added to a wanted voltage so that a real valve gives the wanted flow.

At a sample the laws want the voltage u, which leads the spool's lag. Their wanted opening is thus what a spool of the
known valve makes of K_v·u; the real valve needs another one (`ehamj.control.compiled.opening`), and the spool must
stand to one side of it by its play. While little is wanted, the spool keeps to its side of the overlap
(`ehamj.control.compiled.opening.place_of`): across it a loop would hunt. The difference c is led by the valve's lag as
u is,

    Δ = (s²/ω² + 2ζ s/ω + 1)/(τ s + 1)²·c,

and the 2τ that this rolls off is led before, in the wanted opening. Where nothing is made good c is zero, and so is Δ.
It fades in as the commands do, and is queued, held and added as the output of a law is (the last in
`ehamj.control.compiled.laws.Laws.table`).

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
    asked_at,
    edges_of,
    keeps_side,
    known,
    leaning,
    opening_for,
    place_of,
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
    renewed: float
    """Share of the mean square of the wanted opening that a sample makes up."""


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
    place: float
    """Where in its band the jump across the overlap is [mA]."""
    level: float
    """Mean square of the wanted opening [mA²]."""


REMEMBERS: Final = len(Remembered._fields)
LEVEL: Final = Remembered._fields.index("level")


@kernel
def pressures_at(readings, channels, valve, lane, own, lanes):  # type: ignore[no-untyped-def]
    """Pressures of a valve from the readings of a sample; the supply's as it is stated where it is not read."""
    if own.least >= own.most:
        return Pressures(0.0, 0.0, own.supply)
    width = len(lanes)
    one, two = channels[2 * valve] * width + lane, channels[2 * valve + 1] * width + lane
    fed = readings[channels[channels.size - 1] * width + lane] if own.supply_measured != 0.0 else own.supply
    return Pressures(readings[one], readings[two], fed)


@kernel
def linearised(share, readings, laws, memory, place, lanes):  # type: ignore[no-untyped-def]
    """What fade and the valves' ranges take from what the laws want of each valve (and lane), applied − wanted [V]; and
    what is added to it, put at a place of the laws' memory (−1: the stage takes no sample)."""
    width, valves, numbers = len(lanes), memory.totals.size // 2, memory.known
    for i in range(valves):
        valve, lane = i // width, i % width
        first = valve * KNOWN * width + lane
        own, curve = known(numbers, first, lanes), first + FIELDS * width
        edges = edges_of(pressures_at(readings, laws.pressures, valve, lane, own, lanes), own)
        total, gain = memory.totals[i], 1.0
        wanted = total
        if laws.learners.size > 0:
            used = learnt(memory.values, used_at(valve, lane, laws, lanes), lanes)
            slow = memory.gathered[(valve * GATHERS + SLOW) * width + lane]
            wanted = corrected(total, slow, learner(laws.learners, valve * LEARNER * width + lane, lanes), used)
            gain = used.flow_gain
        side, applied = -1.0, share * wanted
        far = max(own.reach - own.play, 0.0)
        for _ in range(2):
            bound = asked_at(side * far, edges, own, numbers, curve, lanes)
            applied = max(applied, bound) if side < 0.0 else min(applied, bound)
            side = 1.0
        memory.totals[valves + i] = gain * (applied - wanted)
        if place >= 0:
            state = valve * REMEMBERS * width + lane
            spool = memory.stage[state]
            more = added(applied, share, edges, own, numbers, first, memory.stage, state, lanes)
            memory.values[place + i] = more + share * (wanted - total)
            if laws.learners.size > 0:
                clipped = abs(more + share * wanted) > min(laws.converter.limit, laws.ranges[i])
                learn(spool, state, clipped, edges, own, i, readings, laws, memory, lanes)


@kernel
def added(applied, share, edges, own, numbers, first, kept, state, lanes):  # type: ignore[no-untyped-def]
    """What is added to a wanted voltage that the valve can give [V]; its states go on."""
    width, step = len(lanes), moves(numbers, first, lanes)
    spool, rate = kept[state], kept[state + width]
    lag, slope = kept[state + 4 * width], kept[state + 5 * width]
    target, wanted = own.valve_gain * applied, spool + step.ahead * rate
    level = kept[state + 7 * width] + step.renewed * (wanted * wanted - kept[state + 7 * width])
    place = place_of(wanted, kept[state + 6 * width], level, own)
    kept[state + 6 * width], kept[state + 7 * width] = place, level
    opening = opening_for(wanted, place, edges, own, numbers, first + FIELDS * width, lanes)
    lean = leaning(kept[state + 2 * width], opening, kept[state + 3 * width], own)
    more = share * (opening + own.play * lean - own.offset - wanted)
    kept[state] = step.spool_from_spool * spool + step.spool_from_rate * rate + step.spool_from_target * target
    kept[state + width] = step.rate_from_spool * spool + step.rate_from_rate * rate + step.rate_from_target * target
    kept[state + 2 * width], kept[state + 3 * width] = opening, lean
    kept[state + 4 * width] = step.lag_from_lag * lag + step.lag_from_slope * slope + step.lag_from_more * more
    kept[state + 5 * width] = step.slope_from_lag * lag + step.slope_from_slope * slope + step.slope_from_more * more
    return (step.led_more * more + step.led_lag * lag + step.led_slope * slope) / own.valve_gain


@kernel
def used_at(valve, lane, laws, lanes):  # type: ignore[no-untyped-def]
    """Where in the laws' memory what is learnt of a valve begins."""
    return (laws.table[laws.table.size - 1].states_at + valve * USED) * len(lanes) + lane


@kernel
def learn(spool, state, clipped, edges, own, i, readings, laws, memory, lanes):  # type: ignore[no-untyped-def]
    """Let one mount learn from a sample, and take what it finds into what is known of its valve; ``state``: where what
    the stage remembers of it begins, ``clipped``: the led voltage goes beyond what the converter or the valve takes,
    though what the law wants does not. Nothing is learnt either while the spool keeps to its side of an overlap."""
    width, valves = len(lanes), memory.totals.size // 2
    valve, lane = i // width, i % width
    first, place = valve * LEARNER * width + lane, valve * GATHERS * width + lane
    of, pace = learner(laws.learners, first, lanes), paced(laws.learners, first, lanes)
    where = used_at(valve, lane, laws, lanes)
    used = learnt(memory.values, where, lanes)
    overlap = 0.5 * (min(own.supply_1, own.tank_2) + min(own.tank_1, own.supply_2))
    held = overlap > 0.0 and keeps_side(memory.stage[state + 7 * width], own)
    if clipped or held or memory.totals[valves + i] != 0.0:
        memory.gathered[place + FROZEN * width] = pace.settling
    slow = place + SLOW * width
    applied = memory.totals[i] + memory.totals[valves + i]
    memory.gathered[slow] += pace.slow * (applied - memory.gathered[slow])
    through = edges.supply_1 + edges.tank_2 if spool >= 0.0 else edges.tank_1 + edges.supply_2
    by_overlap, by_play = edge_slopes(spool, own.band, overlap, memory.stage[state + 3 * width], through)
    pressure_1 = readings[laws.pressures[2 * valve] * width + lane]
    pressure_2 = readings[laws.pressures[2 * valve + 1] * width + lane]
    force = of.area_1 * pressure_1 - of.area_2 * pressure_2
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
