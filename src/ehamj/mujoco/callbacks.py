"""The hydraulics as MuJoCo sees them: three native callbacks that depend on (model, data, id) alone.

Parameters are columns of ``actuator_user``, states are activations, inputs of a step are cubics in ``userdata``
(`ehamj.memory`). So one set of callbacks serves every model, thread and batch of the process.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import carray, types

from ehamj.compiled import kernel
from ehamj.isolator.cylinder import chamber_flows, lapped_chamber_flows
from ehamj.isolator.fluid import (
    ATMOSPHERE,
    actual_pressure,
    filled_share,
    oil_modulus,
    pressure_rate,
    relative_volume,
    specific_energy,
)
from ehamj.isolator.supply import supply_rates
from ehamj.isolator.valve import curved_opening, held_by_stop, play, spool_acceleration, spool_target
from ehamj.memory import (
    COLUMN,
    CUBICS,
    CURVE_POINTS,
    LEDGER,
    LEDGER_STATES,
    LOAD,
    LOADED,
    MACHINE_BODY,
    METERING,
    N_STATES,
    N_USERDATA,
    PARAMETERS,
    STAGE_COMMAND,
    STAGE_DRAWN,
    STAGE_FLOW,
    STAGE_FORCE,
    STAGE_GROUND,
    STAGE_GROUND_RATE,
    STEP_RATE,
    STEP_START,
    SUPPLY,
    SUPPLY_PARAMETERS,
    SUPPLY_STATES,
)
from ehamj.mujoco.cache import compiled_here
from ehamj.mujoco.offsets import offsets
from ehamj.mujoco.pointers import doubles_at, load_double
from ehamj.plant.axes import DOFS, JOINTS
from ehamj.plant.mounts import N_MOUNTS

KIND = COLUMN["kind"]
AREA, AREA_2, VOLUME_1, VOLUME_2 = (COLUMN[k] for k in ("piston_area", "piston_area_2", "volume_1", "volume_2"))
MOVING, BULK_MODULUS, VAPOUR_PRESSURE = COLUMN["moving_volume"], COLUMN["bulk_modulus"], COLUMN["vapour_pressure"]
AIR, EXPONENT, WALL = COLUMN["air_fraction"], COLUMN["polytropic_exponent"], COLUMN["wall_compliance"]
FLOW_GAIN, EDGE_LEAKAGE, CROSS_LEAKAGE = COLUMN["flow_gain"], COLUMN["edge_leakage"], COLUMN["cross_leakage"]
LAMINAR_RATIO, RATED, SHARED = COLUMN["laminar_ratio"], COLUMN["rated_pressure"], COLUMN["shared_supply"]
SUPPLY_PRESSURE, TANK = COLUMN["supply_pressure"], COLUMN["tank_pressure"]
VALVE_GAIN, FREQUENCY, DAMPING = COLUMN["valve_gain"], COLUMN["valve_frequency"], COLUMN["valve_damping"]
DRIVE_LIMIT, SPOOL_STROKE, VOLTAGE_LIMIT = (COLUMN[k] for k in ("spool_drive_limit", "spool_stroke", "voltage_limit"))
END_STOPS, THRESHOLD, HYSTERESIS = COLUMN["end_stops"], COLUMN["threshold"], COLUMN["hysteresis"]
OFFSET, LAPPED, LAP, CURVED, CURVE = (
    COLUMN[k] for k in ("null_offset", "lapped", "overlap_supply_1", "curved", "flow_curve_0")
)
STIFFNESS, VISCOUS = COLUMN["membrane_stiffness"], COLUMN["membrane_damping"]
LATERAL_STIFFNESS, LATERAL_DAMPING = COLUMN["lateral_stiffness"], COLUMN["lateral_damping"]
MOUNT_X, MOUNT_Y, WEIGHT = COLUMN["mount_x"], COLUMN["mount_y"], COLUMN["weight"]
N_PARAMETERS = len(PARAMETERS)
N_ACT = N_STATES * N_MOUNTS
MANIFOLD = N_ACT + SUPPLY_STATES.index("supply_pressure")
LEDGER_OFFSET = 1  # column of the ledger's row that says where its states begin
N_LEDGER = len(LEDGER_STATES)
X, Y, RZ = JOINTS.index("x"), JOINTS.index("y"), JOINTS.index("rz")


@kernel
def hermite(shared, offset, s):  # type: ignore[no-untyped-def]
    """Value and slope·step at the fraction ``s`` of the step, of the cubic stored at ``offset``."""
    start, start_slope, end, end_slope = shared[offset], shared[offset + 1], shared[offset + 2], shared[offset + 3]
    rise = end - start
    c = 3.0 * rise - 2.0 * start_slope - end_slope
    d = start_slope + end_slope - 2.0 * rise
    return start + s * (start_slope + s * (c + s * d)), start_slope + s * (2.0 * c + 3.0 * s * d)


@kernel
def stage_inputs(time, shared, table, force):  # type: ignore[no-untyped-def]
    """Evaluate ground and command at ``time``; add the ground's lateral pull through the membranes to ``force``."""
    rate = shared[STEP_RATE]
    if rate == 0.0:  # no inputs: the ground rests, and only ctrl commands
        return
    s = (time - shared[STEP_START]) * rate
    for mount in range(N_MOUNTS):
        own = table[mount * N_PARAMETERS : (mount + 1) * N_PARAMETERS]
        offset = CUBICS + 12 * mount
        x, x_slope = hermite(shared, offset, s)
        y, y_slope = hermite(shared, offset + 4, s)
        z, z_slope = hermite(shared, offset + 8, s)
        shared[STAGE_GROUND + mount] = z
        shared[STAGE_GROUND_RATE + mount] = z_slope * rate
        shared[STAGE_COMMAND + mount] = hermite(shared, CUBICS + 12 * N_MOUNTS + 4 * mount, s)[0]
        pull_x = own[LATERAL_STIFFNESS] * x + own[LATERAL_DAMPING] * x_slope * rate
        pull_y = own[LATERAL_STIFFNESS] * y + own[LATERAL_DAMPING] * y_slope * rate
        force[X] += pull_x
        force[Y] += pull_y
        force[RZ] += own[MOUNT_X] * pull_y - own[MOUNT_Y] * pull_x


