"""Closed linear forms: the paper's single actuator, and the four-mount machine as a state space built by hand.

Shares no code with machine.py, and takes other routes on purpose: the mass matrix comes from the spatial inertia, and
`transmissibility` eliminates the oil into a mount impedance instead of using the state space. Sources: paper eqs. 1 to
9 and Table I, physics.md sections 1 and 3. s is the Laplace variable [rad/s], scalar or array, complex.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
PerMount = float | tuple[float, float, float, float]

STATES = 28  # q (6), qd (6), spool (4), spool_rate (4), P1 (4), P2 (4)
INPUTS = 28  # voltage (4), ground displacement (4 x 3, mount by mount), ground velocity (4 x 3)
OUTPUTS = 20  # q (6), qd (6), load pressure (4), stroke (4)
DOFS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class PaperActuator:
    """The paper's single actuator under the whole machine: Table I."""

    M: float = 4056.0  # moving mass [kg]
    A_p: float = 3.18e-2  # piston area [m2]
    C: float = 3900.0  # viscous coefficient [N s/m]
    V_t: float = 5.39e-4  # total chamber volume [m3]
    K_L: float = 6.8e8  # static stiffness [N/m]
    K_Q: float = 1.94e-6  # flow gain [m3/s/mA]
    K_C: float = 6.6e-11  # flow-pressure coefficient [m3/s/Pa]
    omega_v: float = 1571.0  # valve natural frequency [rad/s] at 5 %
    zeta: float = 0.65  # valve damping ratio [-]
    K_v: float = 2.0  # valve gain [mA/V]
    beta: float = 1.4e9  # bulk modulus [Pa]


SYMBOLS = {
    "mass": "M",
    "piston_area": "A_p",
    "membrane_damping": "C",
    "chamber_volume": "V_t",
    "membrane_stiffness": "K_L",
    "flow_gain": "K_Q",
    "flow_pressure": "K_C",
    "valve_frequency": "omega_v",
    "valve_damping": "zeta",
    "valve_gain": "K_v",
    "bulk_modulus": "beta",
}
"""Names of ehamj's settings for these symbols."""


def omega_h(p: PaperActuator) -> float:
    """Hydro-mechanical natural frequency [rad/s] (below eq. 8): sqrt(4 beta A_p^2/(V_t M))."""
    return float(np.sqrt(4 * p.beta * p.A_p**2 / (p.V_t * p.M)))


def delta_h(p: PaperActuator) -> float:
    """Hydraulic damping ratio [-] (below eq. 8): (K_C/A_p) sqrt(beta M/V_t)."""
    return float(p.K_C / p.A_p * np.sqrt(p.beta * p.M / p.V_t))


def _complex(s: ArrayLike) -> Complex:
    """A complex array."""
    return np.asarray(s, dtype=np.complex128)


def valve(p: PaperActuator, s: ArrayLike) -> Complex:
    """Eq. 1: x_v/v [mA/V]."""
    r = _complex(s) / p.omega_v
    return p.K_v / (1 + 2 * p.zeta * r + r**2)


def actuator_exact(p: PaperActuator, s: ArrayLike) -> Complex:
    """Exact x_p/x_v [m/mA] from eqs. 3, 6 and 7 with F_L = 0."""
    s = _complex(s)
    leak = p.K_C / p.A_p**2 + p.V_t * s / (4 * p.beta * p.A_p**2)
    return (p.K_Q / p.A_p) / (s + leak * (p.M * s**2 + p.C * s + p.K_L))


def compliance_exact(p: PaperActuator, s: ArrayLike) -> Complex:
    """Exact x_p/F_L [m/N] from eqs. 3, 6 and 7 with x_v = 0; negative, since eq. 7 counts F_L as a load."""
    s = _complex(s)
    return -1 / (p.M * s**2 + p.C * s + p.K_L + p.A_p**2 * s / (p.K_C + p.V_t * s / (4 * p.beta)))


def actuator_eq8(p: PaperActuator, s: ArrayLike) -> Complex:
    """Eq. 8 with its damping term corrected to 2 delta_h s/omega_h: x_p/x_v [m/mA], for K_L << K_h and C = 0."""
    s = _complex(s)
    r = s / omega_h(p)
    return (p.K_Q / p.A_p) / ((s + p.K_C * p.K_L / p.A_p**2) * (r**2 + 2 * delta_h(p) * r + 1))


def gain_margin(p: PaperActuator, exact: bool = True) -> tuple[float, float]:
    """Gain margin [dB] and phase-crossover frequency [Hz] of x_p/v (eq. 9) in unity feedback."""
    actuator = actuator_exact if exact else actuator_eq8

    def loop(hertz: float) -> complex:
        s = 2j * np.pi * hertz
        return complex(valve(p, s) * actuator(p, s))

    grid = np.linspace(1.0, 1000.0, 4000)
    phase = np.unwrap(np.angle([loop(f) for f in grid]))
    after = int(np.argmax(phase < -np.pi))
    crossing = float(brentq(lambda f: loop(f).imag, grid[after - 1], grid[after], xtol=1e-10))
    return -20 * float(np.log10(abs(loop(crossing)))), crossing


