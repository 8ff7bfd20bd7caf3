"""The hydraulics as MuJoCo sees them: three native callbacks that depend on (model, data, id) alone.

Parameters are records in ``actuator_user``, states are activations, inputs of a step are cubics in ``userdata``
(`ehamj.memory`). So one set of callbacks serves every model, thread and batch of the process.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import carray, types

from ehamj.compiled import compiled_here, kernel
from ehamj.isolator.edges import Flows
from ehamj.isolator.equations import Plate, balance, isolator_rates
from ehamj.isolator.membrane import pull
from ehamj.isolator.supply import Feed, supply_rates
from ehamj.memory import (
    MACHINE_BODY,
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
from ehamj.mujoco.offsets import offsets
from ehamj.mujoco.pointers import address_at, doubles_at, load_double, pointer
from ehamj.mujoco.views import (
    N_LOADS,
    isolator_states,
    isolators_at,
    ledger_states,
    loads_at,
    mounts_at,
    oil_states,
    step_at,
    supply_at,
    supply_states,
)
from ehamj.plant.axes import DOFS, JOINTS

X, Y, RZ = JOINTS.index("x"), JOINTS.index("y"), JOINTS.index("rz")


@kernel
def stage_inputs(s, rate, isolators, mounts, force):  # type: ignore[no-untyped-def]
    """Evaluate ground and command at the fraction ``s`` of a step; add the ground's lateral pull to ``force``."""
    for k in range(mounts.size):
        mount, isolator = mounts[k], isolators[k]
        own = isolator_of(isolator).membrane
        x, x_slope = hermite(cubic_of(mount.ground_x), s)
        y, y_slope = hermite(cubic_of(mount.ground_y), s)
        z, z_slope = hermite(cubic_of(mount.ground_z), s)
        mount.ground = z
        mount.ground_rate = z_slope * rate
        mount.command = hermite(cubic_of(mount.open_loop), s)[0]
        pull_x, pull_y = pull(x, x_slope, rate, own), pull(y, y_slope, rate, own)
        force[X] += pull_x
        force[Y] += pull_y
        force[RZ] += isolator.mount_x * pull_y - isolator.mount_y * pull_x


@kernel
def feed_from(isolator, head, act):  # type: ignore[no-untyped-def]
    """What an isolator is fed with: the shared supply's pressure where it has states, from where activations lie."""
    feed = feed_of(isolator)
    if head.supply_at > 0.0:
        shared = supply_states(act, head.supply_at)
        return Feed(shared.supply_pressure, feed.tank_pressure, feed.rated_pressure)
    return feed


@kernel
def plate_of(mount, length, velocity):  # type: ignore[no-untyped-def]
    """Motion of a plate over its ground."""
    return Plate(length - mount.ground, velocity - mount.ground_rate, mount.ground, mount.ground_rate)


@kernel
def write_rates(isolators, mounts, act, act_dot, length, velocity, control):  # type: ignore[no-untyped-def]
    """Time derivatives of the states of all isolators, and what they give to the mounts."""
    states, rates = isolator_states(act, mounts.size), isolator_states(act_dot, mounts.size)
    head = isolators[0]
    n_act = int(head.activations)
    every, every_rate = carray(pointer(act), n_act, np.float64), carray(pointer(act_dot), n_act, np.float64)
    for k in range(mounts.size):
        isolator, mount, rate = isolators[k], mounts[k], rates[k]
        derivative, of_options, flows, force = isolator_rates(
            state_of(states[k]),
            options_of(every, isolator),
            control[k] + mount.command,
            plate_of(mount, length[k], velocity[k]),
            mount.metering,
            feed_from(isolator, head, act),
            isolator_of(isolator),
        )
        rate.spool, rate.spool_rate = derivative.spool, derivative.spool_rate
        rate.pressure_1, rate.pressure_2 = derivative.pressure_1, derivative.pressure_2
        put_options(of_options, every_rate, isolator)
        mount.into_1, mount.into_2, mount.drawn = flows.into_1, flows.into_2, flows.drawn
        mount.force = force + isolator.weight