@kernel
def stage_load(time, shared, applied):  # type: ignore[no-untyped-def]
    """Evaluate the force on the machine itself at ``time`` into ``applied``, the machine's part of xfrc_applied."""
    s = (time - shared[STEP_START]) * shared[STEP_RATE]
    for dof in range(len(DOFS)):
        applied[dof] = hermite(shared, LOAD + 4 * dof, s)[0]


@kernel
def metered_opening(spool, memory, table, own):  # type: ignore[no-untyped-def]
    """Opening that the flow sees [mA]: spool with play, null offset, full stroke and flow curve."""
    stroke = table[own + SPOOL_STROKE]
    opening = play(memory, spool, table[own + HYSTERESIS]) + table[own + OFFSET]
    opening = min(max(opening, -stroke), stroke)
    if table[own + CURVED] != 0.0:
        opening = curved_opening(opening, stroke, table[own + CURVE : own + CURVE + CURVE_POINTS])
    return opening


@kernel
def valve_flows(opening, pressure_1, pressure_2, supply, table, own):  # type: ignore[no-untyped-def]
    """Flow into each chamber, and drawn from the supply, of one valve [m³/s]."""
    if table[own + LAPPED] == 0.0:
        return chamber_flows(
            opening,
            pressure_1,
            pressure_2,
            supply,
            table[own + TANK],
            table[own + RATED],
            table[own + FLOW_GAIN],
            table[own + EDGE_LEAKAGE],
            table[own + CROSS_LEAKAGE],
            table[own + LAMINAR_RATIO],
        )
    return lapped_chamber_flows(
        opening,
        (table[own + LAP], table[own + LAP + 1], table[own + LAP + 2], table[own + LAP + 3]),
        table[own + SPOOL_STROKE],
        pressure_1,
        pressure_2,
        supply,
        table[own + TANK],
        table[own + RATED],
        table[own + FLOW_GAIN],
        table[own + EDGE_LEAKAGE],
        table[own + CROSS_LEAKAGE],
        table[own + LAMINAR_RATIO],
    )


@kernel
def supply_of(act, table, own):  # type: ignore[no-untyped-def]
    """Supply pressure that an actuator sees [Pa]."""
    if table[own + SHARED] != 0.0:
        return act[MANIFOLD]
    return table[own + SUPPLY_PRESSURE]


@kernel
def chamber_volumes(stroke, table, own):  # type: ignore[no-untyped-def]
    """Volumes of both chambers, walls unstretched [m³]."""
    moved = table[own + MOVING] * stroke
    return table[own + VOLUME_1] + table[own + AREA] * moved, table[own + VOLUME_2] - table[own + AREA_2] * moved


