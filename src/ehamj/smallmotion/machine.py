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
from ehamj.memory import activations, isolators
from ehamj.mujoco import hydraulics
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.plant import Plant
from ehamj.smallmotion.cubics import acting, weights
from ehamj.smallmotion.floor import Effects
from ehamj.smallmotion.probe import SMALL, Probe, slope
from ehamj.smallmotion.slides import SlideTables, along_courses, driven_by


class InTime(NamedTuple):
    """The equation's coefficients in some steps, at start, middle and end of each, beside those of the ground:
    q̈ = P z + pushed, with the forces of the ground `Effects` times ``inverse`` where a slide moves.

    z (2n + mount) is δq, q̇, then f − f₀ of the mounts.
    """

    matrix: Array
    """P (step, 3, n, 2n + mount); (1, 1, n, 2n + mount) where no slide moves in these steps."""
    inverse: Array | None
    """M⁻¹ (step, 3, n, n) or (1, 1, n, n), of machines with slides that move."""
    pushed: Array | None
    """By load and slides (step, 3, n) [m/s², rad/s²]; None where there is nothing of these."""


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

    def in_time(self, first: int, steps: int, timestep: float, load: tuple[Array, ...] | None = None) -> InTime:
        """The coefficients in some steps.

        Args:
            first: number of the first step, whose time is first·timestep.
            steps: how many.
            timestep: [s].
            load: force on the machine, value and slope·timestep at start and end of each step, (step, 6, 2) each.
        """
        pushed = None
        if load is not None and load[0].shape[0]:
            pushed = acting(load[0], load[1], self._by_load)
        if self.slides is None:
            return InTime(self.matrix[None, None], None, pushed)
        inverse, matrix, driven = self._sliding(self.slides, first, steps, timestep)
        force = driven if pushed is None else pushed + driven
        return InTime(matrix, inverse, (inverse @ force[..., None])[..., 0])

    @cached_property
    def _share(self) -> Array:
        """What makes effects of forces: M⁻¹, or one where a slide moves and M⁻¹ with it."""
        size = self.mass.shape[0]
        return np.asarray(np.linalg.inv(self.mass) if self.slides is None else np.eye(size), float)

    @cached_property
    def _by_load(self) -> Array:
        """`ehamj.smallmotion.cubics.weights` of a load."""
        load = (self._share @ self.load).T
        return weights(load, np.zeros_like(load), 2)

    @cached_property
    def effects(self) -> Effects:
        """What the ground does."""
        share, size = self._share, self.mass.shape[0]
        by_value, by_rate = (share @ part.reshape(size, -1) for part in (self.ground_stiffness, self.ground_damping))
        always = share @ self.unbalanced - by_value @ self.ground_at_rest.ravel()
        stroke = self.stroke_at_rest + np.einsum("ma,ma->m", self.along, self.ground_at_rest)
        return Effects(by_value, by_rate, always, self.along, stroke)

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
