"""Modes of the machine: frequency, damping and shape, what moves in them, and a name that a person uses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ehamj.control import LinearController
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.linear.eigen import Eigen, correlation, pairing, separated
from ehamj.linear.machine import LinearModel, Point
from ehamj.linear.sampled import SampledLoop, sampled_loop
from ehamj.linear.shapes import Axis, Energies, at_cg, at_point, centre_of_rotation, energies, in_phase, weights
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS
from ehamj.plant.mounts import MOUNTS, N_MOUNTS, WARP

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


FORGOTTEN = 1e-2
"""Magnitude of a sampled eigenvalue below which it is a delay, gone after a sample, and no mode."""

MAINLY = 0.9
"""Share of a pattern in the valves' motion from which they are named by it."""

PATTERNS = {"in heave": (1, 1, 1, 1), "about x": (1, -1, 1, -1), "about y": (1, 1, -1, -1), "in warp": WARP}
"""How four valves, or four plates, move together, in the order of the mounts."""

MOTIONS = ("heave", "yaw", *(f"{what} about {axis}" for what in ("sway-rocking", "rocking") for axis in "xy"))
"""Names of the machine's own modes."""


@dataclass(frozen=True)
class Mode:
    """One oscillation.

    ``frequency`` is the natural frequency |λ|/2π [Hz], ``damping_ratio`` −Re λ/|λ|. ``shape`` is the complex motion of
    the mount plane's centre (6,) [m, rad], scaled so that its largest part is real and one. ``shares`` tell how much of
    the mode is motion, valve, pressure and controller (participation factors).

    ``points`` are the motions (3,) [m] of the centre of gravity (``cg``), the feet (by mount) and further points.
    ``centre`` is the axis that the part in step turns about (None: it translates), ``out_of_phase`` how far the rest is
    out of step [deg] (`ehamj.linear.shapes.in_phase`). ``energies`` is None where valves or the controller swing and
    the machine only follows. ``vector`` and ``left`` are the eigenvectors over ``states``, the right one scaled as the
    shape, wᴴ v = 1.
    """

    name: str
    frequency: float
    damping_ratio: float
    shape: ComplexArray
    shares: dict[str, float]
    eigenvalue: complex = 0j
    """λ [1/s]."""
    points: dict[str, ComplexArray] = field(default_factory=dict)
    centre: Axis | None = None
    out_of_phase: float = 0.0
    energies: Energies | None = None
    states: tuple[str, ...] = field(default=(), repr=False)
    vector: ComplexArray = field(default_factory=lambda: np.zeros(0, complex), repr=False)
    left: ComplexArray = field(default_factory=lambda: np.zeros(0, complex), repr=False)

    def to_dict(self) -> dict[str, Any]:
        """As plain data: frequency [Hz], and the shape as real and imaginary part per degree of freedom."""
        points = {
            name: {axis: [part.real, part.imag] for axis, part in zip(AXES, motion.tolist(), strict=True)}
            for name, motion in self.points.items()
        }
        axis = self.centre
        return {
            "name": self.name,
            "frequency_hz": self.frequency,
            "damping_ratio": self.damping_ratio,
            "damped_frequency_hz": self.damped_frequency,
            "shape": {dof: [part.real, part.imag] for dof, part in zip(DOFS, self.shape.tolist(), strict=True)},
            "points": points,
            "centre_of_rotation": axis
            and {"point_m": axis.point.tolist(), "axis": axis.direction.tolist(), "pitch_m": axis.pitch},
            "out_of_phase_deg": self.out_of_phase,
            "shares": self.shares,
            "energy": self.energies
            and {
                "kinetic_per_dof": self.energies.kinetic,
                "strain_per_actuator": self.energies.strain,
                "strain_by": self.energies.strain_by,
                "damping_ratio_per_actuator": self.energies.damping,
                "damping_ratio_by": self.energies.damping_by,
            },
        }

    @property
    def damped_frequency(self) -> float:
        """f √(1 − ζ²) [Hz], which a ring-down shows."""
        return self.frequency * float(np.sqrt(max(0.0, 1.0 - self.damping_ratio**2)))

    @property
    def machine_moves(self) -> bool:
        """Whether the machine itself swings, not only its valves or the controller."""
        return self.energies is not None