@kernel
def write_supply_rates(row, place, mounts, act, act_dot):  # type: ignore[no-untyped-def]
    """Time derivatives of the supply's states, from the flow that all isolators draw."""
    drawn = 0.0
    for k in range(mounts.size):
        drawn += mounts[k].drawn
    rate = supply_states(act_dot, place)
    found = supply_rates(supply_state_of(supply_states(act, place)), drawn, supply_of(row))
    rate.station_pressure, rate.line_flow, rate.supply_pressure = found


@kernel
def write_ledger_rates(isolators, mounts, act, act_dot, length, velocity):  # type: ignore[no-untyped-def]
    """Time derivatives of what crosses the chambers' borders, from the rates just written."""
    head, n = isolators[0], mounts.size
    states, rates = isolator_states(act, n), isolator_states(act_dot, n)
    oil, ledger = oil_states(act_dot, head.ledger_at, n), ledger_states(act_dot, head.ledger_at, n)
    energy, work, supplied, throttled = 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        mount = mounts[k]
        flows = Flows(mount.into_1, mount.into_2, mount.drawn)
        plate, feed = plate_of(mount, length[k], velocity[k]), feed_from(isolators[k], head, act)
        one, two, power, lost = balance(
            state_of(states[k]), state_of(rates[k]), flows, plate, feed, isolator_of(isolators[k])
        )
        oil[k].oil_in_1, oil[k].oil_in_2 = one.oil, two.oil
        energy = energy + one.energy + two.energy
        work = work + one.work + two.work
        supplied += power
        throttled += lost
    ledger.energy_in, ledger.piston_work, ledger.supplied_energy, ledger.throttled_energy = (
        energy, work, supplied, throttled,
    )  # fmt: skip


class Callbacks(NamedTuple):
    """Compiled callbacks; kept alive by the cache of `callbacks`."""

    passive: Any
    act_dyn: Any
    act_bias: Any


@cache
def callbacks() -> Callbacks:
    """Compile the callbacks for the installed MuJoCo, or take them from the cache."""
    at = offsets()

    def passive(model, data):  # type: ignore[no-untyped-def]
        isolators, step = isolators_at(model, at), step_at(data, at)[0]
        if step.rate == 0.0:  # no inputs: the ground rests, and only ctrl commands
            return
        s = (load_double(data, at.time) - step.start) * step.rate
        force = carray(doubles_at(data, at.qfrc_passive), len(JOINTS))
        stage_inputs(s, step.rate, isolators, mounts_at(data, at, isolators.size), force)
        if step.loaded != 0.0:  # the engine adds it to the accelerations after its passive forces
            applied = carray(doubles_at(data, at.xfrc_applied), len(DOFS) * (MACHINE_BODY + 1))
            loads = loads_at(data, at)
            for dof in range(N_LOADS):
                applied[len(DOFS) * MACHINE_BODY + dof] = hermite(cubic_of(loads[dof]), s)[0]

    def act_dyn(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo clears and asks actuator by actuator; answering for all at the last one halves the cost.
        isolators = isolators_at(model, at)
        head, n = isolators[0], isolators.size
        if actuator + 1 < head.actuators:
            return 0.0
        mounts = mounts_at(data, at, n)
        act, act_dot = address_at(data, at.act), address_at(data, at.act_dot)
        length = carray(doubles_at(data, at.actuator_length), n)
        velocity = carray(doubles_at(data, at.actuator_velocity), n)
        control = carray(doubles_at(data, at.ctrl), n)
        write_rates(isolators, mounts, act, act_dot, length, velocity, control)
        if head.supply_at > 0.0:
            write_supply_rates(supply_at(model, at, head.supply_row), head.supply_at, mounts, act, act_dot)
        if head.ledger_at > 0.0:
            write_ledger_rates(isolators, mounts, act, act_dot, length, velocity)
        # Of an actuator with a single activation MuJoCo takes the rate from what is returned.
        n_act = int(head.activations)
        return carray(pointer(act_dot), n_act, np.float64)[n_act - 1]

    def act_bias(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo asks for forces after it has asked for all rates: the rates have left them.
        return mounts_at(data, at, actuator + 1)[actuator].force

    on_state = types.void(types.intp, types.intp)
    on_actuator = types.float64(types.intp, types.intp, types.int32)
    with compiled_here() as kept:
        return Callbacks(
            numba.cfunc(on_state, cache=kept, nopython=True, error_model="numpy")(passive),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_dyn),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_bias),
        )
