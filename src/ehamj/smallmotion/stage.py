"""What is evaluated at a stage of a step: strokes, isolators, supply, ledger, accelerations; in all lanes."""

from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import add_lanes, add_products, copy_lanes, peek, poke, set_lanes
from ehamj.isolator.edges import Flows
from ehamj.isolator.equations import Plate, balance
from ehamj.isolator.supply import Feed, Supply, SupplyState, supply_rates
from ehamj.memory import OIL, size
from ehamj.smallmotion.floor import Floor, Riding
from ehamj.smallmotion.isolators import (
    AT,
    BLOCK,
    COMMAND,
    DRAWN,
    FORCE,
    INTO_1,
    INTO_2,
    RATE,
    SPEED,
    STATE,
    STROKE,
    SUPPLY,
    SWITCHING,
    isolator_in,
    isolators,
    state_in,
)  # fmt: skip

CONNECTED, PRESSURE, TANK = AT["connected"], AT["supply_pressure"], AT["tank_pressure"]
RATED: Final = AT["rated_pressure"]
OIL_SIZE: Final = size(OIL)


class Lanes(NamedTuple):
    """The machines of all lanes, flat with the lane last; n coordinates, m mounts."""

    forms: Any
    """(m,) see `ehamj.smallmotion.isolators`."""
    blocks: Any
    """(m, `BLOCK`)"""
    levers: Any
    """(m, n) strokes, and plates, per coordinate [m/m, m/rad]."""
    supply: Any
    """`Supply.Values`, or empty: the pressure is constant."""
    sizes: "Sizes"


class Sizes(NamedTuple):
    """What all lanes share."""

    coordinates: int
    activations: int
    supply_at: int
    """Where among the activations the supply's states begin."""
    ledger_at: int
    """Where the ledger's begin; 0: there is none."""
    step: float
    """[s]"""


class Given(NamedTuple):
    """What drives a stretch of steps, at start, middle and end of each; flat with the lane last, empty where nothing
    does."""

    matrix: Any
    """(1 or steps, 1 or 3, 2 n + m, n): accelerations per coordinate, velocity and force."""
    inverse: Any
    """(1 or steps, 1 or 3, n, n): M⁻¹, where a slide moves."""
    pushed: Any
    """(steps, 3, n) accelerations by load and slides [m/s²]."""
    commands: Any
    """(steps, 3, m) beside the law's [V]."""
    floor: Floor
    times: int
    """Of the matrices: 1, or 3 for each step."""
    steps: int

    def part(self, first: int, steps: int) -> "Given":
        """What drives some of the steps."""

        def cut(table: Any) -> Any:
            size = table.size // self.steps
            return table[first * size : (first + steps) * size]

        matrices = self.matrix, self.inverse
        if self.times > 1:
            matrices = cut(self.matrix), cut(self.inverse)
        floor = self.floor.part(first, steps, self.steps)
        return Given(*matrices, cut(self.pushed), cut(self.commands), floor, self.times, steps)


class Commanded(NamedTuple):
    """What the laws command in a step; flat with the lane last."""

    commands: Any
    """(m) from the start of the step [V]."""
    switching: Any
    """(3, m) what switches within the step adds at its start, middle and end [V]."""


class Scratch(NamedTuple):
    """States of all lanes, (2 n + activations)."""

    state: Any
    rate: Any
    """Time derivative at the last stage."""
    start: Any
    """State at the start of the step."""
    total: Any
    """Weighted sum of the rates."""
    riding: Riding


_fields = ", ".join(f"peek(values, {k} * len(lanes) + lane)" for k in range(len(Supply.Values._fields)))
supply_in = written("values, lane, lanes", f"return Values({_fields})", peek=peek, Values=Supply.Values)
"""`Supply.Values` of a lane."""


@kernel
def hand_over(own, given, here, scratch, law, stage, lanes):  # type: ignore[no-untyped-def]
    """Put stroke, speed, command and supply of all mounts into their blocks; ``here`` is 3·step + stage."""
    w, n, mounts, blocks = len(lanes), own.sizes.coordinates, own.forms.size, own.blocks
    # Named once: each look into a tuple of arrays counts references.
    levers, state, strokes, beside = own.levers, scratch.state, scratch.riding.strokes, given.commands
    held, switching, driven = law.commands, law.switching, given.commands.size > 0
    for mount in range(mounts):
        at = mount * BLOCK
        set_lanes(blocks, at + STROKE, strokes, (stage * mounts + mount) * 2, lanes)
        set_lanes(blocks, at + SPEED, strokes, (stage * mounts + mount) * 2 + 1, lanes)
        add_products(blocks, at + STROKE, levers, mount * n, state, 0, (1, 1), n, lanes)
        add_products(blocks, at + SPEED, levers, mount * n, state, n, (1, 1), n, lanes)
        set_lanes(blocks, at + COMMAND, held, mount, lanes)
        set_lanes(blocks, at + SWITCHING, switching, stage * mounts + mount, lanes)
        if driven:
            add_lanes(blocks, at + COMMAND, beside, here * mounts + mount, lanes)
        if own.sizes.supply_at > 0:
            shared = (2 * n + own.sizes.supply_at + 2) * w
            for lane in range(w):
                reached = peek(blocks, (at + CONNECTED) * w + lane) > 0.0
                own_pressure = peek(blocks, (at + PRESSURE) * w + lane)
                poke(blocks, (at + SUPPLY) * w + lane, peek(state, shared + lane) if reached else own_pressure)
        else:
            set_lanes(blocks, at + SUPPLY, blocks, at + PRESSURE, lanes)


