"""The whole machine as one linear system with all its states, from the compiled model that is simulated.

`LinearModel` is in SI, as it is differentiated; what `linearise` hands out has scaled states (`ehamj.linear.plants`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array
from ehamj.control import blocks
from ehamj.control.channels import SUPPLY, channel_row, is_upstream
from ehamj.control.compiled.signals import Layout
from ehamj.errors import InputError
from ehamj.isolator.equations import State
from ehamj.linear.smooth import check_smooth
from ehamj.memory import states_of
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium, jacobian, rates, scales
from ehamj.mujoco.model import build_model, reduced
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS, JOINTS
from ehamj.plant.kinematics import points_motion
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant

Point = tuple[float, float, float]

FORCES = tuple(f"cg_force {dof}" for dof in DOFS)
"""Force [N] and moment [N m] at the centre of gravity, in the axes of the ground."""


def grounds(mounts: Sequence[str]) -> tuple[str, ...]:
    """The ground's own degrees of freedom: each mount and axis."""
    return tuple(f"{mount} {axis}" for mount in mounts for axis in AXES)


def inputs_of(mounts: Sequence[str]) -> tuple[str, ...]:
    """Commands [V], displacement [m] and velocity [m/s] of the ground, and `FORCES`."""
    ground = (f"ground_{what} {place}" for what in ("displacement", "velocity") for place in grounds(mounts))
    return (*(f"valve_command {mount}" for mount in mounts), *ground, *FORCES)


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
    inputs: tuple[str, ...]

    @property
    def commands(self) -> tuple[str, ...]:
        """The valves' commands among the inputs, in the order of the mounts."""
        return self.inputs[: len(self.plant.mounts)]

    @property
    def ground_inputs(self) -> tuple[str, ...]:
        """Displacements of the ground at each mount and axis among the inputs, then velocities."""
        return self.inputs[len(self.plant.mounts) : -len(FORCES)]

    def rows(self, outputs: Sequence[str], points: Mapping[str, Point] | None = None) -> tuple[Array, Array]:
        """C and D of named channels; ``points`` adds POINT_displacement x and the like for points of the machine.

        Raises:
            InputError: if a channel is unknown, or is the ground's acceleration.
        """
        signals = self.signals[0].shape[0]
        rows = np.array([self._row(name, points or {}) for name in outputs]).reshape(len(outputs), signals)
        return rows @ self.signals[0], rows @ self.signals[1]

    def _row(self, name: str, points: Mapping[str, Point]) -> Array:
        variable, _, label = name.partition(" ")
        body, _, motion = variable.rpartition("_")
        if body in points and motion in ("displacement", "velocity", "acceleration") and label in AXES:
            row, first = np.zeros(self.signals[0].shape[0]), getattr(Layout.of(len(self.plant.mounts)), motion)
            row[first : first + len(DOFS)] = lever(points[body])[AXES.index(label)]
            return row
        if name.startswith("ground_acceleration"):
            raise InputError(f"output {name!r}: the ground's displacement and velocity are inputs of the linear model")
        if is_upstream(name):
            raise InputError(f"output {name!r}: the linear model has the ground below its mounts alone; read it there")
        try:
            return channel_row(name, self.plant)
        except ValueError as error:
            raise InputError(f"output: {error}") from error

    def response(self, hertz: ArrayLike, outputs: Sequence[str], inputs: Sequence[str]) -> NDArray[np.complex128]:
        """Frequency response at ``hertz`` [Hz], shape (frequency, output, input)."""
        C, D = self.rows(outputs)
        columns = [self.inputs.index(name) for name in inputs]
        s = 2j * np.pi * np.atleast_1d(np.asarray(hertz, float))
        return blocks.response(s, self.A, self.B[:, columns], C, D[:, columns])


def linear_model(
    plant: Plant, commands: ArrayLike | None = None, load: ArrayLike = (0.0,) * 6, feet: bool = False
) -> LinearModel:
    """Linearise a machine about its static equilibrium.

    Args:
        plant: what is linearised; its slides stand where they start, see `Plant.locked`.
        commands: held commands, one per valve [V]; zero without.
        load: held force and moment at the centre of gravity, (6,) [N, N m].
        feet: keep sliding plates as states of their own even where all feet are rigid (the constraint's poles with
            them); without, rigid plates are tied to the machine, which are the same equations.

    Raises:
        InputError: if there is no such operating point, or a valve's option has no derivative there (`NotSmooth`).
    """
    plant = replace(plant.locked() if feet else reduced(plant.locked()), bookkeeping=False)
    model = build_model(plant, 1e-4)
    data = mujoco.MjData(model)
    force = _finite("load", load, len(DOFS))
    data.xfrc_applied[model.body("machine").id] = force
    held = Inputs.rest(model)
    held.command[:] = 0.0 if commands is None else _finite("commands", commands, len(plant.mounts))
    with hydraulics():
        try:
            state = equilibrium(model, data, held)
        except EquilibriumError as error:
            held_at = f"load = {force.tolist()} N, N m, commands = {held.command.tolist()} V"
            limit = f"the membranes and the oil (up to {plant.supply.pressure:g} Pa) must carry the load"
            keys = "machine.mass, part, slide, actuators, supply"
            raise InputError(f"operating point: {error} ({keys}); {held_at}; {limit}") from error
        A = jacobian(model, data, state, held)
        check_smooth(model, data, state, held, plant, A)
        B = _input_matrix(model, data, state, held)
    states, inputs = _state_names(model, plant.mounts), inputs_of(plant.mounts)
    return LinearModel(plant, states, A, B, _signal_matrices(plant, states, A, B, state), state, inputs)


