"""The loop about a valve's spool in plain Python, from its transfer functions as difference equations."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

from ehamj.control.spools import KnownSpool


@dataclass
class PythonSpool:
    """One valve's, of which ``limit`` is the converter's range [V]."""

    own: KnownSpool
    limit: float

    def __post_init__(self) -> None:
        own = self.own
        natural = own.valve_frequency
        rates = [[0.0, 1.0, 0.0], [-(natural**2), -2 * own.valve_damping * natural, natural**2], [0.0, 0.0, 0.0]]
        self.moves, self.reference, self.total = expm(np.array(rates) * own.period)[:2], np.zeros(2), 0.0
        q = np.exp(-own.period / own.rolloff)
        poles = np.roots([1.0, 2 * own.valve_damping * natural, natural**2])
        inverse = np.poly(np.exp(poles * own.period)).real
        gain = own.crossing * own.period / own.valve_gain * (1 - q) ** 2 / inverse.sum()
        self.filter = gain * inverse, np.array([1.0, -2 * q, q**2])
        self.kept = np.zeros(2)

    def added(self, share: float, volts: float, position: float) -> float:
        """What is added [V] at a sample, to ``volts`` that all others hold."""
        own, reference = self.own, self.reference
        wanted, most = (
            own.valve_gain * np.clip(volts, -self.limit, self.limit),
            own.drive_limit / own.valve_frequency**2,
        )
        target = np.clip(wanted, reference[0] - most, reference[0] + most)
        error = share * (reference[0] - own.lag * reference[1] - position)
        (more,), self.kept = lfilter(*self.filter, [error], zi=self.kept)
        room = np.clip(self.limit - volts, 0, own.limit), np.clip(self.limit + volts, 0, own.limit)
        self.total = float(np.clip(self.total + more, -room[1], room[0]))
        self.reference = self.moves @ [*reference, target]
        return self.total
