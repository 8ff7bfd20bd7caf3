"""Any machine on any mounts, with masses that move on it, from momentum balance in space; integrated with SciPy.

Physics.md sections 2, 3 and 6. The machine is a rigid body that turns by a rotation matrix; nothing here is linearised
and there is no Jacobian of strokes. Of each foot r_i the place u + R r_i is followed in space; what its mount does acts
there, in space:

    along d:   A_p (P1 - P2) - K_L s - C s' - m_p (a_foot . d) - m_p g d_z,   s = d . (foot - ground) - height
    across d: -k_l (1 - d d^T) (foot - ground) - c_l (1 - d d^T) (foot' - ground')

(the plate follows along d, where the cylinder guides it; what it weighs across d the guide carries). Momentum and
moment of momentum of all bodies are balanced about the mount plane's centre, which itself accelerates:

    sum m_k a_k = forces,      sum rho_k x m_k a_k + d(R I_k R^T w)/dt = moments

with a_k = u'' + w' x rho + w x (w x rho) + 2 w x R r' + R r'' of a mass whose place r(t) on the machine is prescribed.
Coordinates: u [m] and the angles rx, ry, rz [rad] of R = Rz Rx Ry; speeds: u' and the angular velocity w in space.
Valves and chambers are those of `oracles.machine`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

from oracles.machine import OracleActuator

Array = NDArray[np.float64]
Command = Callable[[float], ArrayLike]
Ground = Callable[[float], tuple[ArrayLike, ArrayLike]]
Path = Callable[[float], tuple[ArrayLike, ArrayLike, ArrayLike]]

_SIDE = np.array([[1.0], [-1.0]])


@dataclass(frozen=True)
class GeneralMount:
    """A mount at a place [m] that acts along a unit vector, on a shim [m]."""

    place: tuple[float, float, float]
    along: tuple[float, float, float] = (0.0, 0.0, 1.0)
    actuator: OracleActuator = field(default_factory=OracleActuator)
    height: float = 0.0


@dataclass(frozen=True)
class MovingMass:
    """A mass [kg] on the machine that turns with it; ``path`` gives r, r', r'' (3,) of its CG on the machine [m]."""

    mass: float
    inertia: ArrayLike
    path: Path


@dataclass(frozen=True)
class GeneralMachine:
    """The rigid machine, its mounts, and what moves on it; ``inertia`` is (3,) or (3, 3) about the CG [kg m2]."""

    mounts: tuple[GeneralMount, ...]
    mass: float = 4000.0
    inertia: ArrayLike = (2000.0, 3000.0, 4000.0)
    cg: tuple[float, float, float] = (0.0, 0.0, 0.75)
    gravity: float = 9.80665
    moving: tuple[MovingMass, ...] = field(default=())

    @cached_property
    def equations(self) -> "_Equations":
        """The right-hand side."""
        return _Equations(self)


@dataclass(frozen=True)
class GeneralRun:
    """A run over n times: time [s], q and qd (n, 6): x, y, z [m], rx, ry, rz [rad]; velocity of u and angular velocity
    in space (n, 6), spool (n, mount) [mA], pressure (n, mount, 2) [Pa], stroke (n, mount) [m]."""

    time: Array
    q: Array
    velocity: Array
    spool: Array
    pressure: Array
    stroke: Array
    evaluations: int

    @property
    def load_pressure(self) -> Array:
        """P1 - P2 (n, mount) [Pa]."""
        return self.pressure[:, :, 0] - self.pressure[:, :, 1]


def tensor(inertia: ArrayLike) -> Array:
    """(3, 3) of principal values or of a tensor."""
    inertia = np.asarray(inertia, float)
    return np.diag(inertia) if inertia.ndim == 1 else inertia


def skew(w: ArrayLike) -> Array:
    """w x as a matrix."""
    a, b, c = np.asarray(w, float)
    return np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])


def _crosses(a: Array, b: Array) -> Array:
    """Cross products of rows."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=1)


def turn(axis: int, angle: float) -> Array:
    """Rotation about one axis, less one: small angles lose nothing."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros((3, 3))
    out[i, i] = out[j, j] = -2.0 * np.sin(angle / 2) ** 2
    out[j, i] = np.sin(angle)
    out[i, j] = -out[j, i]
    return out


