"""The compiled model's forces near its equilibrium, and how they change: by moving it and asking the engine."""

from collections.abc import Callable
from typing import Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.memory import MACHINE_BODY, exchange, isolators, mounts_of, slides_of
from ehamj.mujoco.equilibrium import Inputs
from ehamj.mujoco.slides import FIRST
from ehamj.plant.axes import AXES

SMALL: Final = 1e-4
"""Motion for differences over positions [m, rad]: with its fourth power left out, rounding and truncation are both
below 1e-14 of a membrane's stiffness, and below 1e-9 of gravity's."""

GROUND: Final = ("ground", "ground_rate")
"""What moves the ground."""


def slope(of: Callable[[Array], Array], size: int, step: float = 1.0, curved: bool = False) -> Array:
    """∂of/∂x at 0, (value, size), by central differences: exact for quadratics; for what is ``curved``, their error is
    of the fifth derivative."""
    columns = []
    for shift in step * np.eye(size):
        change = 0.5 * (of(shift) - of(-shift))
        if curved:
            change = (4.0 * change - 0.25 * (of(2.0 * shift) - of(-2.0 * shift))) / 3.0
        columns.append(change / step)
    return np.array(columns).reshape(size, -1).T


class Probe:
    """A copy of a model's state at its equilibrium, which is moved; use it with the hydraulics installed.

    Motions q are of the coordinates that are free: ``coordinates`` (model's velocities, n) makes the model's motion of
    them, without slides, plates on rigid feet with the machine.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        mounts = exchange(data, mounts_of(model))
        self.model, self.data = model, mujoco.MjData(model)
        self.data.time, self.data.act[:] = data.time, data.act
        self.rest = data.qpos.copy()
        self.ground = np.column_stack([mounts[f"ground_{axis}"]["value"] for axis in AXES])
        self.command = mounts["open_loop"]["value"].copy()
        self.slides = slides_of(model)
        Inputs(self.ground, np.zeros(self.ground.shape), self.command).write(self.data)
        held = exchange(self.data, mounts_of(model))
        self._given = [(held[f"ground_{axis}"]["value"], held[f"ground_{axis}"]["slope"]) for axis in AXES]
        """Views, which cost more to make than a step of the engine."""
        self._ground_moved = True
        self.coordinates = free_coordinates(model)

    def moved(self, **by: Array) -> mujoco.MjData:
        """The engine's state with what is named moved by so much, all else at the equilibrium.

        q, v (n): motions [m, rad] and their rates; ground, ground_rate (mount, 3) [m, m/s]; load (6,) at the machine's
        centre of gravity [N, N m]; place, speed (slide): coordinates [m] and speeds [m/s] of the slides.
        """
        model, data, at = self.model, self.data, slice(FIRST, FIRST + self.slides)
        data.qpos[:] = self.rest + self.coordinates @ by["q"] if "q" in by else self.rest
        data.qvel[:] = self.coordinates @ by["v"] if "v" in by else 0.0
        if "place" in by:
            data.qpos[at] += by["place"]
        if "speed" in by:
            data.qvel[at] += by["speed"]
        moves = not by.keys().isdisjoint(GROUND)
        if moves or self._ground_moved:  # all else leaves it alone: a hundred motions make a machine
            self._move_ground(*(by.get(name) for name in GROUND))
        self._ground_moved = moves
        data.xfrc_applied[MACHINE_BODY] = by.get("load", 0.0)
        mujoco.mj_forward(model, data)
        return data

    def _move_ground(self, by: Array | None, rate: Array | None) -> None:
        """Let the ground stand where the equilibrium was found with it, or so far from there, at a rate."""
        ground = self.ground if by is None else self.ground + by.reshape(self.ground.shape)
        rates = None if rate is None else rate.reshape(self.ground.shape)
        for k, (value, gradient) in enumerate(self._given):
            value[:], gradient[:] = ground[:, k], 0.0 if rates is None else rates[:, k]

    def force(self, **by: Array) -> Array:
        """What accelerates the free coordinates (n,) [N, N m], the oil's pressures held: as `moved`.

        ``acceleration`` (slide) of the slides [m/s²] counts by their reaction.
        """
        data = self.moved(**by)
        if "acceleration" not in by:
            return np.asarray(self.coordinates.T @ data.qfrc_smooth)
        pushed, carried = np.zeros(self.model.nv), np.zeros(self.model.nv)
        pushed[FIRST : FIRST + self.slides] = by["acceleration"]
        mujoco.mj_mulM(self.model, data, carried, pushed)
        return np.asarray(self.coordinates.T @ (data.qfrc_smooth - carried))

    def stiffness(self, **by: Array) -> Array:
        """−∂force/∂q (n, n), gravity and held oil included: symmetric where no slide is driven."""
        return -slope(lambda q: self.force(q=q, **by), self.coordinates.shape[1], SMALL, curved=True)

    def damping(self, **by: Array) -> Array:
        """−∂force/∂v (n, n)."""
        return -slope(lambda v: self.force(v=v, **by), self.coordinates.shape[1])

    def mass(self, **by: Array) -> Array:
        """Mass matrix of the free coordinates (n, n)."""
        full = np.empty((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.moved(**by), full)
        return np.asarray(self.coordinates.T @ full @ self.coordinates)

    def strokes(self) -> tuple[Array, Array]:
        """At the equilibrium, strokes, and where plates stand along their actions with shims left out, (mount,) [m]."""
        length = self.moved().actuator_length[: self.ground.shape[0]]
        mounts = exchange(self.data, length.size)
        return length - mounts["ground"], length + mounts["turn"] - isolators(self.model)["height"]

    def levers(self) -> Array:
        """Rates of the strokes per rate of each free coordinate (mount, n): the engine's are linear in them."""

        def rates(v: Array) -> Array:
            data = self.moved(v=v)
            mounts = exchange(data, self.ground.shape[0])
            return np.asarray(data.actuator_velocity[: mounts.size] - mounts["ground_rate"])

        return slope(rates, self.coordinates.shape[1])


def free_coordinates(model: mujoco.MjModel) -> Array:
    """The model's velocities per free coordinate, (velocity, n): slides stand, tied feet move their plates."""
    matrix = np.eye(model.nv)
    fixed = list(range(FIRST, FIRST + slides_of(model)))
    for tie in np.flatnonzero(model.eq_active0):
        first, size = (int(table[model.eq_obj1id[tie]]) for table in (model.tendon_adr, model.tendon_num))
        wraps = range(first, first + size)
        joints = [int(model.jnt_dofadr[model.wrap_objid[k]]) for k in wraps]
        shares = np.array([model.wrap_prm[k] for k in wraps])
        # Its plate's joint is the first, as `ehamj.mujoco.plates` puts it there.
        matrix[joints[0]] = 0.0
        matrix[joints[0], joints[1:]] = -shares[1:] / shares[0]
        fixed.append(joints[0])
    return np.delete(matrix, fixed, axis=1)
