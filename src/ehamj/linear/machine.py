"""The whole machine as one linear system with all its states, from the compiled model that is simulated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.control.channels import (
    ACCELERATION,
    DISPLACEMENT,
    GROUND,
    N_SIGNALS,
    PLATE,
    STATE,
    VELOCITY,
    channel_names,
    channel_row,
    point_row,
)
from ehamj.control.law import OUTPUTS as COMMANDS
from ehamj.errors import InputError
from ehamj.memory import ISOLATOR_STATE, size, states_of
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium, jacobian, rates, scales
from ehamj.mujoco.model import build_model, reduced
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS, JOINTS
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]
Point = tuple[float, float, float]

GROUND_INPUTS = tuple(f"ground_{what} {m} {a}" for what in ("displacement", "velocity") for m in MOUNTS for a in AXES)
FORCES = tuple(f"cg_force {dof}" for dof in DOFS)
"""Force [N] and moment [N m] at the centre of gravity, in the axes of the ground."""

INPUTS = (*COMMANDS, *GROUND_INPUTS, *FORCES)


@dataclass(frozen=True)
class LinearModel:
    """ẋ = A x + B u about an operating point; channels y = S·signals, signals = C x + D u.

    ``states`` and ``inputs`` name the columns; deviations are in SI, spools in mA, commands in V. ``signals`` (C, D)
    are the vector of `ehamj.control.channels` from which every output is composed; the ground's acceleration is not
    among them, since displacement and velocity are the inputs.
    """

    plant: Plant
    states: tuple[str, ...]
    A: Array
    B: Array
    signals: tuple[Array, Array]
    equilibrium: Array
    """The operating point as a state: positions [m, rad], zero velocities, spools [mA], pressures [Pa]."""
    inputs: tuple[str, ...] = INPUTS

    def rows(self, outputs: Sequence[str], points: Mapping[str, Point] | None = None) -> tuple[Array, Array]:
        """C and D of named channels; ``points`` adds POINT_displacement x and the like for points of the machine.

        Raises:
            InputError: if a channel is unknown, or is the ground's acceleration.
        """
        rows = np.array([self._row(name, points or {}) for name in outputs]).reshape(len(outputs), N_SIGNALS)
        return rows @ self.signals[0], rows @ self.signals[1]

    def _row(self, name: str, points: Mapping[str, Point]) -> Array:
        variable, _, label = name.partition(" ")
        body, _, motion = variable.rpartition("_")
        if body in points and motion in ("displacement", "velocity", "acceleration") and label in AXES:
            row = np.zeros(N_SIGNALS)
            first = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "acceleration": ACCELERATION}[motion]
            row[first : first + len(DOFS)] = point_row(points[body], AXES.index(label))
            return row
        if name.startswith("ground_acceleration"):
            raise InputError(f"output {name!r}: the ground's displacement and velocity are inputs of the linear model")
        try:
            return channel_row(name, self.plant)
        except ValueError as error:
            raise InputError(f"output: {error}") from error

    def response(self, hertz: ArrayLike, outputs: Sequence[str], inputs: Sequence[str]) -> NDArray[np.complex128]:
        """Frequency response at ``hertz`` [Hz], shape (frequency, output, input)."""
        C, D = self.rows(outputs)
        columns = [self.inputs.index(name) for name in inputs]
        identity = np.eye(self.A.shape[0])
        omega = 2j * np.pi * np.atleast_1d(np.asarray(hertz, float))
        return np.array([C @ np.linalg.solve(s * identity - self.A, self.B[:, columns]) + D[:, columns] for s in omega])

    def from_ground(
        self, hertz: ArrayLike, outputs: Sequence[str], motion: NDArray[np.complex128]
    ) -> NDArray[np.complex128]:
        """Response to a ground displacement of complex amplitude ``motion`` (mount, axis) or (frequency, mount, axis).

        The ground's velocity, jω times the displacement, comes with it. Shape (frequency, output).
        """
        f = np.atleast_1d(np.asarray(hertz, float))
        amplitude = np.broadcast_to(motion, (f.size, N_MOUNTS, len(AXES))).reshape(f.size, -1)
        both = self.response(f, outputs, GROUND_INPUTS)
        half = both.shape[2] // 2
        transfer = both[:, :, :half] + (2j * np.pi * f)[:, None, None] * both[:, :, half:]
        return np.einsum("foi,fi->fo", transfer, amplitude)


def linear_model(
    scenario: Scenario, commands: ArrayLike | None = None, load: ArrayLike = (0.0,) * 6, feet: bool = False
) -> LinearModel:
    """Linearise the machine of a scenario about its static equilibrium.

    Args:
        scenario: what is linearised; ground and control play no part.
        commands: held commands, one per valve [V]; zero without.
        load: held force and moment at the centre of gravity, (6,) [N, N m].
        feet: keep sliding plates as states of their own even where all feet are rigid (the constraint's poles with
            them); without, rigid plates are tied to the machine, which are the same equations.

    Raises:
        InputError: if there is no such operating point.
    """
    plant = replace(scenario.plant if feet else reduced(scenario.plant), bookkeeping=False)
    model = build_model(plant, 1e-4)
    data = mujoco.MjData(model)
    force = _finite("load", load, len(DOFS))
    data.xfrc_applied[model.body("machine").id] = force
    held = Inputs.rest(model)
    held.command[:] = 0.0 if commands is None else _finite("commands", commands, N_MOUNTS)
    with hydraulics():
        try:
            state = equilibrium(model, data, held)
        except EquilibriumError as error:
            held_at = f"load = {force.tolist()} N, N m, commands = {held.command.tolist()} V"
            limit = f"the membranes and the oil (up to {plant.supply.pressure:g} Pa) must carry the load"
            raise InputError(f"operating point: {error}; {held_at}; {limit}") from error
        A = jacobian(model, data, state, held)
        B = _input_matrix(model, data, state, held)
    return LinearModel(plant, _state_names(model, plant), A, B, _signal_matrices(model, plant, A, B), state)


def _finite(name: str, values: ArrayLike, size: int) -> Array:
    array = np.asarray(values, float)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InputError(f"{name} = {array.tolist()}: must be {size} finite numbers")
    return array


def linearise(
    scenario: Scenario,
    outputs: Sequence[str] | None = None,
    points: Mapping[str, Point] | None = None,
    commands: ArrayLike | None = None,
    load: ArrayLike = (0.0,) * 6,
) -> Any:
    """The machine of a scenario as a ``control.StateSpace`` with named states, inputs and outputs.

    Inputs are the four commands [V], displacement [m] and velocity [m/s] of the ground at each mount and axis, and
    forces at the centre of gravity (`INPUTS`). Outputs are channels as in the result (`ehamj.control.channels`), all
    of them by default.

    Args:
        scenario: what is linearised about its static equilibrium.
        outputs: channel names.
        points: further points of the machine by name [m from the mount plane's centre], which give the outputs
            ``NAME_displacement x`` and so on.
        commands: held commands [V].
        load: held force and moment at the centre of gravity [N, N m].

    Raises:
        InputError: if a channel is unknown, or the operating point does not exist.
    """
    import control

    model = linear_model(scenario, commands, load)
    if outputs is None:
        outputs = [name for name in channel_names() if not name.startswith("ground_")]
        outputs += [
            f"{name}_{what} {axis}"
            for name in points or {}
            for what in ("displacement", "velocity", "acceleration")
            for axis in AXES
        ]
    C, D = model.rows(outputs, points)
    return control.ss(
        model.A, model.B, C, D, states=list(model.states), inputs=list(model.inputs), outputs=list(outputs),
        name=scenario.name.replace(".", "-"),
    )  # fmt: skip


def _state_names(model: mujoco.MjModel, plant: Plant) -> tuple[str, ...]:
    joints = [*JOINTS, *(f"plate {mount}" for mount in plant.mounts)][: model.nq]
    motion = [f"{what} {joint}" for what in ("displacement", "velocity") for joint in joints]
    return (*motion, *states_of(model))


def _input_matrix(model: mujoco.MjModel, data: mujoco.MjData, state: Array, held: Inputs) -> Array:
    """∂rates/∂inputs by central differences, columns as `INPUTS`."""
    machine = model.body("machine").id
    columns = []

    def difference(step: float, ahead: Inputs, behind: Inputs) -> None:
        columns.append((rates(model, data, state, ahead) - rates(model, data, state, behind)) / (2.0 * step))

    for mount in range(N_MOUNTS):
        step = np.zeros(N_MOUNTS)
        step[mount] = 1e-3
        difference(1e-3, *(Inputs(held.displacement, held.velocity, held.command + s * step) for s in (1, -1)))
    small = scales(model)
    for order, move in ((0, small[0]), (1, small[model.nq])):
        for k in range(N_MOUNTS * len(AXES)):
            step = np.zeros(N_MOUNTS * len(AXES))
            step[k] = move
            parts = [held.displacement, held.velocity]
            pair = []
            for sign in (1, -1):
                moved = list(parts)
                moved[order] = parts[order] + sign * step.reshape(N_MOUNTS, len(AXES))
                pair.append(Inputs(moved[0], moved[1], held.command))
            difference(move, *pair)
    load = data.xfrc_applied[machine].copy()
    for dof in range(len(DOFS)):
        found = []
        for sign in (1, -1):
            data.xfrc_applied[machine] = load
            data.xfrc_applied[machine, dof] += sign * 100.0
            found.append(rates(model, data, state, held))
        columns.append((found[0] - found[1]) / 200.0)
    data.xfrc_applied[machine] = load
    return np.array(columns).T


def _signal_matrices(model: mujoco.MjModel, plant: Plant, A: Array, B: Array) -> tuple[Array, Array]:
    """The vector of signals (`ehamj.control.channels`) from state and input."""
    nq, nv, n = model.nq, model.nv, A.shape[0]
    C, D = np.zeros((N_SIGNALS, n)), np.zeros((N_SIGNALS, B.shape[1]))
    for dof, column in enumerate(DOF_OF_JOINT):
        C[DISPLACEMENT + dof, column] = C[VELOCITY + dof, nq + column] = 1.0
        C[ACCELERATION + dof], D[ACCELERATION + dof] = A[nq + column], B[nq + column]
    grounds = N_MOUNTS * len(AXES)
    D[GROUND : GROUND + 2 * grounds, N_MOUNTS : N_MOUNTS + 2 * grounds] = np.eye(2 * grounds)
    own = N_MOUNTS * size(ISOLATOR_STATE)
    C[STATE : STATE + own, nq + nv : nq + nv + own] = np.eye(own)
    for mount, (x, y) in enumerate(plant.positions):
        for order, first in enumerate((0, nq)):
            row = PLATE + N_MOUNTS * order + mount
            if plant.plates == "sliding":
                C[row, first + len(JOINTS) + mount] = 1.0
            else:
                for joint, lever in (("z", 1.0), ("rx", y), ("ry", -x)):
                    C[row, first + JOINTS.index(joint)] = lever
    return C, D
