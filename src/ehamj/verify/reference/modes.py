"""Play between spool and metering edges, and the spool's end stops, as modes whose ends are found as roots."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolver as Solver
from scipy.optimize import brentq

Array = NDArray[np.float64]


class Modes:
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
            if n == 0:
                found.append((float(solver.t_old), int(k)))
                continue
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
