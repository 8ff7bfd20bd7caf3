"""One integration of the reference model, from its static equilibrium and from event to event."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853, RK45
from scipy.integrate import OdeSolver as Solver
from scipy.optimize import brentq

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.scenario.model import Scenario
from ehamj.verify.reference.equations import constants, drive, rates
from ehamj.verify.reference.inputs import GRID, Array, SampledLaw, quintics_of


@dataclass(frozen=True)
class ReferenceRun:
    """A run of n mounts: q (rows, 6) in the order x, y, z, rx, ry, rz, spool (rows, n) [mA], pressure states
    (rows, n, 2) [Pa] and the supply's pressure (rows,) [Pa]; the number of steps, and of changes of mode."""

    q: Array
    spool: Array
    pressure: Array
    supply: Array
    steps: int
    switches: int


def simulate_reference(scenario: Scenario, rtol: float = 1e-9) -> ReferenceRun:
    """Run a scenario from its static equilibrium and report at its recording times.

    Raises:
        ValueError: for what this model does not have: settings of `ehamj.verify.reference.equations.constants`,
            channels other than of ground and pressure, laws of several rates, sensors, forces on the machine.
        RuntimeError: if SciPy gives up, or no equilibrium is found.
    """
    law = scenario.controller()
    if law is not None and not isinstance(law, Controller):
        raise ValueError("the reference model has laws of one rate only")
    if scenario.force:
        raise ValueError("the reference model has no forces on the machine itself")
    if scenario.sensors != IDEAL:
        raise ValueError("the reference model has no sensors: it measures exactly")
    return _Run(scenario, law, rtol).run()


