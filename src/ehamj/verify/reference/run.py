"""One integration of the reference model, from its static equilibrium and from event to event."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, RK45
from scipy.integrate import OdeSolver as Solver

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.scenario.model import Scenario
from ehamj.verify.reference.constants import constants
from ehamj.verify.reference.equations import drive, rates
from ehamj.verify.reference.inputs import GRID, SampledLaw, quintics_of
from ehamj.verify.reference.modes import Modes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReferenceRun:
    """A run of n mounts: time (rows,) [s], q and its rate (rows, 6) in the order x, y, z, rx, ry, rz, spool (rows, n)
    [mA], pressure states (rows, n, 2) [Pa] and the supply's pressure (rows,) [Pa]; the number of steps, and of changes
    of mode."""

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
        ValueError: for what this model does not have: settings of `ehamj.verify.reference.constants.constants`,
            channels other than of ground and pressure, laws of several rates, sensors, forces on the machine.
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
    """Constants, inputs, modes and the state on its way."""

    def __init__(self, scenario: Scenario, controller: Controller | None, rtol: float) -> None:
        plant = scenario.plant
        self.c, self.n = constants(plant), len(plant.mounts)
        self.controller, self.rtol = controller, rtol
        rows = round(scenario.duration * scenario.record_rate) + 1
        self.times: Array = np.arange(rows, dtype=np.float64) / scenario.record_rate
        self.quintics, self.jumps = quintics_of(scenario)
        self.pressures, self.station = 12 + 2 * self.n, 12 + 4 * self.n
        size = self.station + (3 if self.c.supply.size else 0)
        # A small motion of each state: 0.1 µm, 10 µm/s, 1 mA, …; the absolute tolerance is rtol times this.
        small = [1e-7, 1e-5, 1.0, 1e2, 1e4, 1e4, 1e-6, 1e4]
        self.atol = rtol * np.repeat(small, [6, 6, self.n, self.n, 2 * self.n, 1, 1, 1])[:size]
        self.held = np.zeros(self.n)
        stops = np.array([actuator.end_stops for actuator in plant.actuators])
        start = self._mid_pressure(scenario, size)
        limit = np.where(stops, self.c.stroke, np.inf)
        self.modes = Modes(start[12 : 12 + self.n], self.c.play, limit, self._drives)
        self.y = self._equilibrium(start)
        self.law = SampledLaw(controller, plant.mounts) if controller else None
        self.first_step, self.steps = 1e-5, 0

    def rates(self, t: float, y: Array) -> Array:
        """Time derivative of the state."""
        out, modes = np.empty_like(y), self.modes
        rates(t, y, self.c, self.quintics, self.held, modes.side, modes.memory, modes.stopped, out)
        return out

    def _mid_pressure(self, scenario: Scenario, size: int) -> Array:
        """The machine in its place, spools where the first commands put them, every pressure in the middle."""
        c, start = self.c, np.zeros(1)
        volts = np.array([signal.sample(start, left=True).value[0] for signal in scenario.commands()])
        y = np.zeros(size)
        y[12 : 12 + self.n] = c.K_v * np.clip(volts, -c.v_max, c.v_max)
        y[self.pressures : self.station] = 0.5 * (c.P_s + c.P_t)
        if size > self.station:
            behind_pump = c.P_s - 0.5 * c.supply[1] / c.supply[0]
            y[self.station :] = behind_pump, 0.5 * c.supply[1], behind_pump
        return y

    def _equilibrium(self, y: Array) -> Array:
        """Newton's method on positions and pressures; least change where they are not determined."""
        size, grounds = len(y), 3 * self.n
        ground = self.quintics[0, :grounds].copy()
        self.quintics[0, :grounds, 1:] = 0.0  # the ground stands still while the machine finds its place
        unknown, balance = np.r_[0:6, self.pressures : size], np.r_[6:12, self.pressures : size]
        station = np.array([1e6, 1e-5, 1e6])[: size - self.station]
        unit = np.r_[np.full(6, 1e-5), np.full(2 * self.n, 1e6), station]
        change = np.full(len(unknown), np.inf)
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
                break
        if np.abs(change).max() >= 1e-8:
            raise RuntimeError(f"no equilibrium: the last change was {np.abs(change).max():.2g}")
        self.quintics[0, :grounds] = ground
        return y

    def run(self) -> ReferenceRun:
        """Integrate from time to time at which something is recorded, sampled, commanded or jumps."""
        end = self.times[-1]
        rows = [self.y.copy()]
        for begin, finish in self._pieces(end):
            if self.law is not None:
                self.held = self.law.at(begin, self._ground_velocity)
            self._integrate(begin, finish)
            if np.abs(self.times[len(rows)] - finish) < 1e-9:
                rows.append(self.y.copy())
        states, n = np.array(rows), self.n
        pressure = states[:, self.pressures : self.station].reshape(-1, n, 2)
        supply = states[:, self.station + 2] if self.c.supply.size else np.full(len(states), self.c.P_s)
        return ReferenceRun(
            self.times, states[:, :6], states[:, 6:12], states[:, 12 : 12 + n], pressure, supply, self.steps,
            self.modes.switches,
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
        return self.quintics[piece, : 3 * self.n, 1].reshape(self.n, 3) / GRID

    def _integrate(self, begin: float, end: float) -> None:
        """Advance the state; where a mode ends, the integration starts anew."""
        t, last = begin, end - 1e-12  # inputs that jump at the end belong to the next piece
        while t < end - 1e-11:
            if self.modes.any:
                self.modes.settle(t, self.y)
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
        return np.array([drive(self.c, i, y[12 + i], voltage[i]) for i in range(self.n)])
