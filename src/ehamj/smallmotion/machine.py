"""The machine about its equilibrium, M q̈ = −K δq − C q̇ + Lᵀ(f − f₀) + G_d g + G_v ġ + W w, from the compiled model.

Left out is what is of second order in the motion: levers and inertia that turn with the machine, products of rates
(docs/physics.md, small motions).
"""

from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.cylinder import oil_force
from ehamj.memory import COMMAND, INPUTS, Cubic, activations, isolators
from ehamj.mujoco import hydraulics
from ehamj.mujoco.slides import FIRST
from ehamj.mujoco.unpacking import hermite
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.plant import Plant
from ehamj.smallmotion.probe import SMALL, Probe, slope
from ehamj.smallmotion.slides import SlideTables, along_courses, driven_by

STAGES: Final = (0.0, 0.5, 1.0)
"""Fractions of a step at which coefficients are taken."""


class InTime(NamedTuple):
    """The equation's coefficients in some steps, at start, middle and end of each: q̈ = P z + pushed.

    z (2n + mount) is δq, q̇, then f − f₀ of the mounts.
    """

    matrix: Array
    """P (step, 3, n, 2n + mount); (1, 1, n, 2n + mount) where no slide moves in these steps."""
    pushed: Array
    """By ground, load and slides (step, 3, n) [m/s², rad/s²]."""
    ground: Array
    """The ground along each mount less that at the equilibrium, and its rate, (step, 3, mount, 2) [m, m/s]."""


