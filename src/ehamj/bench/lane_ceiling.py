"""The benchmark's equations in a bare compiled loop over many machines side by side: the ceiling of lanes.

What `ehamj.bench.ceiling` computes of one machine is done to all of them at once, by the same kernels in the same
order, so that each has the bits that it has alone: structure of arrays, the machine last, their number a constant for
the compiler. Machines have parameters of their own; their commands share frequencies, so that a sine serves all. With
fewer than 16 machines the compiler leaves the loop over them scalar: so few rounds do not pay for the check that arrays
do not overlap.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.bench.ceiling import N, System
from ehamj.compiled import kernel
from ehamj.compiled.kept import compiled
from ehamj.compiled.lanes import peek, poke
from ehamj.isolator.cylinder import Cylinder
from ehamj.isolator.edges import Edges, chamber_flows
from ehamj.isolator.fluid import Fluid, pressure_rate
from ehamj.isolator.membrane import Membrane, lift, pull
from ehamj.isolator.spool import Command, Spool, full_stroke, spool_acceleration, spool_target
from ehamj.isolator.supply import Feed
from ehamj.memory import ISOLATOR, size
from ehamj.scenario.model import Scenario
from ehamj.smallmotion.lanes import lanes_of, stacked

_AT: Final = {name: number for number, name in enumerate(ISOLATOR.names or ())}
AMPLITUDE: Final = size(ISOLATOR)
VALUES: Final = AMPLITUDE + 1
"""Numbers of a mount in each lane: its record, and the amplitude of its command."""
OWN: Final = 7
"""Of a mount among the states: spool, its rate, both pressures; in their rates its forces x, y, z beside them [N]."""


class LaneCeiling:
    """The benchmark on many machines of one structure at a step [s]; a call takes its steps."""

    def __init__(self, scenarios: Sequence[Scenario], step: float) -> None:
        systems = [System.of(scenario, step) for scenario in scenarios]
        self._one, self._width, self._step = systems[0], len(systems), step
        tables = [np.column_stack([each.table.view((float, AMPLITUDE)), each.amplitude]) for each in systems]
        self._values, self._inverse = stacked(tables), stacked([each.inverse for each in systems])

    def __call__(self) -> Array:
        """Rows of all machines' states, flat, the machine last."""
        one, lanes = self._one, lanes_of(self._width)
        rows: Array = _loop()(self._inverse, self._values, one.angular, one.steps, one.every, self._step, lanes)
        return rows

    def channels(self) -> Array:
        """As `ehamj.bench.ceiling.Ceiling.channels` of each machine, (machine, n, 5 + mount)."""
        rows = self()
        states = rows.reshape(len(rows), -1, self._width).transpose(2, 0, 1)
        pressures = states[:, :, 2 * N :].reshape(self._width, len(rows), -1, OWN)[..., 2:4]
        return np.concatenate([states[:, :, :5], pressures[..., 0] - pressures[..., 1]], axis=2)


def _reader(values: Any, without: Sequence[str] = ()) -> Any:
    """The kernel that takes a component's values of one lane from memory; what a machine has not is zero for good."""
    fields = ", ".join("0.0" if name in without else f"peek(values, at + {_AT[name]} * w)" for name in values._fields)
    scope = {"Values": values, "peek": peek}
    exec(f"def reader(values, at, w):\n    return Values({fields})", scope)
    return kernel(scope["reader"])


_edges = _reader(Edges.Values, without=("check_valve",))
_spool, _cylinder, _fluid, _membrane = (_reader(one.Values) for one in (Spool, Cylinder, Fluid, Membrane))
_feed = _reader(Feed)
X, Y = _AT["mount_x"], _AT["mount_y"]