@kernel
def actuator_rates(act, act_dot, length, velocity, control, shared, table):  # type: ignore[no-untyped-def]
    """Time derivatives of the states of all actuators, and their flows into ``shared``."""
    for mount in range(N_MOUNTS):
        first, own = N_STATES * mount, N_PARAMETERS * mount
        spool, rate = act[first], act[first + 1]
        vapour, beta, wall = table[own + VAPOUR_PRESSURE], table[own + BULK_MODULUS], table[own + WALL]
        pressure_1, pressure_2 = actual_pressure(act[first + 2], vapour), actual_pressure(act[first + 3], vapour)
        speed = velocity[mount] - shared[STAGE_GROUND_RATE + mount]
        volume_1, volume_2 = chamber_volumes(length[mount] - shared[STAGE_GROUND + mount], table, own)
        target = spool_target(
            control[mount] + shared[STAGE_COMMAND + mount], table[own + VALVE_GAIN], table[own + VOLTAGE_LIMIT]
        )
        acceleration = spool_acceleration(
            spool,
            rate,
            target,
            table[own + FREQUENCY],
            table[own + DAMPING],
            table[own + DRIVE_LIMIT],
            table[own + THRESHOLD],
        )
        if table[own + END_STOPS] != 0.0:
            rate, acceleration = held_by_stop(spool, rate, acceleration, table[own + SPOOL_STROKE])
        opening = metered_opening(spool, shared[METERING + mount], table, own)
        flow_1, flow_2, drawn = valve_flows(opening, pressure_1, pressure_2, supply_of(act, table, own), table, own)
        beta_1, beta_2 = beta, beta
        if table[own + AIR] != 0.0:
            beta_1 = oil_modulus(pressure_1, beta, table[own + AIR], table[own + EXPONENT])
            beta_2 = oil_modulus(pressure_2, beta, table[own + AIR], table[own + EXPONENT])
        # Oil that enters a chamber with a void fills it the sooner the less of it is oil: mass is conserved.
        into_1 = flow_1 / filled_share(act[first + 2], pressure_1, beta_1)
        into_2 = flow_2 / filled_share(act[first + 3], pressure_2, beta_2)
        act_dot[first] = rate
        act_dot[first + 1] = acceleration
        act_dot[first + 2] = pressure_rate(into_1, table[own + AREA] * speed, act[first + 2], volume_1, beta_1, wall)
        act_dot[first + 3] = pressure_rate(into_2, -table[own + AREA_2] * speed, act[first + 3], volume_2, beta_2, wall)
        shared[STAGE_FLOW + 2 * mount] = flow_1
        shared[STAGE_FLOW + 2 * mount + 1] = flow_2
        shared[STAGE_DRAWN + mount] = drawn
        oil = table[own + AREA] * pressure_1 - table[own + AREA_2] * pressure_2
        still = table[own + STIFFNESS] * shared[STAGE_GROUND + mount]
        moving = table[own + VISCOUS] * shared[STAGE_GROUND_RATE + mount]
        shared[STAGE_FORCE + mount] = oil + still + moving + table[own + WEIGHT]


@kernel
def shared_supply_rates(act, act_dot, shared, row):  # type: ignore[no-untyped-def]
    """Time derivatives of the supply's states, from the flow that all actuators draw."""
    drawn = 0.0
    for mount in range(N_MOUNTS):
        drawn += shared[STAGE_DRAWN + mount]
    act_dot[N_ACT], act_dot[N_ACT + 1], act_dot[N_ACT + 2] = supply_rates(
        act[N_ACT],
        act[N_ACT + 1],
        act[N_ACT + 2],
        drawn,
        row[1],
        row[2],
        row[3],
        row[4],
        row[5],
        row[6],
        row[7],
        row[8],
        row[9],
        row[10],
    )


