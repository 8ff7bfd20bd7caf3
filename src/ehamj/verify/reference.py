"""The whole nonlinear machine with every hydraulic option, integrated by SciPy: an independent model.

It shares its input with `ehamj.simulate` (parameters, ground, commands, control law) and no equation: the rigid body
has linearised kinematics with gravity's geometric term, written as matrices; SciPy's Runge–Kutta with error control
takes it from sample to sample of the controller; play between spool and metering edges and the spool's end stops are
modes whose ends are found as roots. The right-hand side is compiled for speed only.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, RK45
from scipy.integrate import OdeSolver as Solver
from scipy.optimize import brentq

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.plant.axes import AXES
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]

ATMOSPHERE = 101325.0
"""Pressure at which the air fraction and the walls' stretch are stated [Pa]."""

GRID = 5e-5
"""Spacing at which ground and commands are taken from the scenario [s]; between, quintics with both derivatives."""

SPOOL, RATE, PRESSURE, STATION = 12, 16, 20, 28
"""Where the state holds spools [mA], their rates, pressures (mount, chamber) [Pa] and the supply; q, q̇ come first."""

SCALE = np.repeat([1e-7, 1e-5, 1.0, 1e2, 1e4, 1e4, 1e-6, 1e4], [6, 6, 4, 4, 8, 1, 1, 1])
"""A small motion of each state (as above; 0.1 µm, 10 µm/s, 1 mA, …): the absolute tolerance is rtol times this."""


class Constants(NamedTuple):
    """The equations' constants; one entry per mount where not said otherwise. SI, spool in mA."""

    inverse_mass: Array  # (6, 6)
    feet: Array  # motion of each foot per coordinate (mount, axis, 6)
    stiffness: Array  # membranes (mount, axis)
    damping: Array
    weight: Array  # generalised (6,)
    topple: Array  # m g h on rocking (6,)
    area: Array  # (mount, chamber)
    volume: Array
    moves: Array
    beta: Array
    vapour: Array
    air: Array
    exponent: Array
    wall: Array  # 1/β_w
    K_Q: Array
    g0: Array
    cross: Array
    eps: Array
    laps: Array  # (mount, edge)
    offset: Array
    play: Array
    stroke: Array
    curve: Array  # (mount, 2, points): positions and flows as shares
    K_v: Array
    v_max: Array
    omega: Array
    zeta: Array
    a_max: Array
    threshold: Array
    P_s: float
    P_t: float
    supply: Array  # conductance, limit, V0, p0, n, R, L, Vm, β; empty: the supply holds


def constants(plant: Plant) -> Constants:
    """The constants of a plant.

    Raises:
        ValueError: for feet with stiffness, which this model does not have.
    """
    if not all(actuator.rigid_foot for actuator in plant.actuators):
        raise ValueError("the reference model has rigid feet")
    x, y = np.array(plant.positions).T
    o, i = np.zeros(4), np.ones(4)
    feet = np.array([[i, o, o, o, o, -y], [o, i, o, o, o, x], [o, o, i, y, -x, o]]).transpose(2, 0, 1)
    cx, cy, h = plant.machine.cg
    cg = np.array([[1, 0, 0, 0, h, -cy], [0, 1, 0, -h, 0, cx], [0, 0, 1, cy, -cx, 0]], float)
    m, g, supply = plant.machine.mass, plant.gravity, plant.supply

    def each(name: str) -> Array:
        return np.array([getattr(a, name) for a in plant.actuators], float)

    plates, up = each("plate_mass"), feet[:, 2]
    mass = m * cg.T @ cg + up.T @ (plates[:, None] * up)
    mass[3:, 3:] += np.diag(plant.machine.inertia)
    share, leak = each("volume_share"), each("flow_pressure") * each("edge_leakage_share")
    points = max((len(a.flow_curve) for a in plant.actuators), default=0)
    curve = np.zeros((4, 2, max(points, 2)))
    for k, actuator in enumerate(plant.actuators):
        pairs = np.array(actuator.flow_curve or ((0.0, 0.0), (1.0, 1.0))).T
        curve[k] = np.pad(pairs, ((0, 0), (0, curve.shape[2] - pairs.shape[1])), mode="edge")
    line = supply.line_diameter
    shared = [
        supply.pump_flow / supply.pump_droop,
        supply.pump_flow,
        supply.accumulator_volume,
        supply.accumulator_precharge,
        supply.accumulator_exponent,
        128.0 * supply.oil_viscosity * supply.line_length / (math.pi * line**4),
        4.0 * supply.oil_density * supply.line_length / (math.pi * line**2),
        supply.manifold_volume,
        supply.oil_modulus,
    ]
    return Constants(
        inverse_mass=np.linalg.inv(mass),
        feet=np.ascontiguousarray(feet),
        stiffness=np.stack([each("lateral_stiffness")] * 2 + [each("membrane_stiffness")], axis=1),
        damping=np.stack([each("lateral_damping")] * 2 + [each("membrane_damping")], axis=1),
        weight=-g * (m * cg[2] + plates @ up),
        topple=m * g * h * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]),
        area=np.stack([each("piston_area"), each("piston_area") * each("area_ratio")], axis=1),
        volume=each("chamber_volume")[:, None] * np.stack([share, 1.0 - share], axis=1),
        moves=each("moving_volume"),
        beta=each("bulk_modulus"),
        vapour=each("vapour_pressure"),
        air=each("air_fraction"),
        exponent=each("polytropic_exponent"),
        wall=1.0 / each("wall_modulus"),
        K_Q=each("flow_gain"),
        g0=leak,
        cross=each("flow_pressure") - leak,
        eps=each("laminar_ratio"),
        laps=np.array([a.overlap for a in plant.actuators], float),
        offset=each("null_offset"),
        play=each("hysteresis"),
        stroke=each("spool_stroke"),
        curve=curve,
        K_v=each("valve_gain"),
        v_max=each("voltage_limit"),
        omega=each("valve_frequency"),
        zeta=each("valve_damping"),
        a_max=each("spool_drive_limit"),
        threshold=each("threshold"),
        P_s=supply.pressure,
        P_t=supply.tank_pressure,
        supply=np.array(shared if supply.dynamic else []),
    )


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    return numba.njit(error_model="numpy", cache=True)(function)