@kernel
def mount_rates(states, rates, values, mount, sine, lanes):  # type: ignore[no-untyped-def]
    """Rates of the states of a mount's isolator, and its forces on the machine, in all lanes."""
    w = len(lanes)
    for lane in range(w):
        at, own = mount * VALUES * w + lane, (2 * N + OWN * mount) * w + lane
        x, y = peek(values, at + X * w), peek(values, at + Y * w)
        edges, valve, feed = _edges(values, at, w), _spool(values, at, w), _feed(values, at, w)
        cylinder, oil, membrane = _cylinder(values, at, w), _fluid(values, at, w), _membrane(values, at, w)
        height = peek(states, lane + 2 * w) + y * peek(states, lane + 3 * w) - x * peek(states, lane + 4 * w)
        rise = peek(states, lane + 8 * w) + y * peek(states, lane + 9 * w) - x * peek(states, lane + 10 * w)
        spool, rate = peek(states, own), peek(states, own + w)
        one, two = peek(states, own + 2 * w), peek(states, own + 3 * w)
        flows = chamber_flows(full_stroke(spool, valve.spool_stroke), one, two, feed, edges)
        target = spool_target(Command(peek(values, at + AMPLITUDE * w) * sine, 0.0), valve)
        area, beta, wall = cylinder.piston_area, oil.bulk_modulus, oil.wall_compliance
        poke(rates, own, rate)
        poke(rates, own + w, spool_acceleration(target - spool, rate, valve))
        poke(rates, own + 2 * w, pressure_rate(flows.into_1, area * rise, one, cylinder.volume_1, beta, wall))
        poke(rates, own + 3 * w, pressure_rate(flows.into_2, -area * rise, two, cylinder.volume_2, beta, wall))
        spring, damper = lift(height, rise, membrane)
        turn, spin = peek(states, lane + 5 * w), peek(states, lane + 11 * w)
        poke(
            rates,
            own + 4 * w,
            -pull(peek(states, lane) - y * turn, peek(states, lane + 6 * w) - y * spin, 1.0, membrane),
        )
        poke(
            rates,
            own + 5 * w,
            -pull(peek(states, lane + w) + x * turn, peek(states, lane + 7 * w) + x * spin, 1.0, membrane),
        )
        poke(rates, own + 6 * w, area * (one - two) - spring - damper)


@kernel
def add_forces(force, rates, values, mount, lanes):  # type: ignore[no-untyped-def]
    """Add a mount's forces to those on the machine, in all lanes."""
    w = len(lanes)
    for lane in range(w):
        at, own = mount * VALUES * w + lane, (2 * N + OWN * mount + 4) * w + lane
        x, y = peek(values, at + X * w), peek(values, at + Y * w)
        pull_x, pull_y, up = peek(rates, own), peek(rates, own + w), peek(rates, own + 2 * w)
        poke(force, lane, peek(force, lane) + pull_x)
        poke(force, lane + w, peek(force, lane + w) + pull_y)
        poke(force, lane + 2 * w, peek(force, lane + 2 * w) + up)
        poke(force, lane + 3 * w, peek(force, lane + 3 * w) + y * up)
        poke(force, lane + 4 * w, peek(force, lane + 4 * w) - x * up)
        poke(force, lane + 5 * w, peek(force, lane + 5 * w) + (x * pull_y - y * pull_x))


@kernel
def motion_rates(states, rates, force, inverse, lanes):  # type: ignore[no-untyped-def]
    """Rates of the machines' motion, in all lanes."""
    w = len(lanes)
    for i in range(N):
        for lane in range(w):
            poke(rates, i * w + lane, peek(states, (N + i) * w + lane))
            poke(rates, (N + i) * w + lane, 0.0)
        for j in range(N):
            for lane in range(w):
                pushed = peek(inverse, (i * N + j) * w + lane) * peek(force, j * w + lane)
                poke(rates, (N + i) * w + lane, peek(rates, (N + i) * w + lane) + pushed)


@cache
def _loop() -> Any:
    def loop(inverse, values, angular, steps, every, h, lanes):  # type: ignore[no-untyped-def]
        w, mounts = len(lanes), angular.size
        n = (2 * N + OWN * mounts) * w
        s, trial, rate, total, force = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(N * w)
        nodes, weights = (0.0, 0.5, 0.5, 1.0), (1.0, 2.0, 2.0, 1.0)
        for i in range(mounts):
            for lane in range(w):
                feed = _feed(values, i * VALUES * w + lane, w)
                for chamber in range(2, 4):
                    s[(2 * N + OWN * i + chamber) * w + lane] = 0.5 * (feed.supply_pressure + feed.tank_pressure)
        rows = np.empty((steps // every + 1, n))
        for k in range(steps + 1):
            if k % every == 0:
                for i in range(n):
                    rows[k // every, i] = s[i]
            for i in range(n):
                total[i] = rate[i] = 0.0
            for stage in range(4):
                for i in range(n):
                    trial[i] = s[i] + nodes[stage] * h * rate[i]
                for i in range(N * w):
                    force[i] = 0.0
                for i in range(mounts):
                    sine = np.sin(angular[i] * ((k + nodes[stage]) * h))
                    mount_rates(trial, rate, values, i, sine, lanes)
                    add_forces(force, rate, values, i, lanes)
                motion_rates(trial, rate, force, inverse, lanes)
                for i in range(n):
                    total[i] += weights[stage] * rate[i]
            for i in range(n):
                s[i] += h / 6.0 * total[i]
        return rows

    return compiled(loop)
