"""Modes of the machine: frequency, damping, shape and a name that a person uses."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, expm

from ehamj.analysis.linear import LinearModel
from ehamj.controllers import Controller
from ehamj.layout import DOF_OF_JOINT, DOFS, N_MOUNTS

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


FORGOTTEN = 1e-2
"""Magnitude of a sampled eigenvalue below which it is a delay, gone after a sample, and no mode."""


@dataclass(frozen=True)
class Mode:
    """One oscillation.

    ``frequency`` is the natural frequency |λ|/2π [Hz], ``damping_ratio`` −Re λ/|λ|. ``shape`` is the complex motion of
    the mount plane's centre (6,) [m, rad], scaled so that its largest part is real and one. ``shares`` tell how much of
    the mode is motion, valve, pressure and controller (participation factors).
    """

    name: str
    frequency: float
    damping_ratio: float
    shape: ComplexArray
    shares: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """As plain data: frequency [Hz], and the shape as real and imaginary part per degree of freedom."""
        return {
            "name": self.name,
            "frequency_hz": self.frequency,
            "damping_ratio": self.damping_ratio,
            "shape": {dof: [part.real, part.imag] for dof, part in zip(DOFS, self.shape.tolist(), strict=True)},
            "shares": self.shares,
        }

    @property
    def damped_frequency(self) -> float:
        """f √(1 − ζ²) [Hz], which a ring-down shows."""
        return self.frequency * float(np.sqrt(max(0.0, 1.0 - self.damping_ratio**2)))


def modes(model: LinearModel, controller: Controller | None = None) -> tuple[Mode, ...]:
    """Oscillatory modes by frequency: of the machine with held commands, or under a digital controller.

    Args:
        model: linearised machine.
        controller: if given, the sampled loop is closed (hold and delay included) and its eigenvalues are taken back
            to continuous time; frequencies end at half the sampling rate.
    """
    if controller is None:
        values, left, right = eig(model.A, left=True)
        names = model.states
    else:
        loop, names = sampled_loop(model, controller)
        discrete, left, right = eig(loop, left=True)
        kept = np.abs(discrete) > FORGOTTEN
        discrete, left, right = discrete[kept], left[:, kept], right[:, kept]
        values = np.log(discrete) / controller.period
    found = []
    for k in np.argsort(np.abs(values)):
        if values[k].imag > 1e-6 * max(1.0, abs(values[k])):
            found.append(_mode(model, names, values[k], left[:, k], right[:, k]))
    return tuple(found)


def _mode(model: LinearModel, names: tuple[str, ...], value: complex, left: ComplexArray, right: ComplexArray) -> Mode:
    participation = np.abs(left.conj() * right)
    participation = participation / participation.sum()
    shares = {"motion": 0.0, "valve": 0.0, "pressure": 0.0, "controller": 0.0}
    for name, part in zip(names, participation, strict=True):
        shares[_group(name)] += float(part)
    shape = right[list(DOF_OF_JOINT)]
    largest = shape[np.argmax(np.abs(shape))]
    shape = shape / largest if abs(largest) > 0 else shape
    belongs = max(shares, key=lambda group: shares[group])
    name = belongs if belongs in ("valve", "controller") else motion_name(model, shape)
    return Mode(name, abs(value) / (2 * np.pi), float(-value.real / abs(value)), shape, shares)


def _group(state: str) -> str:
    first = state.split(" ")[0]
    if first in ("displacement", "velocity"):
        return "motion"
    if first.startswith("spool"):
        return "valve"
    return "controller" if first == "controller" else "pressure"


def energy_shares(model: LinearModel, shape: ComplexArray) -> dict[str, float]:
    """Share of the machine's kinetic energy per degree of freedom, translations at the centre of gravity."""
    machine = model.plant.machine
    x, y, z = machine.cg
    lever = np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], float)
    motion = np.concatenate([lever @ shape, shape[3:]])
    energy = np.abs(motion) ** 2 * np.array([machine.mass] * 3 + list(machine.inertia))
    return dict(zip(DOFS, (energy / energy.sum()).tolist(), strict=True))


def motion_name(model: LinearModel, shape: ComplexArray) -> str:
    """Heave, yaw, sway-rocking about y, rocking about x, …: by where the kinetic energy is."""
    share = energy_shares(model, shape)
    if share["z"] > 0.5:
        return "heave"
    if share["rz"] > 0.5:
        return "yaw"
    about = "y" if share["x"] + share["ry"] >= share["y"] + share["rx"] else "x"
    sway, turn = (share["x"], share["ry"]) if about == "y" else (share["y"], share["rx"])
    return f"{'sway-rocking' if sway > turn else 'rocking'} about {about}"


def sampled_loop(model: LinearModel, controller: Controller) -> tuple[Array, tuple[str, ...]]:
    """State matrix of machine and controller from sample to sample, and the names of its states.

    The commands of a sample act ``latency`` later and are held for a period; whole periods of delay are states, a
    fraction splits the period.
    """
    n, c = model.A.shape[0], controller.states
    period, latency = controller.period, controller.latency
    whole, fraction = divmod(latency + 1e-12, period)
    whole, fraction = int(whole), max(0.0, fraction - 1e-12)
    valves = model.B[:, :N_MOUNTS]

    def held(time: float) -> tuple[Array, Array]:
        block = expm(np.block([[model.A, valves], [np.zeros((N_MOUNTS, n + N_MOUNTS))]]) * time)
        return block[:n, :n], block[:n, n:]

    full, _ = held(period)
    late, new = held(period - fraction)
    _, old_early = held(fraction)
    old = late @ old_early  # the previous command acts in the first part of the period
    C, D = model.rows(controller.inputs)
    if np.abs(D[:, :N_MOUNTS]).max(initial=0.0) > 0:
        raise ValueError("a measured channel answers a command at once")
    # Commands of the past, newest first: u[k−1] … u[k−whole−1]; u[k] = Cc x_c + Dc C x.
    waiting = whole + 1
    now = np.hstack([controller.D @ C, controller.C, np.zeros((N_MOUNTS, N_MOUNTS * waiting))])
    size = n + c + N_MOUNTS * waiting

    def command(age: int) -> Array:
        """u[k − age] in terms of the loop's state."""
        if age == 0:
            return now
        pick = np.zeros((N_MOUNTS, size))
        at = n + c + N_MOUNTS * (age - 1)
        pick[:, at : at + N_MOUNTS] = np.eye(N_MOUNTS)
        return pick

    loop = np.zeros((size, size))
    loop[:n, :n] = full
    loop[:n] += new @ command(whole) + old @ command(whole + 1)
    loop[n : n + c, :n], loop[n : n + c, n : n + c] = controller.B @ C, controller.A
    for age in range(waiting):
        at = n + c + N_MOUNTS * age
        loop[at : at + N_MOUNTS] = command(age)
    names = (*model.states, *(f"controller {k}" for k in range(size - n)))
    return loop, names