@_compiled
def _edge(gain, opening, drop, rated, eps, leakage):  # type: ignore[no-untyped-def]
    """Flow over one edge: K_Q·opening·φ(Δp/Δp₀) and a laminar leak."""
    r = drop / rated
    root = (r * r + eps * eps) ** 0.25
    turbulent = gain * opening * r / root if root > 0.0 else 0.0
    return turbulent + leakage * drop


@_compiled
def _drive(c, i, spool, voltage):  # type: ignore[no-untyped-def]
    """Force of the solenoid over the spool's mass [mA/s²]."""
    error = c.K_v[i] * max(-c.v_max[i], min(c.v_max[i], voltage)) - spool
    if abs(error) <= c.threshold[i]:
        return 0.0
    error -= math.copysign(c.threshold[i], error)
    return max(-c.a_max[i], min(c.a_max[i], c.omega[i] ** 2 * error))


@_compiled
def _modulus(c, i, p):  # type: ignore[no-untyped-def]
    """Bulk modulus of liquid with polytropic air at the pressure p: harmonic by volume."""
    if c.air[i] == 0.0:
        return c.beta[i]
    liquid = (1.0 - c.air[i]) * math.exp(-(p - ATMOSPHERE) / c.beta[i])
    gas = c.air[i] * (ATMOSPHERE / p) ** (1.0 / c.exponent[i])
    share = gas / (liquid + gas)
    return 1.0 / ((1.0 - share) / c.beta[i] + share / (c.exponent[i] * p))