def modes(
    model: LinearModel,
    controller: LinearController | None = None,
    bypassed: bool = False,
    points: Mapping[str, Point] | None = None,
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> tuple[Mode, ...]:
    """Oscillatory modes by frequency: of the machine with held commands, or under a digital controller.

    Args:
        model: linearised machine.
        controller: if given, the sampled loop is closed (hold and delay included) and its eigenvalues are taken back
            to continuous time; frequencies end at half the sampling rate. The vectors are those at the samples.
        bypassed: the chambers of each cylinder are connected without resistance, so that only membranes carry the
            machine; there is then no oil, no valve and no controller.
        points: further points of the machine by name [m from the mount plane's centre] whose motion is given.
        sensors: instruments of the controller.
        seed: of the scenario, which draws the directions of the sensors' misalignments.

    Raises:
        ValueError: if a controller is given for bypassed chambers.
    """
    eigen, names = eigen_of(model, controller, bypassed, sensors, seed)
    found = [_mode(model, names, eigen, k, points or {}) for k in oscillations(eigen)]
    return tuple(_distinct(_as_machine(model, found)))


def eigen_of(
    model: LinearModel,
    controller: LinearController | None = None,
    bypassed: bool = False,
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> tuple[Eigen, tuple[str, ...]]:
    """Eigenvalues [1/s] and vectors over the named states, see `modes`; repeated ones are told apart by what moves.

    Of a repeated eigenvalue, those vectors are taken of which each moves one plane of the machine, or one valve.
    """
    found = state_matrix(model, controller, bypassed, sensors, seed)
    eigen, names = Eigen.of(found.A), found.states
    if isinstance(found, SampledLoop):
        kept = np.flatnonzero(np.abs(eigen.values) > FORGOTTEN)
        place = {int(k): at for at, k in enumerate(kept)}
        clusters = tuple(tuple(place[k] for k in cluster) for cluster in eigen.clusters if cluster[0] in place)
        values = found.exponents(eigen.values[kept], eigen.right[:, kept])
        eigen = Eigen(values, eigen.right[:, kept], eigen.left[:, kept], clusters)
    for cluster in eigen.clusters:
        if len(cluster) > 1:
            eigen = eigen.with_basis(cluster, _basis(model, names, eigen, cluster))
    return eigen, names


class Free(NamedTuple):
    """The machine left to itself: ẋ = A x."""

    A: Array
    states: tuple[str, ...]


def state_matrix(
    model: LinearModel,
    controller: LinearController | None = None,
    bypassed: bool = False,
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> Free | SampledLoop:
    """The matrix whose eigenvalues `eigen_of` takes, and the names of its states; with a controller from sample to
    sample."""
    if bypassed:
        if controller is not None:
            raise ValueError("bypassed chambers have no controller")
        moving = [k for k, name in enumerate(model.states) if _group(name) == "motion"]
        return Free(model.A[np.ix_(moving, moving)], tuple(model.states[k] for k in moving))
    if controller is None:
        return Free(model.A, model.states)
    return sampled_loop(model, controller, sensors, seed)


def oscillations(eigen: Eigen) -> list[int]:
    """Places of the oscillations (Im λ > 0) by frequency."""
    order = np.argsort(np.abs(eigen.values), kind="stable")
    return [int(k) for k in order if eigen.values[k].imag > 1e-6 * max(1.0, abs(eigen.values[k]))]


def track(steps: Sequence[Sequence[Mode]]) -> NDArray[np.int64]:
    """Follow modes over a sweep of similar machines, by the correlation of their vectors.

    Returns:
        Place of each mode in each step, (step, track); −1 where it does not oscillate there. Tracks begin where a mode
        appears; those of the first step come first, by frequency.
    """
    tracks: list[list[int]] = [[k] for k in range(len(steps[0]))] if steps else []
    last = list(steps[0]) if steps else []
    for at, step in enumerate(steps[1:], 1):
        taken: dict[int, int] = {}
        if step and last:
            sides = [
                tuple(np.array([getattr(m, side) for m in group]).T for side in ("vector", "left"))
                for group in (last, step)
            ]
            taken = dict(pairing(correlation(*sides)))  # type: ignore[arg-type]
        for k, one in enumerate(tracks):
            one.append(taken.get(k, -1))
            if k in taken:
                last[k] = step[taken[k]]
        for fresh in sorted(set(range(len(step))) - set(taken.values())):
            tracks.append([-1] * at + [fresh])
            last.append(step[fresh])
    return np.array(tracks, np.int64).reshape(len(tracks), len(steps)).T


def _basis(model: LinearModel, names: tuple[str, ...], eigen: Eigen, cluster: Sequence[int]) -> ComplexArray:
    """Change of basis that separates the planes of the machine, or the valves, in a repeated eigenvalue."""
    own = eigen.right[:, list(cluster)]
    shares = _shares(names, eigen, cluster[0])
    if max(shares, key=lambda group: shares[group]) == "valve":
        spools = [names.index(f"spool {mount}") for mount in MOUNTS]
        return separated(own[spools], np.arange(N_MOUNTS, dtype=float))
    moved = np.apply_along_axis(lambda shape: at_cg(model.plant.machine, shape), 0, own[list(DOF_OF_JOINT)])
    planes = np.array([{"x": 0, "ry": 0, "y": 1, "rx": 1, "z": 2, "rz": 3}[dof] for dof in DOFS], float)
    return separated(np.sqrt(weights(model.plant.machine))[:, None] * moved, planes)


def _shares(names: tuple[str, ...], eigen: Eigen, k: int) -> dict[str, float]:
    participation = np.nan_to_num(np.abs(eigen.left[:, k].conj() * eigen.right[:, k]))
    participation = participation / max(float(participation.sum()), np.finfo(float).tiny)
    shares = {"motion": 0.0, "valve": 0.0, "pressure": 0.0, "controller": 0.0}
    for name, part in zip(names, participation, strict=True):
        shares[_group(name)] += float(part)
    return shares


def _mode(model: LinearModel, names: tuple[str, ...], eigen: Eigen, k: int, points: Mapping[str, Point]) -> Mode:
    value, vector, left = complex(eigen.values[k]), eigen.right[:, k], eigen.left[:, k]
    shares, machine = _shares(names, eigen, k), model.plant.machine
    shape = vector[list(DOF_OF_JOINT)]
    largest = shape[np.argmax(np.abs(shape))]
    if abs(largest) > 0:
        vector, left = vector / largest, left * np.conj(largest)
        shape = vector[list(DOF_OF_JOINT)]
    belongs = max(shares, key=lambda group: shares[group])
    energy = None
    if belongs == "valve":
        name = _valve_name(vector[[names.index(f"spool {mount}") for mount in MOUNTS]])
    elif belongs == "controller" or not np.abs(shape).any():
        name = belongs
    else:
        energy = energies(model.plant, model.equilibrium, names, vector, abs(value))
        name = _plate_name(names, vector) if energy.kinetic["plates"] > 0.5 else motion_name(model, shape)
    moving, out_of_phase = in_phase(machine, shape)
    places = {"cg": machine.cg}
    places |= {mount: (*position, 0.0) for mount, position in zip(MOUNTS, model.plant.positions, strict=True)}
    return Mode(
        name,
        abs(value) / (2 * np.pi),
        float(-value.real / abs(value)),
        shape,
        shares,
        value,
        {name: at_point(shape, point) for name, point in (places | dict(points)).items()},
        centre_of_rotation(moving),
        out_of_phase,
        energy,
        names,
        vector,
        left,
    )


def _group(state: str) -> str:
    first = state.split(" ")[0]
    if first in ("displacement", "velocity"):
        return "motion"
    if first.startswith("spool"):
        return "valve"
    return "controller" if first == "controller" else "pressure"


def _pattern(kind: str, motion: ComplexArray) -> str:
    """What four valves or plates do together: one alone, or one of `PATTERNS`; else only what they are."""
    size = float(np.sum(np.abs(motion) ** 2))
    if size == 0.0:
        return f"{kind}s"
    alone = np.abs(motion) ** 2 / size
    if alone.max() >= MAINLY:
        return f"{kind} {MOUNTS[int(np.argmax(alone))]}"
    shares = {name: abs(np.dot(signs, motion)) ** 2 / (N_MOUNTS * size) for name, signs in PATTERNS.items()}
    best = max(shares, key=lambda name: shares[name])
    return f"{kind}s {best}" if shares[best] >= MAINLY else f"{kind}s"


def _valve_name(spools: ComplexArray) -> str:
    return _pattern("valve", spools)


def _plate_name(names: tuple[str, ...], vector: ComplexArray) -> str:
    plates = [names.index(f"displacement plate {mount}") for mount in MOUNTS if f"displacement plate {mount}" in names]
    return _pattern("plate", vector[plates]) if len(plates) == N_MOUNTS else "plates"


def _as_machine(model: LinearModel, found: list[Mode]) -> list[Mode]:
    """Modes of the machine named together, so that one is heave and one is yaw where there are six of them.

    Names go by where the kinetic energy is, so that the sum of the shares is greatest.
    """
    moving = [k for k, mode in enumerate(found) if mode.name in MOTIONS]
    shares = [energy_shares(model, found[k].shape) for k in moving]
    slots = (("z",), ("rz",), ("x", "ry"), ("x", "ry"), ("y", "rx"), ("y", "rx"))
    worth = np.array([[-sum(share[dof] for dof in slot) for slot in slots] for share in shares]).reshape(-1, len(slots))
    named = list(found)
    for row, slot in zip(*linear_sum_assignment(worth), strict=True):
        mode, share = found[moving[row]], shares[row]
        name = ("heave", "yaw")[slot] if slot < 2 else _plane_name("y" if slot < 4 else "x", share)
        named[moving[row]] = replace(mode, name=name)
    return named


def _distinct(found: list[Mode]) -> list[Mode]:
    """Modes with names of their own: of two alike the slower is the lower; of more, they are numbered by frequency."""
    named = []
    for mode in found:
        alike = [other for other in found if other.name == mode.name]
        place = next(k for k, other in enumerate(alike) if other is mode)
        if len(alike) == 2:
            mode = replace(mode, name=f"{('lower', 'upper')[place]} {mode.name}")
        elif len(alike) > 2:
            mode = replace(mode, name=f"{mode.name} {place + 1}")
        named.append(mode)
    return named


def energy_shares(model: LinearModel, shape: ComplexArray) -> dict[str, float]:
    """Share of the machine's kinetic energy per degree of freedom, translations at the centre of gravity."""
    machine = model.plant.machine
    energy = np.abs(at_cg(machine, shape)) ** 2 * weights(machine)
    return dict(zip(DOFS, (energy / energy.sum()).tolist(), strict=True))


def motion_name(model: LinearModel, shape: ComplexArray) -> str:
    """Heave, yaw, sway-rocking about y, rocking about x, …: by where the kinetic energy is."""
    share = energy_shares(model, shape)
    if share["z"] > 0.5:
        return "heave"
    if share["rz"] > 0.5:
        return "yaw"
    return _plane_name("y" if share["x"] + share["ry"] >= share["y"] + share["rx"] else "x", share)


def _plane_name(about: str, share: dict[str, float]) -> str:
    sway, turn = (share["x"], share["ry"]) if about == "y" else (share["y"], share["rx"])
    return f"{'sway-rocking' if sway > turn else 'rocking'} about {about}"
