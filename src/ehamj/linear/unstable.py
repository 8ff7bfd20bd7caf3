"""What runs away where a linear machine or its loop is unstable: the pole, by frequency, damping and motion."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import eigen_of, named
from ehamj.linear.sampled import STABLE, pattern_period, spectral_radius

GROWS: Final = 1e-3
"""Growth [1/s] from which a machine by itself counts as unstable; neutral pressures stay below it."""


@dataclass(frozen=True)
class UnstablePole:
    """The fastest growing pole of an unstable machine or loop.

    ``frequency`` |λ|/2π [Hz], ``damping_ratio`` −Re λ/|λ| (negative), ``growth`` Re λ [1/s], ``motion`` a mode's name
    (`ehamj.linear.names`), and how many poles grow in all (pairs count once).
    """

    frequency: float
    damping_ratio: float
    growth: float
    motion: str
    count: int

    def __str__(self) -> str:
        """In words: 'heave at 84.2 Hz with damping ratio −0.0123'."""
        if self.damping_ratio <= -1.0 + 1e-9:
            words = f"{self.motion} without swinging, growing e-fold in {1.0 / self.growth:.3g} s"
        else:
            ratio = f"{-self.damping_ratio:.2g}"
            words = f"{self.motion} at {self.frequency:.4g} Hz with damping ratio −{ratio}"
        return words + (f", the fastest of {self.count} poles that grow" if self.count > 1 else "")

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "frequency_hz": self.frequency, "damping_ratio": self.damping_ratio, "growth_1_s": self.growth,
            "motion": self.motion, "count": self.count, "words": str(self),
        }  # fmt: skip


def unstable_pole(model: LinearModel, loop: Loop | None = None) -> UnstablePole | None:
    """The fastest growing pole of a machine with its valves held, or of its sampled loop; None where it is stable."""
    if loop is not None and spectral_radius(model, loop) < STABLE:
        return None
    eigen, states = eigen_of(model, loop)
    least = GROWS if loop is None else float(np.log(STABLE)) / pattern_period(loop.law)
    growing = [
        k for k in np.argsort(-eigen.values.real) if eigen.values[k].real > least and eigen.values[k].imag >= 0.0
    ]
    if not growing:
        return None
    value = complex(eigen.values[growing[0]])
    return UnstablePole(
        abs(value) / (2 * np.pi), -value.real / abs(value), value.real, named(model, states, eigen, int(growing[0])),
        len(growing),
    )  # fmt: skip
