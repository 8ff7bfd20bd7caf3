"""The benchmark's equations in bare compiled RK4 without any multibody engine: the ceiling of what is possible."""

from functools import cache
from typing import Any

import numba
import numpy as np

from ehamj.arrays import Array
from ehamj.compiled import kernel
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


def ceiling(scenario: Scenario, step: float) -> Array:
    """x, y, z, rx, ry and the load pressures of the benchmark at the recording rate, (n, 5 + mount)."""
    plant, machine = scenario.plant, scenario.plant.machine
    m, h = machine.mass, machine.cg[2]
    mass = np.diag([m, m, m, m * h * h, m * h * h, 0.0])
    mass[3:, 3:] += machine.tensor
    mass[0, 4] = mass[4, 0] = m * h
    mass[1, 3] = mass[3, 1] = -m * h
    table = isolators(build_model(plant, step)).copy()
    frequency = np.array([setting.frequency for setting in scenario.control.signals])  # type: ignore[attr-defined]
    amplitude = np.array([setting.amplitude for setting in scenario.control.signals])  # type: ignore[attr-defined]
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    rows = _loop()(np.linalg.inv(mass), table, amplitude, 2 * np.pi * frequency, steps, every, step)
    pressures = rows[:, 2 * N :].reshape(len(rows), 4, table.size)[:, 2:]
    return np.hstack([rows[:, :5], pressures[:, 0] - pressures[:, 1]])


@kernel
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
    compiled_rates = numba.njit(nogil=True, error_model="numpy")(rates)

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
                compiled_rates(trial, oil(trial), (k + nodes[stage]) * h, system, force, rate, oil(rate))
                for i in range(n):
                    total[i] += weights[stage] * rate[i]
            for i in range(n):
                s[i] += h / 6.0 * total[i]
        return rows

    return numba.njit(nogil=True, error_model="numpy")(loop)
