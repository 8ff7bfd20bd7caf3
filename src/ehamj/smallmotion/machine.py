"""The machine about its equilibrium, M q̈ = −K δq − C q̇ + Lᵀ(f − f₀) + G_d g + G_v ġ + W w, from the compiled model.

Left out is what is of second order in the motion: levers and inertia that turn with the machine, products of rates
(docs/physics.md, small motions).
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.cylinder import oil_force
from ehamj.memory import COMMAND, INPUTS, ORDERS, activations, isolators
from ehamj.mujoco import hydraulics
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.plant import Plant
from ehamj.smallmotion.cubics import acting, weights
from ehamj.smallmotion.probe import SMALL, Probe, slope
from ehamj.smallmotion.slides import SlideTables, along_courses, driven_by


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


class Effects(NamedTuple):
    """`ehamj.smallmotion.cubics.weights` of what acts on a machine."""

    by_value: Array
    """Of the mounts' inputs."""
    by_rate: Array
    """Of their rates [1/s]."""
    by_load: Array
    always: Array
    """What is there without (effect,)."""


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

    @cached_property
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
        size, mounts, effects = self.mass.shape[0], len(self.along), self._effects
        found = acting(*given, effects.by_value + effects.by_rate / timestep)
        found += effects.always
        force, ground = np.ascontiguousarray(found[..., :size]), np.ascontiguousarray(found[..., size:])
        ground = ground.reshape(steps, 3, mounts, 2)
        if load is not None and load[0].shape[0]:
            force += acting(load[0], load[1], effects.by_load)
        if self.slides is None:
            return InTime(self.matrix[None, None], force, ground)
        inverse, matrix, driven = self._sliding(self.slides, first, steps, timestep)
        return InTime(matrix, (inverse @ (force + driven)[..., None])[..., 0], ground)

    @cached_property
    def _effects(self) -> "Effects":
        """On accelerations, or on forces where a slide moves; then along·g and along·ġ of each mount in turn."""
        size, mounts = self.mass.shape[0], len(self.along)
        inverse = np.asarray(np.linalg.inv(self.mass) if self.slides is None else np.eye(size), float)
        value, rate = np.zeros((2, mounts, len(INPUTS), size + 2 * mounts))
        for effect, matrix in ((value, self.ground_stiffness), (rate, self.ground_damping)):
            effect[:, :COMMAND, :size] = np.einsum("ij,jma->mai", inverse, matrix)
        here = np.arange(mounts)
        value[here, :COMMAND, size + 2 * here] = rate[here, :COMMAND, size + 2 * here + 1] = self.along
        always = -np.tensordot(self.ground_at_rest, value[:, :COMMAND], 2)
        always[:size] += inverse @ self.unbalanced
        nothing, load = np.zeros_like(value), (inverse @ self.load).T
        return Effects(
            weights(value, nothing, ORDERS),
            weights(nothing, rate, ORDERS),
            weights(load, np.zeros_like(load), 2),
            always,
        )

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