@kernel
def ledger_rates(act, act_dot, velocity, length, shared, table, at):  # type: ignore[no-untyped-def]
    """Time derivatives of what crosses the chambers' borders (`ehamj.memory.LEDGER_STATES`), from ``at`` on."""
    energy, work, supplied, throttled = 0.0, 0.0, 0.0, 0.0
    for mount in range(N_MOUNTS):
        first, own = N_STATES * mount, N_PARAMETERS * mount
        beta, air, exponent, wall = (
            table[own + BULK_MODULUS],
            table[own + AIR],
            table[own + EXPONENT],
            table[own + WALL],
        )
        vapour, supply, tank = table[own + VAPOUR_PRESSURE], supply_of(act, table, own), table[own + TANK]
        drawn = shared[STAGE_DRAWN + mount]
        speed = velocity[mount] - shared[STAGE_GROUND_RATE + mount]
        received, delivered = 0.0, 0.0
        for chamber in range(2):
            state = act[first + 2 + chamber]
            pressure = actual_pressure(state, vapour)
            flow = shared[STAGE_FLOW + 2 * mount + chamber]
            density = 1.0 / relative_volume(pressure, beta, air, exponent)
            act_dot[at + 2 * mount + chamber] = density * flow
            energy += density * flow * specific_energy(pressure, beta, air, exponent) + pressure * flow
            swept = table[own + AREA] * speed if chamber == 0 else -table[own + AREA_2] * speed
            stretch = 1.0 + (state - ATMOSPHERE) * wall
            volume_1, volume_2 = chamber_volumes(length[mount] - shared[STAGE_GROUND + mount], table, own)
            volume = volume_1 if chamber == 0 else volume_2
            work += pressure * (stretch * swept + volume * wall * act_dot[first + 2 + chamber])
            received += flow
            delivered += pressure * flow
        supplied += supply * drawn
        throttled += supply * drawn - tank * (drawn - received) - delivered
    end = at + 2 * N_MOUNTS
    act_dot[end], act_dot[end + 1], act_dot[end + 2], act_dot[end + 3] = energy, work, supplied, throttled


class Callbacks(NamedTuple):
    """Compiled callbacks; kept alive by the cache of `callbacks`."""

    passive: Any
    act_dyn: Any
    act_bias: Any


@cache
def callbacks() -> Callbacks:
    """Compile the callbacks for the installed MuJoCo, or take them from the cache."""
    at = offsets()
    time_at, user_at = at.time, at.actuator_user
    shared_at, act_at, act_dot_at, ctrl_at = at.userdata, at.act, at.act_dot, at.ctrl
    length_at, velocity_at, passive_at = at.actuator_length, at.actuator_velocity, at.qfrc_passive
    applied_at = at.xfrc_applied

    def passive(model, data):  # type: ignore[no-untyped-def]
        shared = carray(doubles_at(data, shared_at), N_USERDATA)
        table = carray(doubles_at(model, user_at), N_MOUNTS * N_PARAMETERS)
        stage_inputs(load_double(data, time_at), shared, table, carray(doubles_at(data, passive_at), len(JOINTS)))
        if shared[LOADED] != 0.0:  # the engine adds it to the accelerations after its passive forces
            applied = carray(doubles_at(data, applied_at), len(DOFS) * (MACHINE_BODY + 1))
            stage_load(load_double(data, time_at), shared, applied[len(DOFS) * MACHINE_BODY :])

    def act_dyn(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo clears and asks actuator by actuator; answering for all valves at the last one halves the cost.
        if actuator < N_MOUNTS - 1:
            return 0.0
        row = N_PARAMETERS * actuator
        table = carray(doubles_at(model, user_at), row + N_PARAMETERS)
        shared = carray(doubles_at(data, shared_at), N_USERDATA)
        length = carray(doubles_at(data, length_at), N_MOUNTS)
        velocity = carray(doubles_at(data, velocity_at), N_MOUNTS)
        kind = table[row + KIND]
        size = N_ACT + len(SUPPLY_STATES) + N_LEDGER  # of which only the part that the model has is touched
        act, act_dot = carray(doubles_at(data, act_at), size), carray(doubles_at(data, act_dot_at), size)
        if kind == SUPPLY:
            shared_supply_rates(act, act_dot, shared, table[row : row + len(SUPPLY_PARAMETERS)])
        elif kind == LEDGER:
            ledger_rates(act, act_dot, velocity, length, shared, table, int(table[row + LEDGER_OFFSET]))
        else:
            control = carray(doubles_at(data, ctrl_at), N_MOUNTS)
            actuator_rates(act, act_dot, length, velocity, control, shared, table)
        return 0.0

    def act_bias(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo asks for forces after it has asked for all rates: the rates have left them.
        return carray(doubles_at(data, shared_at), N_USERDATA)[STAGE_FORCE + actuator]

    on_state = types.void(types.intp, types.intp)
    on_actuator = types.float64(types.intp, types.intp, types.int32)
    with compiled_here() as kept:
        return Callbacks(
            numba.cfunc(on_state, cache=kept, nopython=True, error_model="numpy")(passive),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_dyn),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_bias),
        )
