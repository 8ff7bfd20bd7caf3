"""What a mode shape means: where it turns, whether it moves in step, where its energy is and what takes it.

Shapes are complex: real where all parts are in step. Energies are means over a cycle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.linear.elements import Elements, coordinates
from ehamj.linear.oil import Oil
from ehamj.linear.values import Values
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import lever
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant

FAR = 1e4
"""Distance of an axis [m] beyond which a motion turns about nothing."""


def at_point(shape: ComplexArray, point: Sequence[float]) -> ComplexArray:
    """Motion of a point of the machine, (3,) [m], from that of the mount plane's centre (6,) [m, rad]."""
    return np.asarray(lever(point) @ shape)


def weights(machine: Machine) -> Array:
    """Mass matrix [kg, kg m²] of a motion taken at the centre of gravity, (6, 6)."""
    found = np.diag([machine.mass] * 6)
    found[3:, 3:] = machine.tensor
    return found


def kinetic_of(machine: Machine, motion: ComplexArray) -> Array:
    """Twice the kinetic energy of a motion taken at the centre of gravity (6,), by degree of freedom; what two of them
    share by a product of inertia is halved between them."""
    return np.asarray(np.real(motion.conj() * (weights(machine) @ motion)))


def at_cg(machine: Machine, shape: ComplexArray) -> ComplexArray:
    """Translation of the centre of gravity and rotation, (6,) [m, rad]."""
    return np.concatenate([at_point(shape, machine.cg), shape[3:]])


def in_phase(machine: Machine, shape: ComplexArray) -> tuple[Array, float]:
    """The part of a shape that moves in step, and how far the rest is out of step.

    The phase is that at which the kinetic energy of the part in step is greatest.

    Returns:
        The part in step (6,), its largest entry positive; and the angle whose tangent is the ratio of the root energies
        out of step and in step [deg]: 0 where the shape is real, 45 where it circulates.
    """
    motion, w = at_cg(machine, shape), weights(machine)
    turn = np.exp(-0.5j * np.angle(motion @ w @ motion))
    part = (shape * turn).real
    if part[np.argmax(np.abs(part))] < 0.0:
        part = -part
    sizes = [float(size @ w @ size) for size in ((motion * turn).imag, (motion * turn).real)]
    return part, float(np.degrees(np.arctan2(*np.sqrt(sizes))))


@dataclass(frozen=True)
class Axis:
    """Where a small motion turns about: ``point`` [m], the nearest to the mount plane's centre, ``direction`` (unit),
    and ``pitch`` [m/rad], how far it moves along the axis per angle (0: a plain turn)."""

    point: Array
    direction: Array
    pitch: float

    def __str__(self) -> str:
        """In words: the axis that it is parallel to, and where it passes [m]."""
        main = int(np.argmax(np.abs(self.direction)))
        place = ", ".join(f"{AXES[k]} {round(self.point[k], 2) + 0.0:.2f}" for k in range(3) if k != main)
        kind = f"{AXES[main]} axis" if abs(self.direction[main]) > 0.99 else "a slanted axis"
        return f"{kind} at {place} m".replace("-", "−")


def centre_of_rotation(motion: Array) -> Axis | None:
    """Axis about which a real motion of the mount plane's centre (6,) [m, rad] turns; None: it translates."""
    u, theta = motion[:3], motion[3:]
    square = float(theta @ theta)
    point = np.cross(theta, u)
    if square == 0.0 or float(np.linalg.norm(point)) > FAR * square:
        return None
    direction = theta / np.sqrt(square)
    if direction[np.argmax(np.abs(direction))] < 0.0:
        direction = -direction
    return Axis(point / square, direction, float(u @ theta) / square)


@dataclass(frozen=True)
class Energies:
    """Where the energy of an oscillation is, as shares [-], and what damps it.

    ``kinetic`` per degree of freedom of the machine at its centre of gravity, and of the ``plates``. ``strain`` per
    mount: membranes, feet and oil. ``damping`` per mount: what its membranes and its leakage add to the damping ratio;
    ``damping_by`` the same by cause. With valves held the sum is the mode's damping ratio.
    """

    kinetic: dict[str, float]
    strain: dict[str, float]
    strain_by: dict[str, float]
    damping: dict[str, float]
    damping_by: dict[str, float]


def energies(plant: Plant, equilibrium: Array, states: Sequence[str], vector: ComplexArray, omega: float) -> Energies:
    """Energies of a complex state.

    Args:
        plant: the machine.
        equilibrium: the state of rest that the vector deviates from (`LinearModel.equilibrium`).
        states: names of the entries of ``vector``, of which more may follow; without pressures the oil counts nothing.
        vector: deviations in SI.
        omega: |λ| [rad/s], over which the lost power counts as damping.
    """
    values = Values.of(plant)
    index = {name: k for k, name in enumerate(states)}
    joints = coordinates(plant)
    at = [index[f"displacement {joint}"] for joint in joints]
    parts = Elements.of(values, equilibrium[at])
    q, qd = vector[at], vector[[index[f"velocity {joint}"] for joint in joints]]
    spring: dict[str, Array] = {}
    lost: dict[str, Array] = {}
    for found, kind, motion in ((spring, "stiffness", q), (lost, "damping", qd)):
        for name, moved, own in parts.supports(kind):
            found[name] = found.get(name, 0.0) + own * np.abs(moved @ motion) ** 2
    if f"pressure_1 {plant.mounts[0]}" in index:
        columns = [[index[f"pressure_{chamber} {mount}"] for mount in plant.mounts] for chamber in (1, 2)]
        one, two = (vector[column] for column in columns)
        oil = Oil.of(values, parts.stroke, (equilibrium[columns[0]], equilibrium[columns[1]]))
        # Where walls give way a piston sweeps w times its area: what the oil takes up counts over w.
        spring["oil"] = (oil.compliances[0] * np.abs(one) ** 2 + oil.compliances[1] * np.abs(two) ** 2) / oil.stretch
        leaks = 2.0 * oil.edge * (np.abs(one) ** 2 + np.abs(two) ** 2) + oil.cross * np.abs(one - two) ** 2
        lost["leakage"] = leaks / oil.stretch
    turning = np.concatenate([parts.cg[:3], parts.spin]) @ qd
    own_kinetic = kinetic_of(plant.machine, turning)
    plates = float(np.sum(values.mounts["plate_mass"] * np.abs(parts.plate @ qd) ** 2))
    moving = float(own_kinetic.sum()) + plates
    kinetic = dict(zip((*DOFS, "plates"), (*own_kinetic / moving, plates / moving), strict=True))
    strained = sum(float(part.sum()) for part in spring.values())
    total = moving + strained - float(np.real(q.conj() @ parts.toppling @ q))
    shared = []
    for parts_of, whole in ((spring, strained), (lost, omega * total)):
        each = np.sum(list(parts_of.values()), axis=0) / whole
        shared.append(dict(zip(plant.mounts, each.tolist(), strict=True)))
        shared.append({name: float(part.sum()) / whole for name, part in parts_of.items()})
    return Energies({name: float(share) for name, share in kinetic.items()}, *shared)