@_compiled
def _rates(t, y, c, quintics, held, side, memory, stopped, out):  # type: ignore[no-untyped-def]
    """Time derivative of the state; ``held`` [V] comes from a controller, the modes from the integration."""
    piece = min(max(int(t / GRID), 0), quintics.shape[0] - 1)
    s = t / GRID - piece
    force = c.weight + c.topple * y[:6]
    total_drawn = 0.0
    shared = c.supply.size > 0
    supply = y[30] if shared else c.P_s
    rated = 0.5 * (c.P_s - c.P_t)
    for i in range(4):
        for axis in range(3):
            k = quintics[piece, 3 * i + axis]
            moved = ((((k[5] * s + k[4]) * s + k[3]) * s + k[2]) * s + k[1]) * s + k[0]
            moving = ((((5 * k[5] * s + 4 * k[4]) * s + 3 * k[3]) * s + 2 * k[2]) * s + k[1]) / GRID
            offset, speed = -moved, -moving
            for j in range(6):
                offset += c.feet[i, axis, j] * y[j]
                speed += c.feet[i, axis, j] * y[6 + j]
            push = -c.stiffness[i, axis] * offset - c.damping[i, axis] * speed
            if axis == 2:
                p1, p2 = max(y[20 + 2 * i], c.vapour[i]), max(y[21 + 2 * i], c.vapour[i])
                push += c.area[i, 0] * p1 - c.area[i, 1] * p2
            for j in range(6):
                force[j] += c.feet[i, axis, j] * push
        # offset and speed are now those of the stroke
        k = quintics[piece, 12 + i]
        voltage = held[i] + ((((k[5] * s + k[4]) * s + k[3]) * s + k[2]) * s + k[1]) * s + k[0]
        spool, rate = y[12 + i], y[16 + i]
        if stopped[i] != 0.0:
            out[12 + i] = out[16 + i] = 0.0
        else:
            out[12 + i] = rate
            out[16 + i] = _drive(c, i, spool, voltage) - 2.0 * c.zeta[i] * c.omega[i] * rate
        edge = memory[i] if side[i] == 0.0 and c.play[i] > 0.0 else spool - side[i] * 0.5 * c.play[i]
        opening = max(-c.stroke[i], min(c.stroke[i], edge + c.offset[i]))
        share = np.interp(abs(opening) / c.stroke[i], c.curve[i, 0], c.curve[i, 1])
        opening = math.copysign(share * c.stroke[i], opening)
        e0 = min(max(opening - c.laps[i, 0], 0.0), c.stroke[i])
        e1 = min(max(-opening - c.laps[i, 1], 0.0), c.stroke[i])
        e2 = min(max(-opening - c.laps[i, 2], 0.0), c.stroke[i])
        e3 = min(max(opening - c.laps[i, 3], 0.0), c.stroke[i])
        from_1 = _edge(c.K_Q[i], e0, supply - p1, rated, c.eps[i], c.g0[i])
        to_1 = _edge(c.K_Q[i], e1, p1 - c.P_t, rated, c.eps[i], c.g0[i])
        from_2 = _edge(c.K_Q[i], e2, supply - p2, rated, c.eps[i], c.g0[i])
        to_2 = _edge(c.K_Q[i], e3, p2 - c.P_t, rated, c.eps[i], c.g0[i])
        across = c.cross[i] * (p1 - p2)
        total_drawn += from_1 + from_2
        for chamber in range(2):
            p = p1 if chamber == 0 else p2
            flow = from_1 - to_1 - across if chamber == 0 else from_2 - to_2 + across
            sign = 1.0 if chamber == 0 else -1.0
            state = y[20 + 2 * i + chamber]
            stretch = 1.0 + (state - ATMOSPHERE) * c.wall[i]
            volume = c.volume[i, chamber] + sign * c.moves[i] * c.area[i, chamber] * offset
            # compliance of oil and walls at this pressure [m³/Pa]
            compliance = volume * (stretch / _modulus(c, i, p) + c.wall[i])
            # Below the vapour pressure the state stands for a void: p_v − p = −β ln(share that is oil). What the oil's
            # volume gains must be the flow, so that the flow counts more the less oil there is.
            filled = math.exp(min(state - c.vapour[i], 0.0) / _modulus(c, i, p))
            out[20 + 2 * i + chamber] = (flow / filled - stretch * sign * c.area[i, chamber] * speed) / compliance
    out[:6] = y[6:12]
    out[6:12] = c.inverse_mass @ force
    if shared:
        conductance, limit, gas, precharge, n, resistance, inertance, manifold, beta = c.supply
        pump = min(max(conductance * (c.P_s - y[28]), 0.0), limit)
        volume = gas * (precharge / y[28]) ** (1.0 / n)
        out[28] = n * y[28] / volume * (pump - y[29])
        out[29] = (y[28] - y[30] - resistance * y[29]) / inertance
        out[30] = beta / manifold * (y[29] - total_drawn)


@dataclass(frozen=True)
class ReferenceRun:
    """A run: time (n,) [s], q and its rate (n, 6) in the order x, y, z, rx, ry, rz, spool (n, 4) [mA], pressure states
    (n, 4, 2) [Pa] and the supply's pressure (n,) [Pa]; the number of steps, and of changes of mode."""

    time: Array
    q: Array
    rate: Array
    spool: Array
    pressure: Array
    supply: Array
    steps: int
    switches: int


