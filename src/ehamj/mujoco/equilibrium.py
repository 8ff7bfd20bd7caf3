"""The compiled model as a state equation: its rates, its static equilibrium, its Jacobian.

The state is (qpos, qvel, activations); the inputs are ground displacement and velocity per mount and axis, and the
four commands. Call everything here with the hydraulics installed (`ehamj.mujoco.hydraulics`).
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from ehamj.memory import (
    COLUMN,
    CUBICS,
    N_INPUTS,
    N_STATES,
    N_USERDATA,
    STEP_RATE,
    STEP_START,
    SUPPLY_PARAMETERS,
    SUPPLY_STATES,
)
from ehamj.plant.mounts import MOUNTS, N_MOUNTS

Array = NDArray[np.float64]


class EquilibriumError(RuntimeError):
    """No static equilibrium was found."""


@dataclass(frozen=True)
class Inputs:
    """Held inputs: ground displacement [m] and velocity [m/s] (mount, axis), command [V] (mount)."""

    displacement: Array
    velocity: Array
    command: Array

    @classmethod
    def rest(cls) -> "Inputs":
        """Ground at rest, valves centred."""
        return cls(np.zeros((N_MOUNTS, 3)), np.zeros((N_MOUNTS, 3)), np.zeros(N_MOUNTS))

    def write(self, data: mujoco.MjData) -> None:
        """Hand the inputs to the callbacks as the start of a step of one second."""
        shared = np.zeros(N_USERDATA)
        shared[STEP_START], shared[STEP_RATE] = data.time, 1.0
        cubics = shared[CUBICS : CUBICS + 4 * N_INPUTS].reshape(N_INPUTS, 4)
        cubics[:12, 0], cubics[:12, 1] = self.displacement.ravel(), self.velocity.ravel()
        cubics[12:, 0] = self.command
        data.userdata[:N_USERDATA] = shared


def state_of(data: mujoco.MjData) -> Array:
    """The state as one vector."""
    return np.concatenate([data.qpos, data.qvel, data.act])


def rates(model: mujoco.MjModel, data: mujoco.MjData, state: Array, inputs: Inputs) -> Array:
    """Time derivative of ``state`` under held ``inputs``: (qvel, qacc, activation rates)."""
    nq, nv = model.nq, model.nv
    data.qpos[:], data.qvel[:], data.act[:] = state[:nq], state[nq : nq + nv], state[nq + nv :]
    inputs.write(data)
    mujoco.mj_forward(model, data)
    return np.concatenate([data.qvel, data.qacc, data.act_dot])


def scales(model: mujoco.MjModel) -> Array:
    """A small motion of each state, as a step for differences: 0.1 µm or µrad, 0.1 mm/s, 10 µA, 10 mA/s, 100 Pa.

    Of the shared supply 100 Pa and 10 mm³/s; the ledger's states act on nothing, and take any step.
    """
    valves = np.tile([1e-2, 10.0, 1e2, 1e2], N_MOUNTS)
    others = np.ones(model.na - valves.size)
    if supply_states(model):
        others[: len(SUPPLY_STATES)] = 1e2, 1e-8, 1e2
    return np.concatenate([np.full(model.nq, 1e-7), np.full(model.nv, 1e-4), valves, others])


def supply_states(model: mujoco.MjModel) -> bool:
    """Whether the supply has states of its own."""
    return bool(model.actuator_user[0, COLUMN["shared_supply"]])


def jacobian(model: mujoco.MjModel, data: mujoco.MjData, state: Array, inputs: Inputs) -> Array:
    """∂rates/∂state by central differences, shape (n, n)."""
    columns = []
    for k, step in enumerate(scales(model)):
        shift = np.zeros_like(state)
        shift[k] = step
        ahead, behind = (rates(model, data, state + s * shift, inputs) for s in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step))
    return np.array(columns).T


def equilibrium(model: mujoco.MjModel, data: mujoco.MjData, inputs: Inputs) -> Array:
    """Static equilibrium under gravity with held inputs, left in ``data`` and returned as a state.

    Spools stand where the commands put them; positions and pressures are found by Newton's method from the unloaded
    machine with chambers at mid pressure. Where the pressures are not determined (no leakage over the edges: the mean
    pressure is neutral), the solution nearest to that start is taken, which keeps the mean.

    Raises:
        EquilibriumError: if Newton's method does not converge.
    """
    table = model.actuator_user[:N_MOUNTS]
    mid = 0.5 * (table[:, COLUMN["supply_pressure"]] + table[:, COLUMN["tank_pressure"]])
    limit = table[:, COLUMN["voltage_limit"]]
    state = np.zeros(model.nq + model.nv + model.na)
    first = model.nq + model.nv
    act = state[first : first + N_MOUNTS * N_STATES].reshape(N_MOUNTS, N_STATES)
    act[:, 0] = table[:, COLUMN["valve_gain"]] * np.clip(inputs.command, -limit, limit)
    act[:, 2:] = mid[:, None]
    pressures = first + np.arange(N_MOUNTS * N_STATES).reshape(N_MOUNTS, N_STATES)[:, 2:].ravel()
    supply = first + N_MOUNTS * N_STATES + np.arange(len(SUPPLY_STATES) if supply_states(model) else 0)
    if supply.size:  # begin where the pump controls, between no flow and all of it
        row = dict(zip(SUPPLY_PARAMETERS, model.actuator_user[N_MOUNTS], strict=False))
        middle = row["set_pressure"] - 0.5 * row["pump_flow"] / row["pump_conductance"]
        state[supply] = middle, 0.5 * row["pump_flow"], middle
    unknown = np.concatenate([np.arange(model.nq), pressures, supply])
    balance = np.concatenate([model.nq + np.arange(model.nv), pressures, supply])
    still = Inputs(inputs.displacement, np.zeros_like(inputs.velocity), inputs.command)
    unit = np.concatenate([np.full(model.nq, 1e-5), np.repeat(mid, 2), np.array([1e6, 1e-5, 1e6])[: supply.size]])
    stiffness = table[:, COLUMN["bulk_modulus"]] / table[:, COLUMN["volume_1"]]
    flow = table[:, COLUMN["flow_gain"]] * table[:, COLUMN["spool_stroke"]]
    fine = np.repeat(1e-9 * stiffness * flow, 2)
    tolerance = np.concatenate([np.full(model.nv, 1e-7), fine, np.array([1.0, 1e-9, 1.0])[: supply.size] * fine[0]])

    def residual(at: Array) -> Array:
        return rates(model, data, at, still)[balance] / tolerance

    error = residual(state)
    for _ in range(60):
        if np.abs(error).max() <= 1.0:
            _check_strokes(data, table, inputs)
            return state
        matrix = jacobian(model, data, state, still)[np.ix_(balance, unknown)] / tolerance[:, None] * unit
        change = np.linalg.lstsq(matrix, -error, rcond=1e-10)[0] * unit
        for _ in range(30):  # halve the step until the balance improves
            trial = state.copy()
            trial[unknown] += change
            trial_error = residual(trial)
            if np.linalg.norm(trial_error) < np.linalg.norm(error):
                break
            change = 0.5 * change
        else:
            break
        state, error = trial, trial_error
    raise EquilibriumError("no static equilibrium: the machine cannot stand under these loads and commands")


def _check_strokes(data: mujoco.MjData, table: Array, inputs: Inputs) -> None:
    """Raise EquilibriumError where the balance found lies beyond the end of a cylinder."""
    stroke = data.actuator_length[:N_MOUNTS] - inputs.displacement[:, 2]
    moved = table[:, COLUMN["moving_volume"]] * stroke
    volume_1 = table[:, COLUMN["volume_1"]] + table[:, COLUMN["piston_area"]] * moved
    volume_2 = table[:, COLUMN["volume_2"]] - table[:, COLUMN["piston_area_2"]] * moved
    worst = int(np.argmin(np.minimum(volume_1, volume_2)))
    if min(volume_1[worst], volume_2[worst]) <= 0.0:
        raise EquilibriumError(
            "no static equilibrium: the machine cannot stand under these loads and commands, "
            f"at {MOUNTS[worst]} the stroke would be {stroke[worst]:.3g} m, which empties a chamber"
        )
