"""The compiled model as a state equation: its rates, its static equilibrium, its Jacobian.

The state is (qpos, qvel, activations); the inputs are ground displacement and velocity per mount and axis, and the
commands of the valves. Call everything here with the hydraulics installed (`ehamj.mujoco.hydraulics`).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.cylinder import chamber_volumes
from ehamj.isolator.supply import Supply, SupplyState, middle
from ehamj.memory import activations, exchange, isolators, mounts_of, option_scales, slides_of, step, supply
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import AXES, JOINTS

TIPPED: Final = 0.2
"""Angle from which a machine that comes to rest has tipped over [rad]: Newton's method also finds those that hang."""

HINGES: Final = [JOINTS.index(dof) for dof in ("rx", "ry", "rz")]


class EquilibriumError(RuntimeError):
    """No static equilibrium was found."""


@dataclass(frozen=True)
class Inputs:
    """Held inputs: ground displacement [m] and velocity [m/s] (mount, axis), command [V] (mount)."""

    displacement: Array
    velocity: Array
    command: Array

    @classmethod
    def rest(cls, model: mujoco.MjModel) -> "Inputs":
        """Ground at rest, valves centred."""
        mounts = mounts_of(model)
        return cls(np.zeros((mounts, len(AXES))), np.zeros((mounts, len(AXES))), np.zeros(mounts))

    @property
    def at_rest(self) -> bool:
        """Whether they are those of `rest`."""
        return not (self.displacement.any() or self.velocity.any() or self.command.any())

    def write(self, data: mujoco.MjData) -> None:
        """Hand the inputs to the callbacks as the start of a step of one second."""
        data.userdata[:] = 0.0
        begun, mounts = step(data), exchange(data, self.command.size)
        begun["start"], begun["rate"] = data.time, 1.0
        for axis, name in enumerate(AXES):
            cubic = mounts[f"ground_{name}"]
            cubic["value"], cubic["slope"] = self.displacement[:, axis], self.velocity[:, axis]
        mounts["open_loop"]["value"] = self.command


def rates(model: mujoco.MjModel, data: mujoco.MjData, state: Array, inputs: Inputs) -> Array:
    """Time derivative of ``state`` under held ``inputs``: (qvel, qacc, activation rates)."""
    nq, nv = model.nq, model.nv
    data.qpos[:], data.qvel[:], data.act[:] = state[:nq], state[nq : nq + nv], state[nq + nv :]
    inputs.write(data)
    mujoco.mj_forward(model, data)
    return np.concatenate([data.qvel, data.qacc, data.act_dot])


def rates_along(model: mujoco.MjModel, data: mujoco.MjData, states: Array, inputs: Inputs) -> Array:
    """`rates` of many states (n, state), each under its own inputs, which have the n in front."""
    nq, nv, found = model.nq, model.nv, np.empty_like(states)
    Inputs(inputs.displacement[0], inputs.velocity[0], inputs.command[0]).write(data)
    mounts = exchange(data, inputs.command.shape[1])
    cubics = [(k, mounts[f"ground_{axis}"]["value"], mounts[f"ground_{axis}"]["slope"]) for k, axis in enumerate(AXES)]
    command = mounts["open_loop"]["value"]
    for row, state in enumerate(states):
        data.qpos[:], data.qvel[:], data.act[:] = state[:nq], state[nq : nq + nv], state[nq + nv :]
        command[:] = inputs.command[row]
        for k, value, slope in cubics:
            value[:], slope[:] = inputs.displacement[row, :, k], inputs.velocity[row, :, k]
        mujoco.mj_forward(model, data)
        found[row, :nv], found[row, nv : 2 * nv], found[row, 2 * nv :] = data.qvel, data.qacc, data.act_dot
    return found


def scales(model: mujoco.MjModel) -> Array:
    """A small motion of each state, as a step for differences: 0.1 µm or µrad, 0.1 mm/s, 10 µA, 10 mA/s, 100 Pa.

    Of the shared supply 100 Pa and 10 mm³/s; the ledger's states act on nothing, and take any step.
    """
    small = np.concatenate([np.full(model.nq, 1e-7), np.full(model.nv, 1e-4), np.ones(model.na)])
    parts = activations(model, small[model.nq + model.nv :])
    parts.isolators[:] = (1e-2, 10.0, 1e2, 1e2)
    parts.options[:] = option_scales(model)
    parts.supply[:] = tuple(SupplyState(1e2, 1e-8, 1e2))
    return small


def jacobian(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    state: Array,
    inputs: Inputs,
    over: Iterable[int] | None = None,
    finer: float = 1.0,
) -> Array:
    """∂rates/∂state by central differences, shape (n, n): ``over`` all states or some, by steps so many times finer."""
    chosen, steps = list(range(state.size) if over is None else over), scales(model) / finer
    shifts = np.diag(steps)[chosen]
    shifted = np.concatenate([state + shifts, state - shifts])
    given = (inputs.displacement, inputs.velocity, inputs.command)
    held = Inputs(*(np.broadcast_to(one, (len(shifted), *one.shape)) for one in given))
    ahead, behind = np.split(rates_along(model, data, shifted, held), 2)
    return np.asarray(((ahead - behind) / (2.0 * steps[chosen])[:, None]).T)


