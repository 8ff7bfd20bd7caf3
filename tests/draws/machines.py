"""Machines that are drawn: values within ±30 %, and options of their valves that may be there."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

SPREAD: Final = 0.3
ISOLATOR: Final = "actuators.isolator"
NOMINAL: Final[dict[str, float]] = {
    f"{ISOLATOR}.flow_gain": 1.94e-6,
    f"{ISOLATOR}.flow_pressure": 6.6e-11,
    f"{ISOLATOR}.edge_leakage_share": 0.05,
    f"{ISOLATOR}.bulk_modulus": 1.4e9,
    f"{ISOLATOR}.valve_frequency": 1571.0,
    f"{ISOLATOR}.valve_damping": 0.65,
    f"{ISOLATOR}.membrane_stiffness": 6.8e8,
    "machine.mass": 4000.0,
    "machine.cg.0": 0.0,
    "machine.cg.1": 0.0,
    "machine.cg.2": 0.75,
    "machine.inertia.0": 2000.0,
    "machine.inertia.1": 3000.0,
    "machine.inertia.2": 4000.0,
}
"""What everybody believes of the machine before it is measured."""
ASIDE: Final = 0.1
"""Distance of the centre of gravity from where it is believed, along x and y, at most [m]."""
BOUNDS: Final[dict[str, tuple[float, float]]] = {"machine.cg.0": (-0.3, 0.3), "machine.cg.1": (-0.3, 0.3)}
"""Of values whose bounds do not follow from the nominal ones."""

STROKE: Final = 20.0
"""Of the spool [mA]."""
OPTIONS: Final[dict[str, tuple[str, float, float, float]]] = {
    "overlap": (f"{ISOLATOR}.overlap", 0.005 * STROKE, 0.03 * STROKE, 4),
    "hysteresis": (f"{ISOLATOR}.hysteresis", 0.002 * STROKE, 0.012 * STROKE, 1),
    "air": (f"{ISOLATOR}.air_fraction", 0.002, 0.012, 1),
}
"""By name in [choice]: key, the least and the most that one has that is there, and how many numbers its value is."""


@dataclass(frozen=True)
class Drawn:
    """One machine."""

    values: dict[str, float]
    """By key; all of `NOMINAL`."""
    options: dict[str, float] = field(default_factory=dict)
    """Those that its valves have, by name."""

    @property
    def table(self) -> dict[str, Any]:
        """As a scenario has it, by dotted key."""
        own: dict[str, Any] = {key: value for key, value in self.values.items() if not key.startswith("machine.")}
        for name in ("cg", "inertia"):
            own[f"machine.{name}"] = [self.values[f"machine.{name}.{k}"] for k in range(3)]
        own["machine.mass"] = self.values["machine.mass"]
        for name, value in self.options.items():
            key, *_, count = OPTIONS[name]
            own[key] = [value] * count if count > 1 else value
        return own


def drawn(seed: int, number: int, keys: Sequence[str], options: bool) -> Drawn:
    """The machine of a number: values of these keys drawn, the others as they are believed to be, and which options its
    valves have."""
    random = np.random.default_rng([seed, number])
    while True:
        values = {key: value * (1.0 + random.uniform(-SPREAD, SPREAD)) for key, value in NOMINAL.items()}
        values |= {key: random.uniform(-ASIDE, ASIDE) for key in BOUNDS}
        moments = np.array([values[f"machine.inertia.{k}"] for k in range(3)])
        if 2.0 * moments.max() < 0.95 * moments.sum():  # else no body has them
            break
    values |= {key: value for key, value in NOMINAL.items() if key not in keys}
    if not options:
        return Drawn(values)
    own = {}
    for name, (_, least, most, _) in OPTIONS.items():
        there, size = random.uniform() < 0.5, float(np.exp(random.uniform(np.log(least), np.log(most))))
        if there:
            own[name] = size
    return Drawn(values, own)
