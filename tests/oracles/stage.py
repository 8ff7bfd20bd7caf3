"""The stage that makes valves good, and the laws before it, in plain Python: roots where the stage has branches."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from ehamj.arrays import Array
from ehamj.control import Controller, ControllerBank
from ehamj.control.valves import KnownValve
from oracles.spools import PythonSpool
from oracles.stepped import STEP


@dataclass
class PythonStage:
    """The stage of one valve, from the equations in the docstrings, with roots where the stage has branches."""

    valve: KnownValve
    period: float

    def __post_init__(self) -> None:
        own = self.valve.numbers
        self.state, self.lag, self.lean, self.edges = np.zeros(2), np.zeros(2), 0.0, 0.0
        self.level, self.place = 1.0, 0.0
        self.spool_moves = self._held(own.valve_frequency, own.valve_damping)
        self.lag_moves = self._held(1.0 / own.rolloff, 1.0)

    def _held(self, natural: float, damping: float) -> Array:
        rates = np.array([[0.0, 1.0, 0.0], [-(natural**2), -2 * damping * natural, natural**2], [0.0, 0.0, 0.0]])
        return expm(rates * self.period)[:2]

    def factors(self, one: float, two: float, supply: float) -> Array:
        """φ of edges supply–1, 1–tank, supply–2, 2–tank, with their parts in what drives the piston."""
        own = self.valve.numbers
        shares = np.array([own.share, own.share, 1 - own.share, 1 - own.share])
        if own.least >= own.most:
            return shares
        ratio = np.array([supply - one, one - own.tank, supply - two, two - own.tank]) / own.rated
        return shares * np.clip(ratio / (ratio**2 + own.laminar**2) ** 0.25, own.least, own.most)

    def flow(self, z: float, factors: Array) -> float:
        own = self.valve.numbers
        beyond = np.array([z - own.supply_1, -z - own.tank_1, -z - own.supply_2, z - own.tank_2])
        return float(factors * np.array([1, -1, -1, 1]) @ np.maximum(beyond, 0.0))

    def opening(self, y: float, factors: Array) -> float:
        own = self.valve.numbers
        ahead, behind = min(own.supply_1, own.tank_2), -min(own.tank_1, own.supply_2)

        def root(low: float, high: float) -> float:
            return float(brentq(lambda z: self.flow(z, factors) - y, low, high, xtol=1e-15, rtol=1e-15))

        t = np.clip(self.place / own.band, -1, 1)
        spread = t * (3 - t**2) / 2
        if ahead < behind:
            z = root(-1e3, 1e3)
        else:
            excess = 0.0
            if y != 0.0:
                excess = root(ahead, 1e3) - ahead if y > 0 else root(-1e3, behind) - behind
            z = excess + (ahead + behind) / 2 + (ahead - behind) / 2 * spread
        if own.curved:
            z = float(np.copysign(self._on_curve(abs(z) / own.stroke) * own.stroke, z))
        return z

    def _on_curve(self, share: float) -> float:
        return share if share >= 1 else float(np.interp(share, self.valve.curve, np.linspace(0, 1, 11)))

    def reach(self, factors: Array, limit: float) -> tuple[float, float]:
        """Least and largest wanted voltage."""
        own = self.valve.numbers
        far, found = min(own.reach, own.valve_gain * limit) - own.play, []
        for position in (-far, far):
            x = np.clip(position + own.offset, -own.stroke, own.stroke)
            share = abs(x) / own.stroke
            flows = np.interp(share, np.linspace(0, 1, 11), self.valve.curve) if own.curved else share
            found.append(self.flow(float(np.copysign(flows * own.stroke, x)), factors) / own.valve_gain)
        return found[0], found[1]

    def added(self, volts: float, share: float, factors: Array) -> float:
        """What is added [V] to a wanted voltage that fade and range have taken from."""
        own = self.valve.numbers
        wanted = self.state[0] + 2 * own.rolloff * self.state[1]
        forgotten = np.exp(-self.period / 0.5)
        self.level = forgotten * self.level + (1 - forgotten) * wanted**2
        half = 3 * np.clip(2 * own.quiet - np.sqrt(self.level), 0, own.quiet)
        self.place = float(np.clip(self.place, wanted - half, wanted + half))
        edges = self.opening(wanted, factors)
        self.lean = float(np.clip(self.lean + (edges - self.edges) / own.reversal, -1, 1))
        more = share * (edges + own.play * self.lean - own.offset - wanted)
        # (s²/ω² + 2ζ s/ω + 1)·lag, the lag's own curvature from (τ s + 1)² lag = more
        curvature = (more - self.lag[0]) / own.rolloff**2 - 2 / own.rolloff * self.lag[1]
        natural = own.valve_frequency
        led = curvature / natural**2 + 2 * own.valve_damping / natural * self.lag[1] + self.lag[0]
        self.edges = edges
        self.state = self.spool_moves @ [*self.state, own.valve_gain * volts]
        self.lag = self.lag_moves @ [*self.lag, more]
        return float(led / own.valve_gain)


Waiting = list[tuple[float, int, Array]]


def _acted(step: int, waiting: Waiting, held: Array) -> Waiting:
    """What still waits in a step; whose time has come is held."""
    for moment, j, volts in sorted(waiting, key=lambda each: each[0]):
        if moment <= step + 1e-6:
            held[j] = volts
    return [each for each in waiting if each[0] > step + 1e-6]


def in_python(law: Controller | ControllerBank, readings: Array) -> Array:
    """Commands at the start of every step (step, valve), without rounding, from readings (step, channel)."""
    parts, converter = law.parts, law.converter
    valves, limit = converter.valves, converter.voltage_limit
    fastest = min(parts, key=lambda part: (part.period, part.latency))
    stages = [PythonStage(valve, fastest.period) for valve in valves]
    states, latest = [np.zeros(part.states) for part in parts], np.zeros((len(parts), len(converter.mounts)))
    waiting: Waiting = []
    spools = [PythonSpool(spool, limit) for spool in converter.spools]
    held, found = np.zeros((len(parts) + 2, len(converter.mounts))), []
    channels = list(law.reads)
    for k, row in enumerate(readings):
        reading = dict(zip(channels, row, strict=True))
        due = [j for j, part in enumerate(parts) if k % round(part.period / STEP) == 0]
        inputs = {j: np.array([reading[name] for name in parts[j].inputs]) for j in due}
        for j in due:
            latest[j] = parts[j].C @ states[j] + parts[j].D @ inputs[j]
        s = np.clip((k * STEP - converter.switch_on) / converter.fade, 0, 1) if converter.fade else 1.0
        share, total, more = 3 * s**2 - 2 * s**3, latest.sum(axis=0), np.zeros(len(latest[0]))
        lost = np.zeros(len(more)) if stages else np.clip(share * total, -limit, limit) - total
        for i, stage in enumerate(stages):
            at = (reading.get(f"chamber_pressure {converter.mounts[i]} {n}", 0.0) for n in "12")
            own = stage.valve.numbers
            factors = stage.factors(*at, reading.get("supply_pressure", own.supply))
            if due:
                lost[i] = np.clip(share * total[i], *stage.reach(factors, limit)) - total[i]
            if k % round(fastest.period / STEP) == 0:
                more[i] = stage.added(total[i] + lost[i], share, factors)
        for j in due:
            part, own_windup = parts[j], parts[j].anti_windup
            states[j] = part.A @ states[j] + part.B @ inputs[j]
            if own_windup is not None:
                states[j] += own_windup @ lost
            waiting.append((k + part.latency / STEP, j, share * latest[j]))
        if k % round(fastest.period / STEP) == 0:
            waiting.append((k + fastest.latency / STEP, len(parts), more))
        waiting = _acted(k, waiting, held)
        if spools and k % round(spools[0].own.period / STEP) == 0:
            closed = np.zeros(len(spools))
            for i, one in enumerate(spools):
                position = reading[f"{'edges' if one.own.edges else 'spool'} {converter.mounts[i]}"]
                closed[i] = one.added(share, held[:-1, i].sum(), position)
            waiting = _acted(k, [*waiting, (k + spools[0].own.delay / STEP, len(parts) + 1, closed)], held)
        found.append(np.clip(held.sum(axis=0), -limit, limit))
    return np.array(found)