def simulate_reference(scenario: Scenario, rtol: float = 1e-9, controller: Controller | None = None) -> ReferenceRun:
    """Run a scenario from its static equilibrium and report at its recording times.

    Raises:
        ValueError: for what this model does not have: feet with stiffness, channels other than of ground and pressure,
            laws of several rates, sensors, forces on the machine.
        RuntimeError: if SciPy gives up, or no equilibrium is found.
    """
    law = scenario.controller() if controller is None else controller
    if law is not None and not isinstance(law, Controller):
        raise ValueError("the reference model has laws of one rate only")
    if scenario.force:
        raise ValueError("the reference model has no forces on the machine itself")
    if scenario.sensors != IDEAL:
        raise ValueError("the reference model has no sensors: it measures exactly")
    return _Run(scenario, law, rtol).run()


class _Run:
    """One integration: constants, inputs, and the modes of play and stops (−1, 0, 1 per valve)."""

    def __init__(self, scenario: Scenario, controller: Controller | None, rtol: float) -> None:
        self.c = constants(scenario.plant)
        self.controller, self.rtol = controller, rtol
        rows = round(scenario.duration * scenario.record_rate) + 1
        self.times: Array = np.arange(rows, dtype=np.float64) / scenario.record_rate
        self.quintics, self.jumps = _inputs(scenario)
        size = 31 if self.c.supply.size else 28
        self.atol = rtol * SCALE[:size]
        self.held, self.side, self.stopped = np.zeros(4), np.zeros(4), np.zeros(4)
        stops = np.array([actuator.end_stops for actuator in scenario.plant.actuators])
        self.limit = np.where(stops, self.c.stroke, np.inf)
        self.y = self._equilibrium(scenario, size)
        self.law = _Law(controller) if controller else None
        self.first_step, self.steps, self.switches = 1e-5, 0, 0

    @cached_property
    def hybrid(self) -> bool:
        """Whether there are modes at all."""
        return bool((self.c.play > 0).any() or np.isfinite(self.limit).any())

    def rates(self, t: float, y: Array) -> Array:
        """Time derivative of the state."""
        out = np.empty_like(y)
        _rates(t, y, self.c, self.quintics, self.held, self.side, self.memory, self.stopped, out)
        return out

    def _equilibrium(self, scenario: Scenario, size: int) -> Array:
        """Newton's method on positions and pressures from mid pressure; least change where they are not determined."""
        c, start = self.c, np.zeros(1)
        volts = np.array([signal.sample(start, left=True).value[0] for signal in scenario.commands()])
        y = np.zeros(size)
        y[SPOOL:RATE] = c.K_v * np.clip(volts, -c.v_max, c.v_max)
        self.memory = np.clip(0.0, y[SPOOL:RATE] - c.play / 2, y[SPOOL:RATE] + c.play / 2)
        y[PRESSURE:STATION] = 0.5 * (c.P_s + c.P_t)
        if size > STATION:
            y[28:] = c.P_s - 0.5 * c.supply[1] / c.supply[0], 0.5 * c.supply[1], c.P_s - 0.5 * c.supply[1] / c.supply[0]
        ground = self.quintics[0, :12].copy()
        self.quintics[0, :12, 1:] = 0.0  # the ground stands still while the machine finds its place
        unknown = np.r_[0:6, PRESSURE:size]
        balance = np.r_[6:12, PRESSURE:size]
        unit = np.r_[np.full(6, 1e-5), np.full(8, 1e6), np.array([1e6, 1e-5, 1e6])[: size - STATION]]
        for _ in range(80):
            residual = self.rates(0.0, y)[balance]
            jacobian = np.empty((balance.size, unknown.size))
            for column, k in enumerate(unknown):
                shift = np.zeros(size)
                shift[k] = 1e-5 * unit[column]
                ahead, behind = self.rates(0.0, y + shift), self.rates(0.0, y - shift)
                jacobian[:, column] = (ahead - behind)[balance] / 2e-5
            row = np.abs(jacobian).max(axis=1)
            change = np.linalg.lstsq(jacobian / row[:, None], -residual / row, rcond=1e-12)[0]
            y[unknown] += unit * np.clip(change, -1.0, 1.0)
            if np.abs(change).max() < 1e-12:
                self.quintics[0, :12] = ground
                return y
        if np.abs(change).max() < 1e-8:
            self.quintics[0, :12] = ground
            return y
        raise RuntimeError(f"no equilibrium: the last change was {np.abs(change).max():.2g}")

    def run(self) -> ReferenceRun:
        """Integrate from time to time at which something is recorded, sampled, commanded or jumps."""
        end = self.times[-1]
        rows = [self.y.copy()]
        for begin, finish in self._pieces(end):
            if self.law is not None:
                self.held = self.law.at(begin, lambda at, y=self.y: self._ground_velocity(at))  # type: ignore[misc]
            self._integrate(begin, finish)
            if np.abs(self.times[len(rows)] - finish) < 1e-9:
                rows.append(self.y.copy())
        states = np.array(rows)
        pressure = states[:, PRESSURE:STATION].reshape(-1, 4, 2)
        supply = states[:, 30] if states.shape[1] > STATION else np.full(len(states), self.c.P_s)
        return ReferenceRun(
            self.times, states[:, :6], states[:, 6:12], states[:, SPOOL:RATE], pressure, supply, self.steps,
            self.switches,
        )  # fmt: skip

    def _pieces(self, end: float) -> list[tuple[float, float]]:
        parts = [self.times, self.jumps]
        if self.controller is not None:
            count = round(end / self.controller.period) + 1
            samples: Array = np.arange(count, dtype=np.float64) * self.controller.period
            parts += [samples, samples + self.controller.latency]
        edges = np.unique(np.round(np.concatenate(parts), 12))
        edges = edges[(edges >= 0.0) & (edges <= end + 1e-12)]
        return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))

    def _ground_velocity(self, t: float) -> Array:
        """Velocity of the ground at a time on the grid (mount, axis) [m/s]."""
        piece = min(int(t / GRID + 0.5), len(self.quintics) - 1)
        return self.quintics[piece, :12, 1].reshape(4, 3) / GRID

    def _integrate(self, begin: float, end: float) -> None:
        """Advance the state; where a mode ends, the integration starts anew."""
        t, last = begin, end - 1e-12  # inputs that jump at the end belong to the next piece
        while t < end - 1e-11:
            if self.hybrid:
                self._settle(t)
            # Between samples a step is short anyway, and half the stages do.
            method = DOP853 if self.law is None else RK45
            solver = method(
                lambda at, y: self.rates(min(at, last), y), t, self.y, end, rtol=self.rtol, atol=self.atol,
                first_step=min(self.first_step, end - t),
            )  # fmt: skip
            t = self._advance(solver)

    def _advance(self, solver: Solver) -> float:
        """Step to the solver's end or the first change of mode; returns the time reached."""
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(f"the reference stopped at {solver.t} s: {message}")
            self.steps += 1
            if solver.h_abs > 0 and solver.status == "running":
                self.first_step = solver.h_abs
            if self.hybrid and (self._guards(solver.t, solver.y) < 0.0).any():
                at, which = self._first_event(solver)
                self.y = solver.dense_output()(at) if at > solver.t_old else solver.y_old.copy()
                self._switch(which, at)
                return at
        self.y = solver.y
        return float(solver.t)

    def _drives(self, t: float, y: Array) -> Array:
        k = self.quintics[min(int(t / GRID), len(self.quintics) - 1), 12:]
        s = t / GRID - min(int(t / GRID), len(self.quintics) - 1)
        voltage = self.held + k @ s ** np.arange(6)
        return np.array([_drive(self.c, i, y[SPOOL + i], voltage[i]) for i in range(4)])

    def _guards(self, t: float, y: Array) -> Array:
        """Four guards of the play, four of the stops, negative where the present mode no longer holds."""
        c, x, v = self.c, y[SPOOL:RATE], y[RATE:PRESSURE]
        loose = 0.5 * c.play - np.abs(x - self.memory) + 1e-10
        play = np.where(c.play == 0.0, np.inf, np.where(self.side == 0.0, loose, self.side * v + 1e-6))
        free = self.limit - np.abs(x) + 1e-10
        if not self.stopped.any():
            return np.concatenate([play, free])
        return np.concatenate([play, np.where(self.stopped == 0.0, free, self.stopped * self._drives(t, y) + 1e-3)])

    def _first_event(self, solver: Solver) -> tuple[float, int]:
        dense = solver.dense_output()
        points = np.linspace(solver.t_old, solver.t, 9)
        values = np.array([self._guards(t, dense(t)) for t in points])
        found = []
        for k in np.flatnonzero((values < 0.0).any(axis=0)):
            n = int(np.argmax(values[:, k] < 0.0))
            if n == 0:
                found.append((float(solver.t_old), int(k)))
                continue
            root = brentq(lambda t, k=k: self._guards(t, dense(t))[k], points[n - 1], points[n], xtol=1e-14)
            found.append((float(root), int(k)))
        return min(found)

    def _switch(self, which: int, t: float) -> None:
        """Change the mode whose guard has become zero."""
        self.switches += 1
        i, y = which % 4, self.y
        x, v = y[SPOOL + i], y[RATE + i]
        if which < 4 and self.side[i] == 0.0:
            self.side[i] = math.copysign(1.0, x - self.memory[i])
        elif which < 4:
            self.memory[i], self.side[i] = x - self.side[i] * 0.5 * self.c.play[i], 0.0
        elif self.stopped[i] != 0.0:
            self.stopped[i] = 0.0
        else:
            y[SPOOL + i] = math.copysign(self.limit[i], x)
            if x * v > 0.0:  # no bounce
                y[RATE + i] = 0.0
            if x * self._drives(t, y)[i] > 0.0:
                self.stopped[i] = math.copysign(1.0, x)

    def _settle(self, t: float) -> None:
        """Modes that a jump of the command ends at once."""
        drives = self._drives(t, self.y)
        self.stopped[self.stopped * drives < 0.0] = 0.0