def equilibrium(model: mujoco.MjModel, data: mujoco.MjData, inputs: Inputs) -> Array:
    """Static equilibrium under gravity with held inputs, left in ``data`` and returned as a state.

    Spools stand where the commands put them; positions and pressures are found by Newton's method from the unloaded
    machine with chambers at mid pressure. Where the pressures are not determined (no leakage over the edges: the mean
    pressure is neutral), the solution nearest to that start is taken, which keeps the mean.

    Raises:
        EquilibriumError: if Newton's method does not converge, or only where the machine has tipped over.
    """
    state, unknown, balance, unit, tolerance = _balance(model, inputs)
    still = Inputs(inputs.displacement, np.zeros_like(inputs.velocity), inputs.command)

    def residual(at: Array) -> Array:
        return rates(model, data, at, still)[balance] / tolerance

    def solution(state: Array, levelled: bool) -> Array | None:
        """By Newton's method; ``levelled`` weighs all balances alike, where soft mounts would count for rounding."""
        error = residual(state)
        for _ in range(60):
            if np.abs(error).max() <= 1.0:
                return state
            matrix = jacobian(model, data, state, still)[np.ix_(balance, unknown)] / tolerance[:, None] * unit
            sizes = np.linalg.norm(matrix, axis=1) if levelled else np.ones(error.size)
            sizes[sizes == 0.0] = 1.0
            change = np.linalg.lstsq(matrix / sizes[:, None], -error / sizes, rcond=1e-10)[0] * unit
            for _ in range(30):  # halve the step until the balance improves
                trial = state.copy()
                trial[unknown] += change
                trial_error = residual(trial)
                if np.linalg.norm(trial_error) < np.linalg.norm(error):
                    break
                change = 0.5 * change
            else:
                return None
            state, error = trial, trial_error
        return None

    said, turned = "no static equilibrium: the machine cannot stand under these loads and commands", 0.0
    for levelled in (False, True):
        found = solution(state, levelled)
        if found is not None:
            turned = float(np.abs(found[HINGES]).max())
            if turned < TIPPED:
                _check_strokes(model, data)
                return found
    if turned > 0.0:
        said += f", it would come to rest turned by {turned:.2g} rad (at most {TIPPED:g} rad: more has tipped over)"
    raise EquilibriumError(said)


def _balance(model: mujoco.MjModel, inputs: Inputs) -> tuple[Array, ...]:
    """The problem of a static equilibrium: positions against forces, every other unknown against its own rate.

    Where valves have states of their own, these and the spools are unknown too.

    Returns:
        The state to begin from; which states are unknown; which rates vanish; a motion of each unknown, for the
        solver's scaling; the tolerance of each rate.
    """
    nq, nv, own = model.nq, model.nv, isolators(model)
    state = np.zeros(nq + nv + model.na)
    parts = activations(model, state[nq + nv :])
    moves = np.delete(np.arange(nq), FIRST + np.arange(slides_of(model)))  # slides stand where they are
    number = activations(model, np.arange(nq + nv, state.size, dtype=float))
    mid = 0.5 * (own["supply_pressure"] + own["tank_pressure"])
    limit = own["voltage_limit"]
    asked = own["valve_gain"] * np.clip(inputs.command, -limit, limit)
    parts.isolators["spool"] = np.where(own["spool_stuck"], own["spool_stuck_at"] * own["spool_stroke"], asked)
    parts.isolators["pressure_1"] = parts.isolators["pressure_2"] = mid
    fine = 1e-9 * (own["bulk_modulus"] / own["volume_1"]) * (own["flow_gain"] * own["spool_stroke"])
    pressures = np.column_stack([number.isolators["pressure_1"], number.isolators["pressure_2"]]).ravel()
    # For each kind of unknown: which, what balances it, its unit, and the tolerance of that balance.
    kinds = [
        (moves, nq + moves, np.full(moves.size, 1e-5), np.full(moves.size, 1e-7)),
        (pressures, pressures, np.repeat(np.maximum(mid, own["rated_pressure"]), 2), np.repeat(fine, 2)),
    ]
    if number.options.size:
        small = option_scales(model)
        kinds.append((number.isolators["spool"], number.isolators["spool_rate"], np.ones(own.size), np.ones(own.size)))
        kinds.append((number.options, number.options, 1e3 * small, small))
    shared = supply(model)
    if shared is not None:
        parts.supply[0] = tuple(middle(Supply.Values(*shared)))
        places = number.supply.view(float)
        kinds.append((places, places, np.array([1e6, 1e-5, 1e6]), np.array([1.0, 1e-9, 1.0]) * fine[0]))
    unknown, balance, unit, tolerance = (np.concatenate(parts) for parts in zip(*kinds, strict=True))
    return state, unknown.astype(int), balance.astype(int), unit, tolerance


def _check_strokes(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise EquilibriumError where the balance found lies beyond the end of a cylinder."""
    stroke = data.actuator_length[: mounts_of(model)] - exchange(data, mounts_of(model))["ground"]
    volume = np.minimum(*chamber_volumes.py_func(stroke, isolators(model).view(np.recarray)))
    worst = int(np.argmin(volume))
    if volume[worst] <= 0.0:
        raise EquilibriumError(
            "no static equilibrium: the machine cannot stand under these loads and commands, "
            f"at {model.actuator(worst).name} the stroke would be {stroke[worst]:.3g} m, which empties a chamber"
        )