def _finite(name: str, values: ArrayLike, size: int) -> Array:
    array = np.asarray(values, float)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InputError(f"{name} = {array.tolist()}: must be {size} finite numbers")
    return array


def _state_names(model: mujoco.MjModel, mounts: Sequence[str]) -> tuple[str, ...]:
    joints = [*JOINTS, *(f"plate {mount}" for mount in mounts)][: model.nq]
    motion = [f"{what} {joint}" for what in ("displacement", "velocity") for joint in joints]
    return (*motion, *states_of(model))


def _input_matrix(model: mujoco.MjModel, data: mujoco.MjData, state: Array, held: Inputs) -> Array:
    """∂rates/∂inputs by central differences, columns as `inputs_of`."""
    columns = []
    small = scales(model)
    for name, size in (("command", 1e-3), ("displacement", small[0]), ("velocity", small[model.nq])):
        value = getattr(held, name)
        for k in range(value.size):
            step = np.zeros(value.size)
            step[k] = size
            ahead, behind = (
                rates(model, data, state, replace(held, **{name: value + sign * step.reshape(value.shape)}))
                for sign in (1, -1)
            )
            columns.append((ahead - behind) / (2.0 * size))
    load = data.xfrc_applied[model.body("machine").id]
    for dof in range(len(DOFS)):
        found, at = [], load[dof]
        for sign in (1, -1):
            load[dof] = at + sign * 100.0
            found.append(rates(model, data, state, held))
        load[dof] = at
        columns.append((found[0] - found[1]) / 200.0)
    return np.array(columns).T


def _signal_matrices(plant: Plant, states: Sequence[str], A: Array, B: Array, state: Array) -> tuple[Array, Array]:
    """The vector of signals (`ehamj.control.channels`) from state and input, about an operating point ``state``."""
    at = {name: k for k, name in enumerate(states)}
    n, layout = len(plant.mounts), Layout.of(len(plant.mounts))
    C, D = np.zeros((layout.size, A.shape[0])), np.zeros((layout.size, B.shape[1]))
    for dof, name in enumerate(DOFS):
        moves = at[f"velocity {name}"]
        C[layout.displacement + dof, at[f"displacement {name}"]] = C[layout.velocity + dof, moves] = 1.0
        C[layout.acceleration + dof], D[layout.acceleration + dof] = A[moves], B[moves]
    size = 2 * n * len(AXES)
    D[layout.ground : layout.ground + size, n : n + size] = np.eye(size)
    for row, name in enumerate(f"{state} {mount}" for mount in plant.mounts for state in State._fields):
        C[layout.state + row, at[name]] = 1.0
    for mount, (name, actuator) in enumerate(zip(plant.mounts, plant.actuators, strict=True)):
        # Within their play the edges do not follow small motion.
        C[layout.edges + mount, at[f"spool {name}"]] = float(actuator.hysteresis == 0.0)
    if SUPPLY in at:
        C[layout.supply, at[SUPPLY]] = 1.0
    own = plant.layout.rows if plant.plates == "tied" else np.zeros((n, len(DOFS)))
    shares = own + (0.0 if plant.level_enough else turned_rows(plant, state) - plant.layout.rows)
    for order, what in enumerate(("displacement", "velocity")):
        for mount, name in enumerate(plant.mounts):
            plate = layout.plate + n * order + mount
            if plant.plates == "sliding":
                C[plate, at[f"{what} plate {name}"]] = 1.0
            C[plate, [at[f"{what} {dof}"] for dof in DOFS]] = shares[mount]
    return C, D


def turned_rows(plant: Plant, state: Array) -> Array:
    """Stroke of each mount per motion of the machine [m, rad] as it is turned at an operating point, (mount, 6)."""
    n = len(DOFS)
    displacement = np.tile(state[list(DOF_OF_JOINT)], (n, 1))
    moved = points_motion(displacement, np.eye(n), np.zeros((n, n)), plant.positions)
    return np.array([velocity @ along for (_, velocity, _), along in zip(moved, plant.directions, strict=True)])