class _Law:
    """The sampled law: what its commands are at a time, [V]; measured are velocities of the ground."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.state = np.zeros(controller.A.shape[0])
        self.waiting: list[tuple[float, Array]] = []
        self.command, self.count = np.zeros(4), 0
        self.places = []
        for name in controller.inputs:
            what, mount, axis = name.split(" ")
            if what != "ground_velocity":
                raise ValueError(f"the reference model measures ground_velocity, not {name!r}")
            self.places.append((MOUNTS.index(mount), AXES.index(axis)))

    def at(self, t: float, ground_velocity: Callable[[float], Array]) -> Array:
        """Take a sample if its time has come, and release what has waited long enough."""
        law = self.controller
        if t > self.count * law.period - 1e-10:
            velocity = ground_velocity(t)
            u = np.array([velocity[place] for place in self.places])
            wanted = law.C @ self.state + law.D @ u
            volts = np.clip(_share(law, t) * wanted, -law.voltage_limit, law.voltage_limit)
            missing = volts - wanted
            if law.bits is not None:
                lsb = 2.0 * law.voltage_limit / 2**law.bits
                volts = lsb * np.floor(volts / lsb + 0.5)
            self.state = law.A @ self.state + law.B @ u
            if law.anti_windup is not None:
                self.state = self.state + law.anti_windup @ missing
            self.waiting.append((t + law.latency, volts))
            self.count += 1
        while self.waiting and self.waiting[0][0] < t + 1e-10:
            self.command = self.waiting.pop(0)[1]
        return self.command


def _share(law: Controller, t: float) -> float:
    """Share of the law's output that reaches the valves: none before switch-on, then along 3s² − 2s³."""
    if t < law.switch_on - 1e-10:
        return 0.0
    s = min((t - law.switch_on) / law.fade, 1.0) if law.fade > 0.0 else 1.0
    return 3.0 * s**2 - 2.0 * s**3


