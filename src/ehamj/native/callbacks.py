"""The hydraulics as MuJoCo sees them: three native callbacks that depend on (model, data, id) alone.

Parameters are columns of ``actuator_user``, states are activations, inputs of a step are cubics in ``userdata``
(`ehamj.layout`). So one set of callbacks serves every model, thread and batch of the process.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import carray, types

from ehamj.compiled import kernel
from ehamj.hydraulics.cylinder import chamber_flows, pressure_rate
from ehamj.hydraulics.valve import spool_acceleration, spool_target
from ehamj.layout import (
    COLUMN,
    CUBICS,
    JOINTS,
    N_MOUNTS,
    N_STATES,
    N_USERDATA,
    PARAMETERS,
    STAGE_COMMAND,
    STAGE_DRAWN,
    STAGE_FLOW,
    STAGE_GROUND,
    STAGE_GROUND_RATE,
    STEP_RATE,
    STEP_START,
)
from ehamj.native.cache import compiled_here
from ehamj.native.offsets import offsets
from ehamj.native.pointers import doubles_at, load_double

AREA, VOLUME_1, VOLUME_2 = COLUMN["piston_area"], COLUMN["volume_1"], COLUMN["volume_2"]
MOVING, BULK_MODULUS, VAPOUR_PRESSURE = COLUMN["moving_volume"], COLUMN["bulk_modulus"], COLUMN["vapour_pressure"]
FLOW_GAIN, EDGE_LEAKAGE, CROSS_LEAKAGE = COLUMN["flow_gain"], COLUMN["edge_leakage"], COLUMN["cross_leakage"]
LAMINAR_RATIO, SUPPLY, TANK = COLUMN["laminar_ratio"], COLUMN["supply_pressure"], COLUMN["tank_pressure"]
VALVE_GAIN, FREQUENCY, DAMPING = COLUMN["valve_gain"], COLUMN["valve_frequency"], COLUMN["valve_damping"]
DRIVE_LIMIT, SPOOL_STROKE, VOLTAGE_LIMIT = (
    COLUMN["spool_drive_limit"],
    COLUMN["spool_stroke"],
    COLUMN["voltage_limit"],
)
STIFFNESS, VISCOUS = COLUMN["membrane_stiffness"], COLUMN["membrane_damping"]
LATERAL_STIFFNESS, LATERAL_DAMPING = COLUMN["lateral_stiffness"], COLUMN["lateral_damping"]
MOUNT_X, MOUNT_Y, WEIGHT = COLUMN["mount_x"], COLUMN["mount_y"], COLUMN["weight"]
N_PARAMETERS = len(PARAMETERS)
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
def actuator_rates(act, act_dot, length, velocity, control, shared, table):  # type: ignore[no-untyped-def]
    """Time derivatives of the states of all actuators, and their flows into ``shared``."""
    for mount in range(N_MOUNTS):
        first, own = N_STATES * mount, N_PARAMETERS * mount
        spool, rate, pressure_1, pressure_2 = act[first], act[first + 1], act[first + 2], act[first + 3]
        stroke = length[mount] - shared[STAGE_GROUND + mount]
        swept = table[own + AREA] * (velocity[mount] - shared[STAGE_GROUND_RATE + mount])
        target = spool_target(
            control[mount] + shared[STAGE_COMMAND + mount], table[own + VALVE_GAIN], table[own + VOLTAGE_LIMIT]
        )
        flow_1, flow_2, drawn = chamber_flows(
            spool,
            pressure_1,
            pressure_2,
            table[own + SUPPLY],
            table[own + TANK],
            table[own + FLOW_GAIN],
            table[own + SPOOL_STROKE],
            table[own + EDGE_LEAKAGE],
            table[own + CROSS_LEAKAGE],
            table[own + LAMINAR_RATIO],
        )
        moved = table[own + MOVING] * table[own + AREA] * stroke
        volume_1, volume_2 = table[own + VOLUME_1] + moved, table[own + VOLUME_2] - moved
        beta, vapour = table[own + BULK_MODULUS], table[own + VAPOUR_PRESSURE]
        act_dot[first] = rate
        act_dot[first + 1] = spool_acceleration(
            spool, rate, target, table[own + FREQUENCY], table[own + DAMPING], table[own + DRIVE_LIMIT]
        )
        act_dot[first + 2] = pressure_rate(flow_1, swept, pressure_1, volume_1, beta, vapour)
        act_dot[first + 3] = pressure_rate(flow_2, -swept, pressure_2, volume_2, beta, vapour)
        shared[STAGE_FLOW + 2 * mount] = flow_1
        shared[STAGE_FLOW + 2 * mount + 1] = flow_2
        shared[STAGE_DRAWN + mount] = drawn


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

    def passive(model, data):  # type: ignore[no-untyped-def]
        shared = carray(doubles_at(data, shared_at), N_USERDATA)
        table = carray(doubles_at(model, user_at), N_MOUNTS * N_PARAMETERS)
        stage_inputs(load_double(data, time_at), shared, table, carray(doubles_at(data, passive_at), len(JOINTS)))

    def act_dyn(model, data, actuator):  # type: ignore[no-untyped-def]
        # MuJoCo clears and asks actuator by actuator; answering for all at the last one halves the cost.
        if actuator == N_MOUNTS - 1:
            actuator_rates(
                carray(doubles_at(data, act_at), N_STATES * N_MOUNTS),
                carray(doubles_at(data, act_dot_at), N_STATES * N_MOUNTS),
                carray(doubles_at(data, length_at), N_MOUNTS),
                carray(doubles_at(data, velocity_at), N_MOUNTS),
                carray(doubles_at(data, ctrl_at), N_MOUNTS),
                carray(doubles_at(data, shared_at), N_USERDATA),
                carray(doubles_at(model, user_at), N_MOUNTS * N_PARAMETERS),
            )
        return 0.0

    def act_bias(model, data, actuator):  # type: ignore[no-untyped-def]
        table = carray(doubles_at(model, user_at), N_MOUNTS * N_PARAMETERS)
        act = carray(doubles_at(data, act_at), N_STATES * N_MOUNTS)
        shared = carray(doubles_at(data, shared_at), N_USERDATA)
        own, first = N_PARAMETERS * actuator, N_STATES * actuator
        oil = table[own + AREA] * (act[first + 2] - act[first + 3])
        still = table[own + STIFFNESS] * shared[STAGE_GROUND + actuator]
        moving = table[own + VISCOUS] * shared[STAGE_GROUND_RATE + actuator]
        return oil + still + moving + table[own + WEIGHT]

    on_state = types.void(types.intp, types.intp)
    on_actuator = types.float64(types.intp, types.intp, types.int32)
    with compiled_here() as kept:
        return Callbacks(
            numba.cfunc(on_state, cache=kept, nopython=True, error_model="numpy")(passive),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_dyn),
            numba.cfunc(on_actuator, cache=kept, nopython=True, error_model="numpy")(act_bias),
        )
