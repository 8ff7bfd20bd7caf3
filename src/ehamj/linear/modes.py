"""Modes of the machine: frequency, damping and shape, what moves in them, and a name that a person uses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.linear.eigen import Eigen, separated
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, Point
from ehamj.linear.names import group_of, motion_name, named_together, pattern_name
from ehamj.linear.sampled import SampledLoop, sampled_loop
from ehamj.linear.shapes import Axis, Energies, at_cg, at_point, centre_of_rotation, energies, in_phase, weights
from ehamj.notebook import html_table
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS

FORGOTTEN = 1e-2
"""Magnitude of a sampled eigenvalue below which it is a delay, gone after a sample, and no mode."""

LEAST_SHARE = 0.01
"""Share of a mode from which on a table names what takes part."""


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


class Modes(tuple[Mode, ...]):
    """Modes by frequency, which a notebook shows as a table."""

    def _repr_html_(self) -> str:
        """Name, frequency, damping, and what moves."""
        rows = (
            (
                mode.name,
                f"{mode.frequency:.4g}",
                f"{mode.damping_ratio:.3g}",
                ", ".join(f"{name} {share:.0%}" for name, share in mode.shares.items() if share >= LEAST_SHARE),
            )
            for mode in self
        )
        return html_table(rows, ("mode", "frequency [Hz]", "damping ratio [-]", "what takes part"))


def modes(
    model: LinearModel,
    loop: Loop | None = None,
    bypassed: bool = False,
    points: Mapping[str, Point] | None = None,
) -> Modes:
    """Oscillatory modes by frequency: of the machine with held commands, or under a digital controller.

    Args:
        model: linearised machine.
        loop: if given, the sampled loop is closed (hold and delay included) and its eigenvalues are taken back to
            continuous time; frequencies end at half the sampling rate. The vectors are those at the samples.
        bypassed: the chambers of each cylinder are connected without resistance, so that only membranes carry the
            machine; there is then no oil, no valve and no loop.
        points: further points of the machine by name [m from the mount plane's centre] whose motion is given.

    Raises:
        ValueError: if a loop is given for bypassed chambers.
    """
    eigen, states = eigen_of(model, loop, bypassed)
    found = [_mode(model, states, eigen, k, points or {}) for k in oscillations(eigen)]
    names = named_together(model.plant.machine, [mode.name for mode in found], [mode.shape for mode in found])
    return Modes(replace(mode, name=name) for mode, name in zip(found, names, strict=True))


def eigen_of(model: LinearModel, loop: Loop | None = None, bypassed: bool = False) -> tuple[Eigen, tuple[str, ...]]:
    """Eigenvalues [1/s] and vectors over the named states, see `modes`; repeated ones are told apart by what moves.

    Of a repeated eigenvalue, those vectors are taken of which each moves one plane of the machine, or one valve.
    """
    found = state_matrix(model, loop, bypassed)
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


def state_matrix(model: LinearModel, loop: Loop | None = None, bypassed: bool = False) -> Free | SampledLoop:
    """The matrix whose eigenvalues `eigen_of` takes, and the names of its states; of a loop from sample to sample."""
    if bypassed:
        if loop is not None:
            raise ValueError("bypassed chambers have no controller")
        moving = [k for k, name in enumerate(model.states) if group_of(name) == "motion"]
        return Free(model.A[np.ix_(moving, moving)], tuple(model.states[k] for k in moving))
    return Free(model.A, model.states) if loop is None else sampled_loop(model, loop)


def oscillations(eigen: Eigen) -> list[int]:
    """Places of the oscillations (Im λ > 0) by frequency."""
    order = np.argsort(np.abs(eigen.values), kind="stable")
    return [int(k) for k in order if eigen.values[k].imag > 1e-6 * max(1.0, abs(eigen.values[k]))]


def _basis(model: LinearModel, names: tuple[str, ...], eigen: Eigen, cluster: Sequence[int]) -> ComplexArray:
    """Change of basis that separates the planes of the machine, or the valves, in a repeated eigenvalue."""
    own = eigen.right[:, list(cluster)]
    shares = _shares(names, eigen, cluster[0])
    if max(shares, key=lambda group: shares[group]) == "valve":
        spools = _places(names, "spool", model)
        return separated(own[spools], np.arange(len(spools), dtype=float))
    moved = np.apply_along_axis(lambda shape: at_cg(model.plant.machine, shape), 0, own[list(DOF_OF_JOINT)])
    planes = np.array([{"x": 0, "ry": 0, "y": 1, "rx": 1, "z": 2, "rz": 3}[dof] for dof in DOFS], float)
    root = np.linalg.cholesky(weights(model.plant.machine)).T
    return separated(np.asarray(root @ moved, complex), planes)


def _shares(names: tuple[str, ...], eigen: Eigen, k: int) -> dict[str, float]:
    participation = np.nan_to_num(np.abs(eigen.left[:, k].conj() * eigen.right[:, k]))
    participation = participation / max(float(participation.sum()), np.finfo(float).tiny)
    shares = {"motion": 0.0, "valve": 0.0, "pressure": 0.0, "controller": 0.0}
    for name, part in zip(names, participation, strict=True):
        shares[group_of(name)] += float(part)
    return shares


def named(model: LinearModel, names: tuple[str, ...], eigen: Eigen, k: int) -> str:
    """What moves in an eigenvector, also in one that does not swing: as `modes` names it, and of pressures and a law
    in what pattern, and which motion they take along."""
    mode, vector = _mode(model, names, eigen, k, {}), eigen.right[:, k]
    if mode.name == "pressure":
        one, two = (vector[_places(names, f"pressure_{chamber}", model)] for chamber in (1, 2))
        return pattern_name("pressure", one - two, model.plant)
    if mode.name == "controller" and np.abs(mode.shape).any():
        return f"the controller's states with {motion_name(model.plant.machine, mode.shape)}"
    return "the controller's states" if mode.name == "controller" else mode.name


def _places(names: Sequence[str], what: str, model: LinearModel) -> list[int]:
    """Where a state of each mount lies."""
    return [names.index(f"{what} {mount}") for mount in model.plant.mounts]


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
        name = pattern_name("valve", vector[_places(names, "spool", model)], model.plant)
    elif belongs == "controller" or not np.abs(shape).any():
        name = belongs
    else:
        energy = energies(model.plant, model.equilibrium, names, vector, abs(value))
        name = motion_name(machine, shape)
        if energy.kinetic["plates"] > 0.5:
            sliding = model.plant.plates == "sliding"
            plates = _places(names, "displacement plate", model) if sliding else []
            name = pattern_name("plate", vector[plates], model.plant)
    moving, out_of_phase = in_phase(machine, shape)
    feet = model.plant.positions
    places = {"cg": machine.cg, **dict(zip(model.plant.mounts, feet, strict=True)), **points}
    return Mode(
        name,
        abs(value) / (2 * np.pi),
        float(-value.real / abs(value)),
        shape,
        shares,
        value,
        {name: at_point(shape, point) for name, point in places.items()},
        centre_of_rotation(moving),
        out_of_phase,
        energy,
        names,
        vector,
        left,
    )