def _inputs(scenario: Scenario) -> tuple[Array, Array]:
    """Ground (12) and commands (4) as quintics on the grid, (pieces, 16, 6); and the times at which one jumps."""
    n = math.ceil(scenario.duration / GRID - 1e-9) + 1
    times: Array = np.arange(n + 1, dtype=np.float64) * GRID
    left, right = np.zeros((2, n + 1, 16, 3))
    ground = scenario.motion().sample(times)
    for order, part in enumerate(ground):
        left[:, :12, order] = right[:, :12, order] = part.reshape(-1, 12)
    for i, signal in enumerate(scenario.commands()):
        left[:, 12 + i] = np.array(signal.sample(times, left=True)).T
        right[:, 12 + i] = np.array(signal.sample(times)).T
    steps = GRID ** np.arange(3)
    (p0, v0, a0), (p1, v1, a1) = ((part * steps).transpose(2, 0, 1) for part in (right[:-1], left[1:]))
    rise, slope, bend = p1 - p0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
    quintics = [
        p0, v0, a0 / 2, 10 * rise - 4 * slope + bend / 2, -15 * rise + 7 * slope - bend, 6 * rise - 3 * slope + bend / 2
    ]  # fmt: skip
    jumps = times[np.abs(left - right)[:, :, 0].max(axis=1) > 0.0]
    return np.ascontiguousarray(np.stack(quintics, axis=2)), jumps