class _Run:
    """Constants, inputs, modes and the state on its way."""

    def __init__(self, scenario: Scenario, controller: Controller | None, rtol: float) -> None:
        plant = scenario.plant
        self.c, self.n = constants(plant), len(plant.mounts)
        self.law, self.rtol = SampledLaw(controller, plant) if controller else None, rtol
        rows = round(scenario.duration * scenario.record_rate) + 1
        self.times: Array = np.arange(rows, dtype=np.float64) / scenario.record_rate
        self.quintics, self.jumps = quintics_of(scenario)
        self.pressures, self.station = 12 + 2 * self.n, 12 + 4 * self.n
        # A small motion of each state: 0.1 µm, 10 µm/s, 1 mA, …; the absolute tolerance is rtol times this.
        small = np.repeat([1e-7, 1e-5, 1.0, 1e2, 1e4, 1e4, 1e-6, 1e4], [6, 6, self.n, self.n, 2 * self.n, 1, 1, 1])
        self.atol = rtol * small[: self.station + (3 if plant.supply.dynamic else 0)]
        self.held = np.zeros(self.n)
        start, isolators = self._mid_pressure(scenario), self.c.isolators
        limit = np.where(isolators["end_stops"] > 0.0, isolators["spool_stroke"], np.inf)
        self.modes = _Modes(start[12 : 12 + self.n], isolators["hysteresis"], limit, self._drives)
        self.y = self._equilibrium(start)
        self.first_step, self.steps = 1e-5, 0

    def rates(self, t: float, y: Array) -> Array:
        """Time derivative of the state."""
        out, modes = np.empty_like(y), self.modes
        rates(t, y, self.c, self.quintics, self.held, modes.side, modes.memory, modes.stopped, out)
        return out

    def _mid_pressure(self, scenario: Scenario) -> Array:
        """The machine in its place, spools where the first commands put them or they stuck, pressures in the middle."""
        isolators, supply = self.c.isolators, scenario.plant.supply
        volts = np.array([signal.sample(np.zeros(1), left=True).value[0] for signal in scenario.commands()])
        y = np.zeros(len(self.atol))
        limit = isolators["voltage_limit"]
        asked = isolators["valve_gain"] * np.clip(volts, -limit, limit)
        stuck = isolators["spool_stuck_at"] * isolators["spool_stroke"]
        y[12 : 12 + self.n] = np.where(isolators["spool_stuck"] != 0.0, stuck, asked)
        y[self.pressures : self.station] = 0.5 * (supply.pressure + supply.tank_pressure)
        if supply.dynamic:
            behind_pump = supply.pressure - 0.5 * supply.pump_droop
            y[self.station :] = behind_pump, 0.5 * supply.pump_flow, behind_pump
        return y

    def _equilibrium(self, y: Array) -> Array:
        """Newton's method on positions and pressures; least change where they are not determined."""
        size, grounds = len(y), 3 * self.n
        ground = self.quintics[0, :grounds].copy()
        self.quintics[0, :grounds, 1:] = 0.0  # the ground stands still while the machine finds its place
        unknown, balance = np.r_[0:6, self.pressures : size], np.r_[6:12, self.pressures : size]
        unit = np.repeat([1e-5, 1e6, 1e6, 1e-5, 1e6], [6, 2 * self.n, 1, 1, 1])[: len(unknown)]
        shifts = 1e-5 * unit[:, None] * np.eye(size)[unknown]
        for _ in range(80):
            residual = self.rates(0.0, y)[balance]
            ahead, behind = (np.array([self.rates(0.0, y + way * shift) for shift in shifts]) for way in (1.0, -1.0))
            jacobian = (ahead - behind).T[balance] / 2e-5
            row = np.abs(jacobian).max(axis=1)
            change = np.linalg.lstsq(jacobian / row[:, None], -residual / row, rcond=1e-12)[0]
            y[unknown] += unit * np.clip(change, -1.0, 1.0)
            if np.abs(change).max() < 1e-12:
                break
        if np.abs(change).max() >= 1e-8:
            raise RuntimeError(f"no equilibrium: the last change was {np.abs(change).max():.2g}")
        self.quintics[0, :grounds] = ground
        return y

    def run(self) -> ReferenceRun:
        """Integrate from time to time at which something is recorded, sampled, commanded or jumps."""
        rows = [self.y.copy()]
        for begin, finish in self._pieces(self.times[-1]):
            if self.law is not None:
                self.held = self.law.at(begin, self._ground_velocity)
            self._integrate(begin, finish)
            if np.abs(self.times[len(rows)] - finish) < 1e-9:
                rows.append(self.y.copy())
        ends = [6, 12, 12 + self.n, self.pressures, self.station]
        q, _, spool, _, pressure, station = np.split(np.array(rows), ends, axis=1)
        pressure = pressure.reshape(-1, self.n, 2)
        supply = station[:, 2] if station.size else np.full(len(rows), self.c.supply["pressure"][0])
        return ReferenceRun(q, spool, pressure, supply, self.steps, self.modes.switches)

    def _pieces(self, end: float) -> list[tuple[float, float]]:
        parts = [self.times, self.jumps]
        if self.law is not None:
            period = self.law.controller.period
            samples: Array = period * np.arange(round(end / period) + 1, dtype=np.float64)
            parts += [samples, samples + self.law.controller.latency]
        edges = np.unique(np.round(np.concatenate(parts), 12))
        edges = edges[(edges >= 0.0) & (edges <= end + 1e-12)]
        return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))

    def _ground_velocity(self, t: float) -> Array:
        """Velocity of the ground at a time on the grid (mount, axis) [m/s]."""
        piece = min(int(t / GRID + 0.5), len(self.quintics) - 1)
        return self.quintics[piece, : 3 * self.n, 1].reshape(self.n, 3) / GRID

    def _integrate(self, begin: float, end: float) -> None:
        """Advance the state; where a mode ends, the integration starts anew."""
        t, last = begin, end - 1e-12  # inputs that jump at the end belong to the next piece
        method = DOP853 if self.law is None else RK45  # between samples a step is short anyway, and half the stages do
        while t < end - 1e-11:
            if self.modes.any:
                self.modes.settle(t, self.y)
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
            if self.modes.any and (self.modes.guards(solver.t, solver.y) < 0.0).any():
                at, which = self.modes.first_event(solver)
                self.y = solver.dense_output()(at) if at > solver.t_old else solver.y_old.copy()
                self.modes.switch(which, at, self.y)
                return at
        self.y = solver.y
        return float(solver.t)

    def _drives(self, t: float, y: Array) -> Array:
        """Force of the solenoids over the spools' mass [mA/s²]."""
        piece = min(int(t / GRID), len(self.quintics) - 1)
        voltage = self.held + self.quintics[piece, 3 * self.n :] @ (t / GRID - piece) ** np.arange(6)
        return np.array([drive(self.c.isolators[i], y[12 + i], voltage[i]) for i in range(self.n)])