@kernel
def supply_stage(own, state, rate, lanes):  # type: ignore[no-untyped-def]
    """Rates of the shared supply's states."""
    w, mounts, blocks = len(lanes), own.forms.size, own.blocks
    at = (2 * own.sizes.coordinates + own.sizes.supply_at) * w
    for lane in range(w):
        drawn = 0.0
        for mount in range(mounts):
            place = mount * BLOCK * w + lane
            drawn += peek(blocks, place + CONNECTED * w) * peek(blocks, place + DRAWN * w)
        now = SupplyState(peek(state, at + lane), peek(state, at + w + lane), peek(state, at + 2 * w + lane))
        found = supply_rates(now, drawn, supply_in(own.supply, lane, lanes))
        poke(rate, at + lane, found.station_pressure)
        poke(rate, at + w + lane, found.line_flow)
        poke(rate, at + 2 * w + lane, found.supply_pressure)


@kernel
def ledger_stage(own, rate, lanes):  # type: ignore[no-untyped-def]
    """Rates of what crosses the chambers' borders, from the rates just found."""
    w, mounts, blocks = len(lanes), own.forms.size, own.blocks
    oil = (2 * own.sizes.coordinates + own.sizes.ledger_at) * w
    books = oil + OIL_SIZE * mounts * w
    for lane in range(w):
        energy, work, supplied, throttled = 0.0, 0.0, 0.0, 0.0
        for mount in range(mounts):
            at = mount * BLOCK * w + lane
            flows = Flows(peek(blocks, at + INTO_1 * w), peek(blocks, at + INTO_2 * w), peek(blocks, at + DRAWN * w))
            plate = Plate(peek(blocks, at + STROKE * w), peek(blocks, at + SPEED * w), 0.0, 0.0)
            feed = Feed(peek(blocks, at + SUPPLY * w), peek(blocks, at + TANK * w), peek(blocks, at + RATED * w))
            state, rates = state_in(blocks, at + STATE * w, lanes), state_in(blocks, at + RATE * w, lanes)
            one, two, power, lost = balance(state, rates, flows, plate, feed, isolator_in(blocks, at, lanes))
            poke(rate, oil + OIL_SIZE * mount * w + lane, one.oil)
            poke(rate, oil + (OIL_SIZE * mount + 1) * w + lane, two.oil)
            energy = energy + one.energy + two.energy
            work = work + one.work + two.work
            supplied += power
            throttled += lost
        poke(rate, books + lane, energy)
        poke(rate, books + w + lane, work)
        poke(rate, books + 2 * w + lane, supplied)
        poke(rate, books + 3 * w + lane, throttled)


@kernel
def accelerate(own, given, here, scratch, stage, lanes):  # type: ignore[no-untyped-def]
    """Velocities and accelerations as rates of coordinates and velocities."""
    n, mounts = own.sizes.coordinates, own.forms.size
    state, rate, blocks, matrix, pushed = scratch.state, scratch.rate, own.blocks, given.matrix, given.pushed
    ridden = scratch.riding.pushed
    first, driven = here * (2 * n + mounts) * n if given.times > 1 else 0, given.pushed.size > 0
    for i in range(n):
        set_lanes(rate, i, state, n + i, lanes)
        set_lanes(rate, n + i, ridden, stage * n + i, lanes)
        if driven:
            add_lanes(rate, n + i, pushed, here * n + i, lanes)
        add_products(rate, n + i, matrix, first + i, state, 0, (n, 1), 2 * n, lanes)
        add_products(rate, n + i, matrix, first + 2 * n * n + i, blocks, FORCE, (n, BLOCK), mounts, lanes)


@kernel
def evaluate(own, given, step, stage, time, law, scratch, lanes):  # type: ignore[no-untyped-def]
    """The time derivative of all lanes at a stage (0 start, 1 middle, 2 end) of a step."""
    here, acts = 3 * step + stage, 2 * own.sizes.coordinates
    hand_over(own, given, here, scratch, law, stage, lanes)
    isolators(own.forms, own.blocks, scratch.state, scratch.rate, acts, time, lanes)
    if own.sizes.supply_at > 0:
        supply_stage(own, scratch.state, scratch.rate, lanes)
    if own.sizes.ledger_at > 0:
        ledger_stage(own, scratch.rate, lanes)
    accelerate(own, given, here, scratch, stage, lanes)


@kernel
def runge_kutta(own, given, step, time, law, scratch, lanes):  # type: ignore[no-untyped-def]
    """The classical step of fourth order of all lanes; the rate at its start has been evaluated."""
    h, size = own.sizes.step, scratch.state.size
    state, rate, start, total = scratch.state, scratch.rate, scratch.start, scratch.total
    copy_lanes(state, 0, start, 0, size)
    copy_lanes(rate, 0, total, 0, size)
    for number in range(1, 4):
        share = 1.0 if number == 3 else 0.5
        for k in range(size):
            state[k] = start[k] + share * h * rate[k]
        evaluate(own, given, step, 2 if number == 3 else 1, time + share * h, law, scratch, lanes)
        weight = 1.0 if number == 3 else 2.0
        for k in range(size):
            total[k] += weight * rate[k]
    for k in range(size):
        state[k] = start[k] + h / 6.0 * total[k]