def rotation(angles: ArrayLike) -> tuple[Array, Array]:
    """R - 1 of R = Rz Rx Ry, and the matrix from the rates of rx, ry, rz to the angular velocity in space."""
    rx, ry, rz = np.asarray(angles, float)
    a, b, c = turn(2, rz), turn(0, rx), turn(1, ry)
    ab = a + b + a @ b
    excess = ab + c + ab @ c
    axes = np.stack([a[:, 0], ab[:, 1], np.zeros(3)], axis=1) + np.eye(3)
    return excess, axes


class _Equations:
    """Constants of a machine, and the right-hand side on the packed state: u (3), angles (3), u' (3), w (3), spools
    (n), their rates (n), pressures P1 (n), P2 (n)."""

    def __init__(self, machine: GeneralMachine) -> None:
        mounts = machine.mounts
        self.machine, self.n = machine, len(mounts)
        self.r = np.array([mount.place for mount in mounts], float)
        along = np.array([mount.along for mount in mounts], float)
        self.d = along / np.linalg.norm(along, axis=1)[:, None]
        self.height = np.array([mount.height for mount in mounts])
        self.inertia, self.cg = tensor(machine.inertia), np.asarray(machine.cg, float)
        names = (
            "K_L", "C", "k_lat", "c_lat", "m_plate", "A_p", "V_t", "beta", "K_Q", "g0", "cross", "K_v", "v_max",
            "a_max", "omega_v", "zeta", "x_max", "P_s", "P_t", "moving_volume",
        )  # fmt: skip
        for name in names:
            setattr(self, name, np.array([getattr(mount.actuator, name) for mount in mounts], float))
        self.eps2 = np.maximum([mount.actuator.eps**2 for mount in mounts], 1e-300)
        self.scale = np.repeat([1e-7, 1e-5, 1.0, 1e2, 1e4], [6, 6, self.n, self.n, 2 * self.n])

    def strokes(self, y: Array, ground: Array) -> Array:
        """Strokes of a packed state over the ground (mount, 3)."""
        excess, _ = rotation(y[3:6])
        return ((y[:3] + self.r @ excess.T - ground) * self.d).sum(axis=1) - self.height

    def balance(self, t: float, y: Array, ground: Array, moving: Array) -> tuple[Array, Array, Array, Array]:
        """Mass matrix (6, 6) of u'' and w', force and moment about u (6,) against it, strokes and their rates."""
        n, d, machine = self.n, self.d, self.machine
        v, w = y[6:9], y[9:12]
        pressure = y[12 + 2 * n :].reshape(2, n)
        excess, _ = rotation(y[3:6])
        spin = skew(w)
        centripetal = spin @ spin
        swing = self.r @ excess.T
        arm = self.r + swing  # from u to each foot, in space
        offset, speed = y[:3] + swing - ground, v + arm @ spin.T - moving
        stroke, stroke_rate = (offset * d).sum(axis=1), (speed * d).sum(axis=1)
        across, across_rate = offset - stroke[:, None] * d, speed - stroke_rate[:, None] * d
        stroke = stroke - self.height
        # What a plate takes for itself along d, but for u'' and w', and its weight.
        plate = self.m_plate * ((arm @ centripetal.T * d).sum(axis=1) + machine.gravity * d[:, 2])
        push = self.A_p * (pressure[0] - pressure[1]) - self.K_L * stroke - self.C * stroke_rate - plate
        force = push[:, None] * d - self.k_lat[:, None] * across - self.c_lat[:, None] * across_rate
        wrench = np.concatenate([force.sum(axis=0), _crosses(arm, force).sum(axis=0)])
        lever = np.hstack([d, _crosses(arm, d)])  # d . a_foot = lever . (u'', w') + …
        mass = (lever.T * self.m_plate) @ lever
        turned = np.eye(3) + excess
        bodies = [(machine.mass, self.inertia, self.cg, np.zeros(3), np.zeros(3))]
        bodies += [(b.mass, tensor(b.inertia), *(np.asarray(p, float) for p in b.path(t))) for b in machine.moving]
        for m, inertia, place, along, faster in bodies:
            rho, own = turned @ place, turned @ inertia @ turned.T
            reach = np.hstack([np.eye(3), -skew(rho)])
            mass += m * reach.T @ reach
            mass[3:, 3:] += own
            carried = centripetal @ rho + 2.0 * spin @ turned @ along + turned @ faster
            wrench -= m * reach.T @ (carried + np.array([0.0, 0.0, machine.gravity]))
            wrench[3:] -= spin @ own @ w
        return mass, wrench, stroke, stroke_rate

    def rhs(self, t: float, y: Array, voltage: Array, ground: Array, moving: Array) -> Array:
        """Time derivative of the packed state under voltage (n,), ground displacement and velocity (n, 3)."""
        n = self.n
        spool, rate, pressure = y[12 : 12 + n], y[12 + n : 12 + 2 * n], y[12 + 2 * n :].reshape(2, n)
        mass, wrench, stroke, stroke_rate = self.balance(t, y, ground, moving)
        wanted = self.K_v * np.clip(voltage, -self.v_max, self.v_max)
        drive = np.clip(self.omega_v**2 * (wanted - spool), -self.a_max, self.a_max)
        inflow = self.flow(spool, pressure) - _SIDE * self.A_p * stroke_rate
        volume = self.V_t / 2 + _SIDE * self.A_p * self.moving_volume * stroke
        return np.concatenate([
            y[6:9], np.linalg.solve(rotation(y[3:6])[1], y[9:12]), np.linalg.solve(mass, wrench),
            rate, drive - 2 * self.zeta * self.omega_v * rate, (self.beta / volume * inflow).ravel(),
        ])  # fmt: skip

    def flow(self, spool: Array, pressure: Array) -> Array:
        """Flow into the chambers (2, n) [m3/s]: four edges K_Q |x| phi(dp/dp0), laminar leaks."""
        x = np.clip(spool, -self.x_max, self.x_max)
        opening = self.K_Q * np.maximum(_SIDE * x, 0.0)
        drop = np.stack([self.P_s - pressure, pressure - self.P_t])
        r = drop / ((self.P_s - self.P_t) / 2)
        phi = r / np.sqrt(np.sqrt(r * r + self.eps2))
        laminar = self.g0 * (drop[0] - drop[1]) - self.cross * (pressure - pressure[::-1])
        return opening * phi[0] - opening[::-1] * phi[1] + laminar


