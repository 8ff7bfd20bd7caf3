"""The paper's ten designs, and those that it speaks of beside them, computed."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import FAST_VALVE, LARGE_SIGNAL_VALVE, LINEAR, PAPER_MASS, positive
from ehamj.paper.merits import FiguresOfMerit, figures_of_merit

CASES: Final[dict[str, tuple[str, dict[str, float]]]] = {
    "initial": ("initial design", {}),
    "volume_double": ("chamber volume × 2", {"chamber_volume": 1.0}),
    "volume_half": ("chamber volume ÷ 2", {"chamber_volume": -1.0}),
    "area_double": ("piston area × 2", {"piston_area": 1.0}),
    "area_half": ("piston area ÷ 2", {"piston_area": -1.0}),
    "flow_gain_double": ("flow gain × 2", {"flow_gain": 1.0}),
    "flow_gain_half": ("flow gain ÷ 2", {"flow_gain": -1.0}),
    "flow_pressure_double": ("flow-pressure coefficient × 2", {"flow_pressure": 1.0}),
    "flow_pressure_half": ("flow-pressure coefficient ÷ 2", {"flow_pressure": -1.0}),
    "recommended": ("recommended design", {"chamber_volume": -1.0, "piston_area": 1.0, "flow_pressure": 1.0}),
}
"""The paper's cases: label, and which parameters are multiplied by which power of the study's factor. Its "±100 %" of
Table I are ×2 and ÷2: with these its frequencies come out."""

VARIANTS: Final[dict[str, tuple[str, str, Callable[["PaperStudy"], dict[str, float]]]]] = {
    "initial_large_signal": (
        "initial design, valve at ±90 % of its signal",
        "initial",
        lambda study: {"valve_frequency": study.large_signal_valve},
    ),
    "recommended_fast_valve": (
        "recommended design, {valve_hz:.0f} Hz valve",
        "recommended",
        lambda study: {"valve_frequency": study.fast_valve},
    ),
    "initial_reading": (
        "initial design, as the paper's margins read",
        "initial",
        lambda study: study.reading(),
    ),
    "recommended_reading": (
        "recommended design, as the paper's margins read",
        "recommended",
        lambda study: study.reading(),
    ),
}
"""What the paper speaks of beside its cases: label, the case that it starts from, and the values that it sets."""


@dataclass(frozen=True)
class PaperStudy:
    """What is computed: the initial design, and by what the cases differ from it.

    Raises:
        InputError: if a value is not a positive number.
    """

    actuator: Actuator = FIRST_GENERATION
    """The initial design; only its `LINEAR` parameters count."""
    mass: float = PAPER_MASS
    """Translating mass [kg]."""
    factor: float = 2.0
    """By which a parameter is multiplied or divided."""
    large_signal_valve: float = LARGE_SIGNAL_VALVE
    """Natural frequency of the valve at ±90 % [rad/s]."""
    fast_valve: float = FAST_VALVE
    """Natural frequency of the faster valve of section 5 [rad/s]."""
    reading_gain: float = 10.0
    """Factor on the flow gain under which the paper's gain margins come out [-]."""
    reading_valve: float = 2.0 * math.pi * 260.0
    """Valve frequency under which, with that gain, its phase crossovers come out [rad/s]."""
    gain_margin_db: float = 6.0
    """Gain margin that a proportional loop keeps [dB]."""
    phase_margin_deg: float = 45.0
    """Phase margin that it keeps [deg]."""

    def __post_init__(self) -> None:
        for name in ("factor", "large_signal_valve", "fast_valve", "reading_gain", "reading_valve"):
            positive(name, getattr(self, name))

    def design(self, name: str) -> Actuator:
        """The actuator of a case or variant.

        Raises:
            InputError: if there is no such case.
        """
        if name not in CASES | VARIANTS:
            raise InputError(f"case = {name!r}: must be one of {', '.join((*CASES, *VARIANTS))}")
        _, base, extra = VARIANTS.get(name, ("", name, lambda _: {}))
        powers = CASES[base][1].items()
        values: dict[str, float] = {key: getattr(self.actuator, key) * self.factor**power for key, power in powers}
        return self.actuator.with_values(values | extra(self))

    def reading(self) -> dict[str, float]:
        """The values under which the paper's margins come out [m³/s/mA, rad/s]."""
        return {"flow_gain": self.actuator.flow_gain * self.reading_gain, "valve_frequency": self.reading_valve}

    def merits(self, actuator: Actuator, mass: float | None = None) -> FiguresOfMerit:
        """Figures of merit with the study's margins, under its mass unless another is given [kg]."""
        margins = {"gain_margin_db": self.gain_margin_db, "phase_margin_deg": self.phase_margin_deg}
        return figures_of_merit(actuator, self.mass if mass is None else mass, **margins)

    def to_dict(self) -> dict[str, Any]:
        """The study as plain data."""
        plain = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "actuator"}
        return {"actuator": described(self.actuator), **plain}


def described(actuator: Actuator) -> dict[str, dict[str, Any]]:
    """The linear parameters of an actuator with unit, symbol and source, as plain data."""
    known = Actuator.quantities()
    return {
        name: {
            "value": getattr(actuator, name),
            "unit": known[name][0],
            "symbol": known[name][1],
            "source": actuator.sources[name],
        }
        for name in LINEAR
    }


@dataclass(frozen=True)
class PaperCase:
    """One design, computed."""

    name: str
    actuator: Actuator
    merits: FiguresOfMerit

    @property
    def label(self) -> str:
        """What to call it."""
        return (CASES | VARIANTS)[self.name][0].format_map(vars(self.merits))

    def numbers(self) -> dict[str, float]:
        """The paper's four numbers [Hz, -, dB, Hz], of the exact form and (``_eq8``) of eq. 8 corrected; ω_h and δ_h
        are definitions of the paper's, and the same in both."""
        merits = vars(self.merits)
        names = ("omega_h_hz", "delta_h", "gain_margin_db", "phase_crossover_hz")
        return {
            f"{name}{suffix}": merits.get(f"{name}{suffix}", merits[name]) for suffix in ("", "_eq8") for name in names
        }

    def to_dict(self) -> dict[str, Any]:
        """The case as plain data."""
        return {"label": self.label, **self.numbers(), "parameters": described(self.actuator)}


def paper_cases(study: PaperStudy) -> dict[str, PaperCase]:
    """Every case and variant by name.

    Raises:
        InputError: if the study is not physical.
    """
    designs = {name: study.design(name) for name in CASES | VARIANTS}
    return {name: PaperCase(name, design, study.merits(design)) for name, design in designs.items()}
