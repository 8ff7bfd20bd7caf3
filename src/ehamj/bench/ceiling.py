"""The benchmark's equations in bare compiled RK4 without any multibody engine: the ceiling of what is possible."""

from functools import cache
from typing import Any, NamedTuple, Self

import numba
import numpy as np

from ehamj.arrays import Array
from ehamj.compiled import OPTIONS, giving_arrays
from ehamj.compiled.kept import compiled
from ehamj.isolator.edges import chamber_flows
from ehamj.isolator.fluid import pressure_rate
from ehamj.isolator.membrane import lift, pull
from ehamj.isolator.spool import Command, full_stroke, spool_acceleration, spool_target
from ehamj.memory import isolators
from ehamj.mujoco.model import build_model
from ehamj.mujoco.unpacking import feed_of, isolator_of
from ehamj.plant.axes import DOFS
from ehamj.scenario.model import Scenario

N = len(DOFS)


class System(NamedTuple):
    """What the equations of the benchmark need of a scenario."""

    inverse: Array
    """Of the mass matrix about the mount plane's centre (6, 6)."""
    table: Any
    """`ehamj.memory.ISOLATOR` (mount,)."""
    amplitude: Array
    """Of the valves' commands [V]."""
    angular: Array
    """Their frequencies [rad/s]."""
    steps: int
    every: int
    """Steps to a row."""

    @classmethod
    def of(cls, scenario: Scenario, step: float) -> Self:
        """Of a scenario at a step [s]."""
        machine, signals = scenario.plant.machine, scenario.control.signals  # type: ignore[attr-defined]
        m, h = machine.mass, machine.cg[2]
        mass = np.diag([m, m, m, m * h * h, m * h * h, 0.0])
        mass[3:, 3:] += machine.tensor
        mass[0, 4] = mass[4, 0] = m * h
        mass[1, 3] = mass[3, 1] = -m * h
        amplitude, frequency = (np.array([getattr(one, key) for one in signals]) for key in ("amplitude", "frequency"))
        steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
        table = isolators(build_model(scenario.plant, step)).copy()
        return cls(np.linalg.inv(mass), table, amplitude, 2 * np.pi * frequency, steps, every)


class Ceiling:
    """The benchmark on one machine at a step [s]; a call takes its steps."""

    def __init__(self, scenario: Scenario, step: float) -> None:
        self._system, self._step = System.of(scenario, step), step

    def __call__(self) -> Array:
        """Rows of states."""
        rows: Array = _loop()(*self._system, self._step)
        return rows

    def channels(self) -> Array:
        """x, y, z, rx, ry and the load pressures at the recording rate, (n, 5 + mount)."""
        rows = self()
        pressures = rows[:, 2 * N :].reshape(len(rows), 4, -1)[:, 2:]
        return np.hstack([rows[:, :5], pressures[:, 0] - pressures[:, 1]])


@giving_arrays
def oil(state):  # type: ignore[no-untyped-def]
    """The isolators' part of a state: spool, its rate, both pressures (4, mount)."""
    return state[2 * N :].reshape(4, -1)


def rates(motion, valves, t, system, force, out, valves_out):  # type: ignore[no-untyped-def]
    """Rates of the machine (12,) and of the isolators: spool, its rate, both pressures (4, mount)."""
    inverse, table, amplitude, angular = system
    force[:] = 0.0
    for i in range(table.size):
        record = table[i]
        own, feed, x, y = isolator_of(record), feed_of(record), record.mount_x, record.mount_y
        height = motion[2] + y * motion[3] - x * motion[4]
        rise = motion[8] + y * motion[9] - x * motion[10]
        spool, rate, one, two = valves[0, i], valves[1, i], valves[2, i], valves[3, i]
        flows = chamber_flows(full_stroke(spool, own.spool.spool_stroke), one, two, feed, own.edges)
        target = spool_target(Command(amplitude[i] * np.sin(angular[i] * t), 0.0), own.spool)
        area, beta, wall = own.cylinder.piston_area, own.fluid.bulk_modulus, own.fluid.wall_compliance
        valves_out[0, i] = rate
        valves_out[1, i] = spool_acceleration(target - spool, rate, own.spool)
        valves_out[2, i] = pressure_rate(flows.into_1, area * rise, one, own.cylinder.volume_1, beta, wall)
        valves_out[3, i] = pressure_rate(flows.into_2, -area * rise, two, own.cylinder.volume_2, beta, wall)
        spring, damper = lift(height, rise, own.membrane)
        up = area * (one - two) - spring - damper
        pull_x = -pull(motion[0] - y * motion[5], motion[6] - y * motion[11], 1.0, own.membrane)
        pull_y = -pull(motion[1] + x * motion[5], motion[7] + x * motion[11], 1.0, own.membrane)
        force[0] += pull_x
        force[1] += pull_y
        force[2] += up
        force[3] += y * up
        force[4] -= x * up
        force[5] += x * pull_y - y * pull_x
    for i in range(N):
        out[i] = motion[N + i]
        out[N + i] = 0.0
        for j in range(N):
            out[N + i] += inverse[i, j] * force[j]


@cache
def _loop() -> Any:
    called = numba.njit(**OPTIONS)(rates)

    def loop(inverse, table, amplitude, angular, steps, every, h):  # type: ignore[no-untyped-def]
        system, n = (inverse, table, amplitude, angular), 2 * N + 4 * table.size
        s, trial, rate, total, force = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(N)
        nodes, weights = (0.0, 0.5, 0.5, 1.0), (1.0, 2.0, 2.0, 1.0)
        for i in range(table.size):
            oil(s)[2, i] = oil(s)[3, i] = 0.5 * (table[i].supply_pressure + table[i].tank_pressure)
        rows = np.empty((steps // every + 1, n))
        for k in range(steps + 1):
            if k % every == 0:
                rows[k // every] = s
            total[:] = 0.0
            rate[:] = 0.0
            for stage in range(4):
                for i in range(n):
                    trial[i] = s[i] + nodes[stage] * h * rate[i]
                called(trial, oil(trial), (k + nodes[stage]) * h, system, force, rate, oil(rate))
                for i in range(n):
                    total[i] += weights[stage] * rate[i]
            for i in range(n):
                s[i] += h / 6.0 * total[i]
        return rows

    return compiled(loop)