def of_plant(plant: Any, moving: tuple[MovingMass, ...] = ()) -> GeneralMachine:
    """The oracle's machine with a plant's numbers (nothing of the package but its settings is used)."""
    actuators = [
        OracleActuator(
            K_Q=a.flow_gain,
            K_v=a.valve_gain,
            omega_v=a.valve_frequency,
            zeta=a.valve_damping,
            a_max=a.spool_drive_limit,
            v_max=a.voltage_limit,
            x_max=a.spool_stroke,
            A_p=a.piston_area,
            V_t=a.chamber_volume,
            beta=a.bulk_modulus,
            K_L=a.membrane_stiffness,
            C=a.membrane_damping,
            k_lat=a.lateral_stiffness,
            c_lat=a.lateral_damping,
            m_plate=a.plate_mass,
            g0=a.edge_leakage_share * a.flow_pressure,
            cross=(1 - a.edge_leakage_share) * a.flow_pressure,
            eps=a.laminar_ratio,
            P_s=plant.supply.pressure,
            P_t=plant.supply.tank_pressure,
            moving_volume=a.moving_volume,
        )
        for a in plant.actuators
    ]
    each = zip(plant.positions, plant.directions, actuators, plant.heights, strict=True)
    machine = plant.machine
    mounts = tuple(GeneralMount(*mount) for mount in each)
    return GeneralMachine(mounts, machine.mass, machine.inertia, machine.cg, plant.gravity, moving)


