"""The hydraulics as MuJoCo sees them: three native callbacks that depend on (model, data, id) alone.

Parameters are records in ``actuator_user``, states are activations, inputs of a step are cubics in ``userdata``
(`ehamj.memory`). So one set of callbacks serves every model, thread and batch of the process.
"""

from functools import cache
from typing import Any, NamedTuple

from numba import types

from ehamj.compiled import kernel
from ehamj.compiled.kept import compiled_callback
from ehamj.isolator.edges import Flows
from ehamj.isolator.equations import Plate, balance, isolator_rates
from ehamj.isolator.spool import Command
from ehamj.isolator.supply import Feed, supply_rates
from ehamj.memory import LEDGER, MACHINE_BODY, OIL, SUPPLY, SUPPLY_STATE, size
from ehamj.mujoco.feet import turned_stage, upright_stage
from ehamj.mujoco.offsets import offsets
from ehamj.mujoco.slides import push_slides
from ehamj.mujoco.unpacking import (
    cubic_of,
    feed_of,
    hermite,
    isolator_of,
    options_of,
    put_options,
    state_of,
    supply_of,
    supply_state_of,
)
from ehamj.mujoco.views import N_LOADS, machine_of, mounts_at, numbers_at, part, row_at
from ehamj.plant.axes import JOINTS

OIL_SIZE = size(OIL)


@kernel
def feed_from(machine, k):  # type: ignore[no-untyped-def]
    """What an isolator is fed with: the shared supply's pressure where it has states and reaches it."""
    feed, place = feed_of(machine.isolators[k]), machine.isolators[0].supply_at
    if place > 0.0 and machine.isolators[k].connected > 0.0:
        shared = part(machine.act, place, 1, SUPPLY_STATE)[0]
        return Feed(shared.supply_pressure, feed.tank_pressure, feed.rated_pressure)
    return feed


@kernel
def plate_of(machine, k):  # type: ignore[no-untyped-def]
    """Motion of a plate over its ground; the engine's membranes have the shims."""
    mount = machine.mounts[k]
    stroke, speed = machine.length[k] - mount.ground, machine.velocity[k] - mount.ground_rate
    return Plate(stroke, speed, mount.ground - machine.isolators[k].height, mount.ground_rate)


@kernel
def write_rates(machine):  # type: ignore[no-untyped-def]
    """Time derivatives of the states of all isolators, and what they give to the mounts."""
    for k in range(machine.mounts.size):
        isolator, mount, rate = machine.isolators[k], machine.mounts[k], machine.rates[k]
        derivative, of_options, flows, force = isolator_rates(
            state_of(machine.states[k]),
            options_of(machine.act, isolator),
            Command(machine.control[k] + mount.command, mount.switching),
            plate_of(machine, k),
            mount.metering,
            machine.time[0],
            feed_from(machine, k),
            isolator_of(isolator),
        )
        rate.spool, rate.spool_rate, rate.pressure_1, rate.pressure_2 = derivative
        put_options(of_options, machine.act_dot, isolator)
        mount.into_1, mount.into_2, mount.drawn = flows
        mount.force = force + isolator.weight


@kernel
def write_supply_rates(machine, row):  # type: ignore[no-untyped-def]
    """Time derivatives of the supply's states, from the flow that all isolators draw."""
    drawn, place = 0.0, machine.isolators[0].supply_at
    for k in range(machine.mounts.size):
        drawn += machine.isolators[k].connected * machine.mounts[k].drawn
    rate = part(machine.act_dot, place, 1, SUPPLY_STATE)[0]
    found = supply_rates(supply_state_of(part(machine.act, place, 1, SUPPLY_STATE)[0]), drawn, supply_of(row))
    rate.station_pressure, rate.line_flow, rate.supply_pressure = found


@kernel
def write_ledger_rates(machine):  # type: ignore[no-untyped-def]
    """Time derivatives of what crosses the chambers' borders, from the rates just written."""
    place, n = machine.isolators[0].ledger_at, machine.mounts.size
    oil = part(machine.act_dot, place, n, OIL)
    ledger = part(machine.act_dot, place + OIL_SIZE * n, 1, LEDGER)[0]
    energy, work, supplied, throttled = 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        mount, own = machine.mounts[k], isolator_of(machine.isolators[k])
        flows, feed = Flows(mount.into_1, mount.into_2, mount.drawn), feed_from(machine, k)
        state, rate = state_of(machine.states[k]), state_of(machine.rates[k])
        one, two, power, lost = balance(state, rate, flows, plate_of(machine, k), feed, own)
        oil[k].oil_in_1, oil[k].oil_in_2 = one.oil, two.oil
        energy = energy + one.energy + two.energy
        work = work + one.work + two.work
        supplied += power
        throttled += lost
    ledger.energy_in, ledger.piston_work = energy, work
    ledger.supplied_energy, ledger.throttled_energy = supplied, throttled


class Callbacks(NamedTuple):
    """Compiled callbacks; kept alive by the cache of `callbacks`."""

    passive: Any
    act_dyn: Any
    act_bias: Any


@cache
def callbacks() -> Callbacks:
    """Compile the callbacks for the installed MuJoCo, or take them from the cache."""
    at, joints, loads_at = offsets(), len(JOINTS), N_LOADS * MACHINE_BODY

    def passive(model, data):  # type: ignore[no-untyped-def]
        machine = machine_of(model, data, at, joints, joints)
        step, force = machine.step[0], numbers_at(data, at.qfrc_passive, joints + machine.slides.size)
        s = (machine.time[0] - step.start) * step.rate  # a rate of zero: the ground rests, and only ctrl commands
        if machine.isolators[0].level_enough > 0.0:
            upright_stage(machine, s, force)
        else:
            turned_stage(machine, s, force)
        push_slides(machine, s, force)
        if step.loaded != 0.0:  # the engine adds it to the accelerations after its passive forces
            applied = numbers_at(data, at.xfrc_applied, loads_at + N_LOADS)
            for dof in range(N_LOADS):
                applied[loads_at + dof] = hermite(cubic_of(machine.loads[dof]), s)[0]

    def act_dyn(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo clears and asks actuator by actuator; answering for all at the last one halves the cost.
        machine = machine_of(model, data, at, 0, 0)
        head = machine.isolators[0]
        if actuator + 1 < head.actuators:
            return 0.0
        write_rates(machine)
        if head.supply_at > 0.0:
            write_supply_rates(machine, row_at(model, at, head.supply_row, 1, SUPPLY)[0])
        if head.ledger_at > 0.0:
            write_ledger_rates(machine)
        # Of an actuator with a single activation MuJoCo takes the rate from what is returned.
        return machine.act_dot[machine.act_dot.size - 1]

    def act_bias(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo asks for forces after it has asked for all rates: the rates have left them.
        return mounts_at(data, at, actuator + 1)[actuator].force

    on_state = types.void(types.intp, types.intp)
    on_actuator = types.float64(types.intp, types.intp, types.int32)
    return Callbacks(
        compiled_callback(passive, on_state),
        compiled_callback(act_dyn, on_actuator),
        compiled_callback(act_bias, on_actuator),
    )
