"""The whole nonlinear machine on four actuators, straight from physics.md sections 2 to 4, integrated with SciPy.

Rigid body on rigid feet, linearised kinematics: coordinates q = (x, y, z, rx, ry, rz) of the mount plane's centre
[m, rad], CG at (cx, cy, h), mounts in the order front-left, front-right, rear-left, rear-right (+x front, +y left).
A foot moves by (x - y_i rz, y + x_i rz, z + y_i rx - x_i ry). Plates ride on the feet's vertical coordinate only:
they add mass and weight there, and nothing laterally. Gravity's geometric term is -m g h on rocking (machine only).
Chamber pressures are absolute; there is no cavitation floor, no spool end stop, constant bulk modulus and supply.

Second-order kinematics are left out, without an option, because they do not matter: against the exact Lagrangian
(joint order x, y, z, rz, rx, ry, exact body and feet) they change x, y, z, rx, ry and the load pressures of the
benchmark by at most 3e-9 of each channel's peak, and ten times the command by 3e-8 (default machine 7e-8). Yaw is
the exception: here vertical forces leave it at zero (1e-23 rad of rounding), where the exact one is of the order of
1e-14 rad, so do not compare yaw against its own peak unless the ground drives it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Command = Callable[[float], ArrayLike]
Ground = Callable[[float], tuple[ArrayLike, ArrayLike]]

SPOOL_FULL = 20.0  # mA, full stroke (physics.md section 2, assumed)
BENCHMARK_HZ = np.array([13.0, 17.0, 23.0, 29.0])
_SIDE = np.array([[1.0], [-1.0]])  # chamber 1 grows with the stroke, chamber 2 shrinks
# Integration units: x, y, z [m], rx, ry, rz [rad], their rates, spool [mA] and rate [mA/s], pressure [Pa]
_SCALE = np.repeat([1e-7, 1e-5, 1.0, 1e2, 1e4], [6, 6, 4, 4, 8])


@dataclass(frozen=True)
class OracleActuator:
    """One actuator and its valve (physics.md sections 1 and 2). Defaults: Table I and the assumed values."""

    K_Q: float = 1.94e-6  # flow gain at null [m3/s/mA], Table I
    K_v: float = 2.0  # command gain [mA/V], Table I
    omega_v: float = 1571.0  # spool natural frequency [rad/s], Table I at 5 %
    zeta: float = 0.65  # spool damping ratio [-], Table I
    a_max: float = 2.71e5 * 20.0  # limit of the spool's spring drive [mA/s2]; inf switches it off
    v_max: float = 10.0  # command limit [V]
    x_max: float = SPOOL_FULL  # spool limit as the flow sees it [mA]
    A_p: float = 3.18e-2  # piston area [m2], Table I
    V_t: float = 5.39e-4  # oil volume, both chambers [m3], Table I
    beta: float = 1.4e9  # bulk modulus [Pa], Table I
    K_L: float = 6.8e8  # vertical membrane stiffness [N/m], Table I
    C: float = 3900.0  # vertical damping [N s/m], Table I
    k_lat: float = 2e8  # lateral membrane stiffness, x and y [N/m], assumed
    c_lat: float = 2e4  # lateral damping, x and y [N s/m], assumed
    m_plate: float = 14.0  # plate mass, vertical only [kg], assumed split
    g0: float = 0.05 * 6.6e-11  # laminar leakage of each of the four edges [m3/s/Pa], assumed
    cross: float = 0.95 * 6.6e-11  # laminar leakage across the piston [m3/s/Pa]
    eps: float = 1e-3  # laminar end of the orifice law [-]; 0 is the plain signed square root
    P_s: float = 70e5  # supply pressure [Pa], assumed
    P_t: float = 0.0  # tank pressure [Pa]
    moving_volume: bool = True  # chambers V_t/2 +- A_p x_p; False keeps V_t/2

    @property
    def K_C(self) -> float:
        """Flow-pressure coefficient at null [m3/s/Pa] (eq. 3): g0 + cross."""
        return self.g0 + self.cross


@dataclass(frozen=True)
class OracleMachine:
    """The rigid machine and its four mounts (physics.md section 3, all assumed but the total of 4056 kg)."""

    mass: float = 4000.0  # without the plates [kg]
    inertia: tuple[float, float, float] = (2000.0, 3000.0, 4000.0)  # about the CG, principal x, y, z [kg m2]
    cg: tuple[float, float, float] = (0.0, 0.0, 0.75)  # from the mount plane's centre [m]
    mounts: tuple[tuple[float, float], ...] = ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6))  # (4, 2) [m]
    gravity: float = 9.80665  # [m/s2]
    actuators: tuple[OracleActuator, ...] = (OracleActuator(),) * 4

    @cached_property
    def equations(self) -> "_Equations":
        """The constant matrices and the right-hand side."""
        return _Equations(self)


@dataclass(frozen=True)
class OracleState:
    """One state (or its time derivative): q (6,), qd (6,), spool (4,) [mA], spool_rate (4,), pressure (4, 2) [Pa]."""

    q: Array
    qd: Array
    spool: Array
    spool_rate: Array
    pressure: Array

    def pack(self) -> Array:
        """All as one vector (28,); the pressures chamber by chamber."""
        parts = (self.q, self.qd, self.spool, self.spool_rate, np.asarray(self.pressure).T)
        return np.concatenate([np.asarray(part, float).ravel() for part in parts])

    @staticmethod
    def unpack(vector: Array) -> "OracleState":
        """Inverse of pack."""
        q, qd, spool, rate, pressure = np.split(vector, [6, 12, 16, 20])
        return OracleState(q, qd, spool, rate, pressure.reshape(2, 4).T)


@dataclass(frozen=True)
class OracleRun:
    """A run over n times: time (n,) [s], q and qd (n, 6) [m, rad, 1/s], spool and spool_rate (n, 4) [mA, mA/s],
    pressure (n, 4, 2) [Pa absolute], load_pressure (n, 4) = P1 - P2 [Pa], stroke (n, 4) [m], evaluations."""

    time: Array
    q: Array
    qd: Array
    spool: Array
    spool_rate: Array
    pressure: Array
    load_pressure: Array
    stroke: Array
    evaluations: int


class _Equations:
    """Constant matrices of one machine, and the right-hand side on the packed state (28,)."""

    def __init__(self, machine: OracleMachine) -> None:
        mounts = np.asarray(machine.mounts, float)
        x, y = mounts.T
        zero, one = np.zeros(4), np.ones(4)
        rows = [[one, zero, zero, zero, zero, -y], [zero, one, zero, zero, zero, x], [zero, zero, one, y, -x, zero]]
        feet = np.moveaxis(np.array(rows), 2, 0)  # (4, 3, 6): foot motion per mount and axis
        cx, cy, h = machine.cg
        # (3, 6): the CG moves by p + theta x (cx, cy, h)
        cg = np.array([[1, 0, 0, 0, h, -cy], [0, 1, 0, -h, 0, cx], [0, 0, 1, cy, -cx, 0]], float)

        def column(name: str) -> Array:
            return np.array([getattr(actuator, name) for actuator in machine.actuators], float)

        plates, vertical = column("m_plate"), feet[:, 2, :]
        self.mass = machine.mass * cg.T @ cg + vertical.T @ (plates[:, None] * vertical)
        self.mass[3:, 3:] += np.diag(machine.inertia)
        self.inverse_mass = np.linalg.inv(self.mass)
        self.weight = -machine.gravity * (machine.mass * cg[2] + vertical.T @ plates)
        self.topple = machine.mass * machine.gravity * h * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
        self.feet = feet.reshape(12, 6)
        self.fall = self.inverse_mass @ self.weight
        self.react = self.inverse_mass @ np.hstack([self.feet.T, np.diag(self.topple)])  # foot forces and q, (6, 18)
        self.vertical = vertical
        self.stiffness = np.stack([column("k_lat"), column("k_lat"), column("K_L")], axis=1)
        self.damping = np.stack([column("c_lat"), column("c_lat"), column("C")], axis=1)
        self.gain, self.v_max, self.x_max = column("K_v"), column("v_max"), column("x_max")
        self.omega2, self.friction = column("omega_v") ** 2, 2 * column("zeta") * column("omega_v")
        self.a_max, self.K_Q = column("a_max"), column("K_Q")
        self.eps2 = np.maximum(column("eps") ** 2, 1e-300)  # the floor only keeps 0/0 away
        self.g0, self.cross, self.area, self.beta = column("g0"), column("cross"), column("A_p"), column("beta")
        self.P_s, self.P_t = column("P_s"), column("P_t")
        self.dp0 = (self.P_s - self.P_t) / 2
        self.half = column("V_t") / 2
        self.swept = _SIDE * self.area * column("moving_volume")

    def flow(self, spool: Array, pressure: Array) -> Array:
        """Flow into the chambers (2, 4) [m3/s] from spool (4,) [mA] and pressure (2, 4) [Pa].

        Four edges K_Q |x| phi(dp/dp0) with phi(r) = r/(r^2 + eps^2)^(1/4), laminar g0 per edge, cross over the piston.
        """
        x = np.maximum(-self.x_max, np.minimum(self.x_max, spool))
        opening = self.K_Q * np.maximum(_SIDE * x, 0.0)  # supply edges; the tank edges open crosswise
        drop = np.stack([self.P_s - pressure, pressure - self.P_t])
        r = drop / self.dp0
        phi = r / np.sqrt(np.sqrt(r * r + self.eps2))
        laminar = self.g0 * (drop[0] - drop[1]) - self.cross * (pressure - pressure[::-1])
        return opening * phi[0] - opening[::-1] * phi[1] + laminar

    def rhs(self, state: Array, voltage: Array, moved: Array, moving: Array) -> Array:
        """Time derivative of the packed state under voltage (4,), ground displacement and velocity (4, 3)."""
        q, qd, spool, rate = state[:6], state[6:12], state[12:16], state[16:20]
        pressure = state[20:].reshape(2, 4)
        offset = (self.feet @ q).reshape(4, 3) - moved
        speed = (self.feet @ qd).reshape(4, 3) - moving
        force = -self.stiffness * offset - self.damping * speed
        force[:, 2] += self.area * (pressure[0] - pressure[1])
        command = self.gain * np.maximum(-self.v_max, np.minimum(self.v_max, voltage))
        drive = np.maximum(-self.a_max, np.minimum(self.a_max, self.omega2 * (command - spool)))
        inflow = self.flow(spool, pressure) - _SIDE * (self.area * speed[:, 2])
        out = np.empty(28)
        out[:6] = qd
        out[6:12] = self.react @ np.concatenate([force.ravel(), q]) + self.fall
        out[12:16] = rate
        out[16:20] = drive - self.friction * rate
        out[20:] = (self.beta / (self.half + self.swept * offset[:, 2]) * inflow).ravel()
        return out


def default_machine() -> OracleMachine:
    """The default four-mount machine of physics.md section 3 (4000 kg and four plates of 14 kg, 70 bar, gravity)."""
    return OracleMachine()


def benchmark_machine(K_v: float = 1.0) -> OracleMachine:
    """The benchmark case of benchmark.md.

    It names no K_v, so its command is read as the spool's set point itself (K_v = 1). With Table I's K_v = 2 motions
    double and, scaled back, differ by up to 9e-4 of peak: use the same K_v on both sides of a comparison.
    """
    actuator = OracleActuator(
        K_v=K_v, a_max=np.inf, m_plate=0.0, g0=0.0, cross=6.6e-11, eps=0.0, P_s=210e5, moving_volume=False
    )
    return OracleMachine(mass=4056.0, cg=(0.0, 0.0, 0.6), gravity=0.0, actuators=(actuator,) * 4)


def benchmark_plates_machine(K_v: float = 1.0) -> OracleMachine:
    """The benchmark's variant: machine 4000 kg, four plates of 14 kg on the feet's vertical motion."""
    machine = benchmark_machine(K_v)
    return replace(machine, mass=4000.0, actuators=(replace(machine.actuators[0], m_plate=14.0),) * 4)


def benchmark_command(t: float) -> Array:
    """Commands 0.5 sin(2 pi f t), f = 13, 17, 23, 29 Hz, (4,) (benchmark.md)."""
    return 0.5 * np.sin(2 * np.pi * BENCHMARK_HZ * t)


def equilibrium(machine: OracleMachine) -> OracleState:
    """Rest under gravity, ground at zero, valves centred: membranes carry the weight, pressures (P_s + P_t)/2.

    Raises numpy.linalg.LinAlgError when stiffness does not beat gravity's geometric term (the machine falls over).
    """
    equations = machine.equations
    stiffness = equations.feet.T @ (equations.stiffness.reshape(12, 1) * equations.feet) - np.diag(equations.topple)
    np.linalg.cholesky(stiffness)
    middle = (equations.P_s + equations.P_t) / 2
    q = np.linalg.solve(stiffness, equations.weight)
    return OracleState(q, np.zeros(6), np.zeros(4), np.zeros(4), np.stack([middle, middle], axis=1))


def rates(
    machine: OracleMachine,
    state: OracleState,
    voltage: ArrayLike = (0.0,) * 4,
    displacement: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
) -> OracleState:
    """Time derivative of a state under voltage (4,) [V], ground displacement [m] and velocity [m/s] (4, 3)."""
    moved, moving = (np.broadcast_to(np.asarray(part, float), (4, 3)) for part in (displacement, velocity))
    return OracleState.unpack(machine.equations.rhs(state.pack(), np.asarray(voltage, float), moved, moving))


def simulate(
    machine: OracleMachine,
    times: ArrayLike,
    command: Command | None = None,
    ground: Ground | None = None,
    start: OracleState | None = None,
    rtol: float = 1e-11,
    method: str = "DOP853",
    breaks: Sequence[float] = (),
    max_step: float = np.inf,
) -> OracleRun:
    """Run from times[0] and report at times (n,) [s], increasing.

    command: t -> (4,) [V]; None is zero. ground: t -> displacement (4, 3) [m], velocity (4, 3) [m/s]; None is rest.
    start: state at times[0]; None is `equilibrium`. The integrator sees deviations from the start in units of 0.1 um,
    10 um/s, 1 mA, 100 mA/s and 1e4 Pa, with atol = rtol in those units, so rtol means what it says for small motions.
    breaks: instants at which command or ground jump (right-continuous); the integration restarts there.
    max_step [s]: set it when the input rests for a while and then acts. Raises RuntimeError when SciPy gives up.
    """
    equations, time = machine.equations, np.asarray(times, float)
    first = (start or equilibrium(machine)).pack()
    rest, silence = np.zeros((4, 3)), np.zeros(4)

    def inputs(t: float) -> tuple[Array, Array, Array]:
        voltage = silence if command is None else np.asarray(command(t), float)
        moved, moving = (rest, rest) if ground is None else ground(t)
        return voltage, np.asarray(moved, float), np.asarray(moving, float)

    edges = [time[0], *sorted(b for b in set(breaks) if time[0] < b < time[-1]), time[-1]]
    scaled, evaluations = np.zeros((len(time), 28)), 0
    here = np.zeros(28)
    for i, (begin, end) in enumerate(pairwise(edges)):
        last = end if i == len(edges) - 2 else np.nextafter(end, begin)  # a jump at `end` belongs to the next piece

        def rhs(t: float, y: Array, last: float = last) -> Array:
            return equations.rhs(first + _SCALE * y, *inputs(min(t, last))) / _SCALE

        inside = (time >= begin) & (time <= end)
        wanted = np.union1d(time[inside], [end])
        run = solve_ivp(rhs, (begin, end), here, method, wanted, rtol=rtol, atol=rtol, max_step=max_step)
        if not run.success:
            raise RuntimeError(f"{method} stopped at {run.t[-1]} s: {run.message}")
        scaled[inside] = run.y.T[: inside.sum()]
        here, evaluations = run.y[:, -1], evaluations + run.nfev
    return _collect(equations, time, first + scaled * _SCALE, inputs, evaluations)


def _collect(equations: _Equations, time: Array, states: Array, inputs: Callable, evaluations: int) -> OracleRun:
    """Packed states (n, 28) as an OracleRun."""
    q, qd, spool, spool_rate, chambers = np.split(states, [6, 12, 16, 20], axis=1)
    pressure = chambers.reshape(-1, 2, 4).transpose(0, 2, 1)
    load_pressure = pressure[:, :, 0] - pressure[:, :, 1]
    stroke = q @ equations.vertical.T - np.array([inputs(t)[1][:, 2] for t in time])
    return OracleRun(time, q, qd, spool, spool_rate, pressure, load_pressure, stroke, evaluations)