class _Modes:
    """Modes of play (``side``) and stops (``stopped``), −1, 0, 1 per valve, and where the edges rest (``memory``).

    Args:
        spools: at the start [mA]; edges begin as near to their centre as the play allows.
        play: between spool and edges [mA].
        limit: position of the stops, inf without [mA].
        drives: force over the spools' mass [mA/s²], of a time and a state.
    """

    def __init__(self, spools: Array, play: Array, limit: Array, drives: Callable[[float, Array], Array]) -> None:
        self.play, self.limit, self.drives = play, limit, drives
        self.memory = np.clip(0.0, spools - play / 2, spools + play / 2)
        self.side, self.stopped = np.zeros(len(spools)), np.zeros(len(spools))
        self.switches = 0

    @property
    def any(self) -> bool:
        """Whether there are modes at all."""
        return bool((self.play > 0).any() or np.isfinite(self.limit).any())

    def guards(self, t: float, y: Array) -> Array:
        """Guards of the play, then of the stops, negative where the present mode no longer holds."""
        n = len(self.play)
        x, v = y[12 : 12 + n], y[12 + n : 12 + 2 * n]
        loose = 0.5 * self.play - np.abs(x - self.memory) + 1e-10
        play = np.where(self.play == 0.0, np.inf, np.where(self.side == 0.0, loose, self.side * v + 1e-6))
        free = self.limit - np.abs(x) + 1e-10
        if not self.stopped.any():
            return np.concatenate([play, free])
        return np.concatenate([play, np.where(self.stopped == 0.0, free, self.stopped * self.drives(t, y) + 1e-3)])

    def first_event(self, solver: Solver) -> tuple[float, int]:
        """Time at which the first guard becomes zero within the solver's last step, and which."""
        dense = solver.dense_output()
        points = np.linspace(solver.t_old, solver.t, 9)
        values = np.array([self.guards(t, dense(t)) for t in points])
        found = []
        for k in np.flatnonzero((values < 0.0).any(axis=0)):
            n = int(np.argmax(values[:, k] < 0.0))
            root = solver.t_old
            if n > 0:
                root = brentq(lambda t, k=k: self.guards(t, dense(t))[k], points[n - 1], points[n], xtol=1e-14)
            found.append((float(root), int(k)))
        return min(found)

    def switch(self, which: int, t: float, y: Array) -> None:
        """Change the mode whose guard has become zero; a spool that meets a stop stays there (no bounce)."""
        self.switches += 1
        n = len(self.play)
        i = which % n
        x, v = y[12 + i], y[12 + n + i]
        if which < n and self.side[i] == 0.0:
            self.side[i] = math.copysign(1.0, x - self.memory[i])
        elif which < n:
            self.memory[i], self.side[i] = x - self.side[i] * 0.5 * self.play[i], 0.0
        elif self.stopped[i] != 0.0:
            self.stopped[i] = 0.0
        else:
            y[12 + i] = math.copysign(self.limit[i], x)
            if x * v > 0.0:
                y[12 + n + i] = 0.0
            if x * self.drives(t, y)[i] > 0.0:
                self.stopped[i] = math.copysign(1.0, x)

    def settle(self, t: float, y: Array) -> None:
        """End the modes that a jump of the command ends at once."""
        self.stopped[self.stopped * self.drives(t, y) < 0.0] = 0.0