def equilibrium(machine: GeneralMachine, t: float = 0.0) -> Array:
    """Packed state at rest, ground at zero, valves centred; masses that move stand where they are at ``t``.

    Raises RuntimeError where SciPy finds none.
    """
    eq = machine.equations
    still = tuple(MovingMass(m.mass, m.inertia, _held(m.path(t)[0])) for m in machine.moving)
    rest = GeneralMachine(machine.mounts, machine.mass, machine.inertia, machine.cg, machine.gravity, still).equations
    zero, n = np.zeros((eq.n, 3)), eq.n
    start = np.zeros(12 + 4 * n)
    start[12 + 2 * n :] = np.tile((eq.P_s + eq.P_t) / 2, 2)

    def residual(q: Array) -> Array:
        y = start.copy()
        y[:6] = q * 1e-5
        return rest.rhs(t, y, np.zeros(n), zero, zero)[6:12]

    found = root(residual, np.zeros(6), method="hybr", tol=1e-14)
    if np.abs(found.fun).max() > 1e-7:
        raise RuntimeError(f"no equilibrium: {found.message}, {np.abs(found.fun).max():.1e} m/s2 are left")
    start[:6] = found.x * 1e-5
    return start


def _held(place: ArrayLike) -> Path:
    return lambda t: (place, np.zeros(3), np.zeros(3))


def jacobian(machine: GeneralMachine) -> Array:
    """d(rates)/d(state) about `equilibrium`, by central differences."""
    eq = machine.equations
    y0, zero, n = equilibrium(machine), np.zeros((eq.n, 3)), eq.n
    step = np.repeat([1e-6, 1e-3, 1e-2, 1e1, 1e3], [6, 6, n, n, 2 * n])
    columns = []
    for k, h in enumerate(step):
        shift = np.zeros_like(y0)
        shift[k] = h
        ahead, behind = (eq.rhs(0.0, y0 + s * shift, np.zeros(n), zero, zero) for s in (1, -1))
        columns.append((ahead - behind) / (2 * h))
    return np.array(columns).T


def simulate(
    machine: GeneralMachine,
    times: ArrayLike,
    command: Command | None = None,
    ground: Ground | None = None,
    start: Array | None = None,
    rtol: float = 1e-9,
    max_step: float = np.inf,
) -> GeneralRun:
    """Run from times[0] and report at times (n,) [s].

    command: t -> (mount,) [V]; ground: t -> displacement and velocity (mount, 3) [m, m/s]; start: a packed state, that
    of `equilibrium` without. The tolerance is relative, and absolute in units of 0.1 um, 10 um/s, 1 mA, 100 mA/s and
    1e4 Pa about the start. Raises RuntimeError when SciPy gives up.
    """
    eq, time = machine.equations, np.asarray(times, float)
    first = equilibrium(machine, time[0]) if start is None else start
    rest, silence = np.zeros((eq.n, 3)), np.zeros(eq.n)

    def inputs(t: float) -> tuple[Array, Array, Array]:
        voltage = silence if command is None else np.asarray(command(t), float)
        moved, moving = (rest, rest) if ground is None else ground(t)
        return voltage, np.asarray(moved, float), np.asarray(moving, float)

    def rhs(t: float, y: Array) -> Array:
        return eq.rhs(t, first + eq.scale * y, *inputs(t)) / eq.scale

    span = (time[0], time[-1])
    run = solve_ivp(rhs, span, np.zeros_like(first), "DOP853", time, rtol=rtol, atol=rtol, max_step=max_step)
    if not run.success:
        raise RuntimeError(f"SciPy stopped at {run.t[-1]} s: {run.message}")
    states = first + run.y.T * eq.scale
    q, velocity, spool, _, pressure = np.split(states, [6, 12, 12 + eq.n, 12 + 2 * eq.n], axis=1)
    strokes = np.array([eq.strokes(y, inputs(t)[1]) for t, y in zip(time, states, strict=True)])
    return GeneralRun(time, q, velocity, spool, pressure.reshape(-1, 2, eq.n).transpose(0, 2, 1), strokes, run.nfev)