@dataclass(frozen=True)
class LinearMachine:
    """The four-mount machine, linear at null spool (physics.md section 3). A mount value is one number or four."""

    mass: float = 4000.0  # machine without plates [kg]
    inertia: tuple[float, float, float] = (2000.0, 3000.0, 4000.0)  # about the CG [kg m2]
    cg: tuple[float, float, float] = (0.0, 0.0, 0.75)  # from the mount plane's centre [m]
    mounts: tuple[tuple[float, float], ...] = ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6))  # [m]
    gravity: float = 9.80665  # [m/s2]; only its geometric term matters here
    m_plate: PerMount = 14.0  # on the foot's vertical motion [kg]
    k_lat: PerMount = 2e8  # lateral stiffness [N/m]
    c_lat: PerMount = 2e4  # lateral damping [N s/m]
    K_L: PerMount = 6.8e8  # vertical stiffness [N/m]
    C: PerMount = 3900.0  # vertical damping [N s/m]
    A_p: PerMount = 3.18e-2  # piston area [m2]
    V_t: PerMount = 5.39e-4  # both chambers [m3]
    beta: PerMount = 1.4e9  # bulk modulus [Pa]
    K_Q: PerMount = 1.94e-6  # flow gain [m3/s/mA]
    g0: PerMount = 3.3e-12  # laminar leakage per edge [m3/s/Pa]
    cross: PerMount = 6.27e-11  # laminar leakage across the piston [m3/s/Pa]; g0 + cross = K_C
    K_v: PerMount = 2.0  # command gain [mA/V]
    omega_v: PerMount = 1571.0  # spool natural frequency [rad/s]
    zeta: PerMount = 0.65  # spool damping ratio [-]
    stroke: PerMount = 0.0  # stroke of the operating point [m]: chambers V_t/2 +- A_p stroke


def benchmark_linear() -> LinearMachine:
    """The benchmark of benchmark.md, linear: no gravity, no plates, no edge leakage, K_v = 1 (commands in mA)."""
    return LinearMachine(mass=4056.0, cg=(0.0, 0.0, 0.6), gravity=0.0, m_plate=0.0, g0=0.0, cross=6.6e-11, K_v=1.0)


def _each(value: PerMount) -> Real:
    """A mount value as (4,)."""
    return np.broadcast_to(np.asarray(value, float), (4,))


def foot_maps(m: LinearMachine) -> tuple[Real, Real, Real]:
    """Foot motion in x, y and z as (4, 6) each, per unit q: (x - y_i rz, y + x_i rz, z + y_i rx - x_i ry)."""
    along, across, up = np.zeros((3, 4, 6))
    for i, (xi, yi) in enumerate(m.mounts):
        along[i, [0, 5]] = 1.0, -yi
        across[i, [1, 5]] = 1.0, xi
        up[i, [2, 3, 4]] = 1.0, yi, -xi
    return along, across, up


def mass_matrix(m: LinearMachine) -> Real:
    """Mass matrix (6, 6) at the mount plane's centre: spatial inertia of the machine, plates on the feet's z."""
    cx, cy, cz = m.cg
    skew = m.mass * np.array([[0.0, -cz, cy], [cz, 0.0, -cx], [-cy, cx, 0.0]])
    inertia = np.diag(m.inertia) - skew @ skew / m.mass
    up = foot_maps(m)[2]
    return np.block([[m.mass * np.eye(3), -skew], [skew, inertia]]) + (up.T * _each(m.m_plate)) @ up


def _stiffness(m: LinearMachine) -> Real:
    """Stiffness (6, 6): membranes, and -m g h on rocking."""
    along, across, up = foot_maps(m)
    lateral = (along.T * _each(m.k_lat)) @ along + (across.T * _each(m.k_lat)) @ across
    topple = np.diag([0, 0, 0, 1, 1, 0]) * m.mass * m.gravity * m.cg[2]
    return lateral + (up.T * _each(m.K_L)) @ up - topple


def _damping(m: LinearMachine) -> Real:
    """Damping (6, 6) of the membranes."""
    along, across, up = foot_maps(m)
    lateral = (along.T * _each(m.c_lat)) @ along + (across.T * _each(m.c_lat)) @ across
    return lateral + (up.T * _each(m.C)) @ up