@dataclass(frozen=True)
class SmallMachine:
    """A machine's matrices, SI; n free coordinates: the machine's six (`ehamj.plant.axes.JOINTS`), then the plates on
    feet that give way."""

    mass: Array
    """M (n, n), slides where they start."""
    stiffness: Array
    """K (n, n): membranes, feet, gravity, and the loads that mounts bear as they turn."""
    damping: Array
    """C (n, n)."""
    levers: Array
    """L (mount, n): strokes per motion."""
    force_at_rest: Array
    """f₀ (mount,): of the oil at the equilibrium [N]."""
    stroke_at_rest: Array
    """s₀ (mount,) [m]."""
    plate_at_rest: Array
    """Of the plates along their actions, shims left out (mount,) [m]: what is above ground at rest."""
    ground_at_rest: Array
    """Displacement of the ground that the equilibrium was found with, (mount, 3) [m]."""
    ground_stiffness: Array
    """G_d (n, mount, 3)."""
    ground_damping: Array
    """G_v (n, mount, 3)."""
    along: Array
    """Unit vectors of the mounts' actions (mount, 3)."""
    load: Array
    """W (n, 6) of force and moment at the centre of gravity of the machine without its slides."""
    unbalanced: Array
    """What Newton's method left of the balance at the equilibrium (n,)."""
    rest: Array
    """The model's qpos at the equilibrium."""
    coordinates: Array
    """The model's positions per free coordinate (nq, n)."""
    plant: Plant = field(repr=False)
    slides: SlideTables | None = None
    """Where a slide moves."""

    @property
    def matrix(self) -> Array:
        """P = M⁻¹[−K, −C, Lᵀ] (n, 2n + mount), slides where they start."""
        return np.asarray(np.linalg.solve(self.mass, np.hstack([-self.stiffness, -self.damping, self.levers.T])))

    def in_time(
        self, first: int, steps: int, timestep: float, given: tuple[Array, Array], load: tuple[Array, ...] | None = None
    ) -> InTime:
        """The coefficients in some steps.

        Args:
            first: number of the first step, whose time is first·timestep.
            steps: how many.
            timestep: [s].
            given: value, slope·timestep and second derivative of the mounts' inputs at start and end of each step,
                (step, mount, input, 3) each; see `ehamj.memory.inputs`.
            load: force on the machine, value and slope·timestep at start and end of each step, (step, 6, 2) each.
        """
        size, mounts = self.mass.shape[0], len(self.along)
        inverse = np.asarray(np.linalg.inv(self.mass) if self.slides is None else np.eye(size), float)
        value, rate = self._effects(inverse)
        found = acting(*given, value, rate / timestep)
        found += np.append(inverse @ self.unbalanced, np.zeros(2 * mounts))
        found -= np.tensordot(self.ground_at_rest, value[:, :COMMAND], 2)
        force, ground = np.ascontiguousarray(found[..., :size]), np.ascontiguousarray(found[..., size:])
        ground = ground.reshape(steps, 3, mounts, 2)
        if load is not None and load[0].shape[0]:
            by = (inverse @ self.load).T
            force += acting(load[0], load[1], by, np.zeros_like(by))
        if self.slides is None:
            return InTime(self.matrix[None, None], force, ground)
        inverse, matrix, driven = self._sliding(self.slides, first, steps, timestep)
        return InTime(matrix, (inverse @ (force + driven)[..., None])[..., 0], ground)

    def _effects(self, inverse: Array) -> tuple[Array, Array]:
        """Effects of the mounts' inputs per value and per rate, (mount, input, n + 2 mount): on ``inverse`` times the
        force, then along·g and along·ġ of each mount in turn."""
        size, mounts = self.mass.shape[0], len(self.along)
        value, rate = np.zeros((2, mounts, len(INPUTS), size + 2 * mounts))
        for effect, matrix in ((value, self.ground_stiffness), (rate, self.ground_damping)):
            effect[:, :COMMAND, :size] = np.einsum("ij,jma->mai", inverse, matrix)
        here = np.arange(mounts)
        value[here, :COMMAND, size + 2 * here] = rate[here, :COMMAND, size + 2 * here + 1] = self.along
        return value, rate

    def _sliding(self, tables: SlideTables, first: int, steps: int, timestep: float) -> tuple[Array, Array, Array]:
        """M⁻¹ and P with the slides where they are, and the force of their weight and drives, (step, 3, …) each."""
        points = along_courses(self.plant, first, steps, timestep)
        differ = np.concatenate([[True], np.any(points[:, 1:] != points[:, :-1], axis=(0, 2))])
        stage = (np.cumsum(differ) - 1)[2 * np.arange(steps)[:, None] + np.arange(3)]
        mass, stiffness, damping, weight = tables.added(*points[:, differ])
        inverse = np.asarray(np.linalg.inv(self.mass + mass), float)
        levers = np.broadcast_to(self.levers.T, (len(inverse), *self.levers.T.shape))
        matrix = inverse @ np.concatenate([-self.stiffness - stiffness, -self.damping - damping, levers], axis=2)
        force = weight[stage] + driven_by(self.plant, first, steps, timestep) @ tables.reaction
        if len(matrix) == 1:  # they stand
            return inverse[None], matrix[None], force
        return inverse[stage], matrix[stage], force

    def in_model(self, times: Array, q: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
        """The model's positions, velocities and accelerations, (row, nq) and (row, nv) twice.

        Args:
            times: of the rows [s]; slides are where their courses have them.
            q: δq (row, n) [m, rad].
            v: its rate (row, n).
            a: its second derivative (row, n).
        """
        qpos, qvel, qacc = self.rest + q @ self.coordinates.T, v @ self.coordinates.T, a @ self.coordinates.T
        for k, slide in enumerate(self.plant.slides, start=FIRST):
            place, qvel[:, k], qacc[:, k] = slide.course().sample(times)
            qpos[:, k] = place - slide.begins
        return qpos, qvel, qacc


def staged(start: Array, end: Array) -> tuple[Array, Array]:
    """Value and slope·step of cubics at start, middle and end of each step, (step, 3, …) each; given are value and
    slope·step at both ends, (step, …, 2 or more) each."""
    both: Any = (part[..., order] for part in (start, end) for order in range(2))
    cubic = Cubic(*both)
    value, slopes = zip(*(hermite.py_func(cubic, s) for s in STAGES), strict=True)
    return np.stack(value, axis=1), np.stack(slopes, axis=1)


def acting(start: Array, end: Array, by_value: Array, by_rate: Array) -> Array:
    """What cubics do at start, middle and end of each step, (step, 3, effect): `staged` and weighed, by products of
    whole arrays.

    Args:
        start: value, slope·step and any more of each cubic at the start of each step, (step, …, order).
        end: the same at its end.
        by_value: effect of each (…, effect) per value.
        by_rate: per slope·step.
    """
    steps, orders, effects = start.shape[0], start.shape[-1], by_value.shape[-1]
    value, rate = by_value.reshape(-1, effects), by_rate.reshape(-1, effects)
    values, rates = staged(*np.eye(4).reshape(4, 2, 2).swapaxes(0, 1))  # of what each end has, (value or slope, stage)
    found = np.zeros((steps, 3, effects))
    for given, of_value, of_rate in zip((start, end), values.reshape(2, 2, 3), rates.reshape(2, 2, 3), strict=True):
        stages = np.flatnonzero(of_value.any(axis=0) | of_rate.any(axis=0))
        weights = np.zeros((value.shape[0], orders, stages.size, effects))
        for order, stage in np.ndindex(2, stages.size):
            at = order, stages[stage]
            weights[:, order, stage] = of_value[at] * value + of_rate[at] * rate
        found[:, stages] += (given.reshape(steps, -1) @ weights.reshape(-1, stages.size * effects)).reshape(
            steps, stages.size, effects
        )
    return found


def small_machine(model: mujoco.MjModel, data: mujoco.MjData, plant: Plant) -> SmallMachine:
    """The matrices of a machine.

    Args:
        model: compiled from the plant.
        data: at its equilibrium (`ehamj.mujoco.equilibrium.equilibrium`), which is left as it is.
        plant: tied or sliding plates, which on rigid feet are the same here.
    """
    own, mounts = isolators(model).view(np.recarray), len(plant.mounts)
    state = activations(model, data.act).isolators
    pressures = [np.maximum(state[f"pressure_{k}"], own.vapour_pressure) for k in CHAMBERS]
    with hydraulics():
        probe = Probe(model, data)
        size, grounds = probe.coordinates.shape[1], mounts * len(AXES)
        by_ground = (
            slope(lambda g: probe.force(ground=g), grounds, SMALL),
            slope(lambda g: probe.force(ground_rate=g), grounds, SMALL),
        )
        stroke, plate = probe.strokes()
        return SmallMachine(
            mass=probe.mass(),
            stiffness=probe.stiffness(),
            damping=probe.damping(),
            levers=probe.levers(),
            force_at_rest=oil_force.py_func(*pressures, own),
            stroke_at_rest=stroke,
            plate_at_rest=plate,
            ground_at_rest=probe.ground,
            ground_stiffness=by_ground[0].reshape(size, mounts, len(AXES)),
            ground_damping=by_ground[1].reshape(size, mounts, len(AXES)),
            along=np.array(plant.directions),
            load=slope(lambda load: probe.force(load=load), len(DOFS)),
            unbalanced=probe.force(),
            rest=probe.rest,
            coordinates=probe.coordinates,
            plant=plant,
            slides=SlideTables.of(probe) if any(slide.moves for slide in plant.slides) else None,
        )