def state_space(m: LinearMachine) -> tuple[Real, Real, Real, Real]:
    """A (28, 28), B (28, 28), C (20, 28), D (20, 28) about rest at null spool; orders as STATES, INPUTS, OUTPUTS.

    Spool: eq. 1. Oil: V1,2/beta dP1,2 = +-K_Q x -+ A_p dx_p - 2 g0 P1,2 -+ cross (P1 - P2), whose half difference is
    eqs. 3 and 6 with K_C = g0 + cross. Motion: M qdd = -K q - D qd + ground terms + A_p (P1 - P2) on each foot.
    """
    along, across, up = foot_maps(m)
    area, middle, bulk = _each(m.A_p), _each(m.V_t) / 2, _each(m.beta)
    inverse = np.linalg.inv(mass_matrix(m))
    q, qd, spool, rate, p1, p2 = (slice(a, b) for a, b in ((0, 6), (6, 12), (12, 16), (16, 20), (20, 24), (24, 28)))
    a, b = np.zeros((STATES, STATES)), np.zeros((STATES, INPUTS))
    a[q, qd] = np.eye(6)
    a[qd, q], a[qd, qd] = -inverse @ _stiffness(m), -inverse @ _damping(m)
    a[qd, p1] = inverse @ (up.T * area)
    a[qd, p2] = -a[qd, p1]
    a[spool, rate] = np.eye(4)
    a[rate, spool] = -np.diag(_each(m.omega_v) ** 2)
    a[rate, rate] = -np.diag(2 * _each(m.zeta) * _each(m.omega_v))
    b[rate, 0:4] = np.diag(_each(m.omega_v) ** 2 * _each(m.K_v))
    membranes = ((along, m.k_lat, m.c_lat), (across, m.k_lat, m.c_lat), (up, m.K_L, m.C))
    for axis, (feet, spring, damper) in enumerate(membranes):
        b[qd, 4 + axis : 16 : 3] = inverse @ (feet.T * _each(spring))
        b[qd, 16 + axis : 28 : 3] = inverse @ (feet.T * _each(damper))
    for own, other, sign in ((p1, p2, 1.0), (p2, p1, -1.0)):
        softness = bulk / (middle + sign * area * _each(m.stroke))
        a[own, spool] = np.diag(sign * softness * _each(m.K_Q))
        a[own, qd] = -sign * (softness * area)[:, None] * up
        a[own, own] = -np.diag(softness * (2 * _each(m.g0) + _each(m.cross)))
        a[own, other] = np.diag(softness * _each(m.cross))
        b[own, 18:28:3] = np.diag(sign * softness * area)
    c, d = np.zeros((OUTPUTS, STATES)), np.zeros((OUTPUTS, INPUTS))
    c[:12, :12] = np.eye(12)
    c[12:16, p1], c[12:16, p2] = np.eye(4), -np.eye(4)
    c[16:20, q] = up
    d[16:20, 6:16:3] = -np.eye(4)
    return a, b, c, d


def passive_modes(m: LinearMachine) -> Complex:
    """All 28 eigenvalues [rad/s] with the valves centred, by rising |lambda|. Frequency |lambda|/2 pi [Hz]."""
    values = np.linalg.eigvals(state_space(m)[0]).astype(complex)
    return values[np.lexsort((values.imag, np.round(np.abs(values), 6)))]


def oscillators(values: Complex) -> Real:
    """Oscillating modes (n, 2): natural frequency |lambda|/2 pi [Hz] and damping ratio -Re/|lambda|, by frequency."""
    upper = values[values.imag > 1e-3]
    table = np.stack([np.abs(upper) / (2 * np.pi), -upper.real / np.abs(upper)], axis=1)
    return table[np.argsort(table[:, 0])]


def transmissibility(m: LinearMachine, direction: str, hertz: float) -> Complex:
    """Complex amplitudes of q (6,) [m, rad] when a slab under all mounts moves by a unit sine in one of DOFS.

    The slab turns about the mount plane's centre, so rx and ry move the mounts by y_i and -x_i in z. Valves centred;
    hertz > 0. The oil is eliminated into each mount's vertical impedance, K_L + C s + A_p^2 s/(V_t s/(4 beta) + K_C)
    at stroke 0 (eqs. 3, 6, 7).
    """
    if direction not in DOFS:
        raise ValueError(f"direction {direction!r}: one of {', '.join(DOFS)}")
    s = 2j * np.pi * hertz
    area, leak, cross = _each(m.A_p), 2 * _each(m.g0), _each(m.cross)
    first, second = (
        s / _each(m.beta) * (_each(m.V_t) / 2 + sign * area * _each(m.stroke)) + leak + cross for sign in (1, -1)
    )
    oil = area**2 * s * (first + second - 2 * cross) / (first * second - cross**2)
    up = foot_maps(m)[2]
    topple = np.diag([0, 0, 0, 1, 1, 0]) * m.mass * m.gravity * m.cg[2]
    mounts = _stiffness(m) + topple + s * _damping(m) + (up.T * oil) @ up  # what the slab drives through
    unit = np.eye(6)[DOFS.index(direction)]
    return _complex(np.linalg.solve(s**2 * mass_matrix(m) + mounts - topple, mounts @ unit))
