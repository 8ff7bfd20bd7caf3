"""The paper's ten designs, and those that it speaks of beside them, computed."""

import math
from dataclasses import dataclass
from typing import Any, Final

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.paper.actuator import FAST_VALVE, LARGE_SIGNAL_VALVE, LINEAR, positive
from ehamj.paper.merits import DesignStudy, FiguresOfMerit

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


@dataclass(frozen=True)
class PaperStudy(DesignStudy):
    """What is computed: the initial design, and by what the cases differ from it.

    Raises:
        InputError: if a value is not a positive number.
    """

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

    def __post_init__(self) -> None:
        for name in ("factor", "large_signal_valve", "fast_valve", "reading_gain", "reading_valve"):
            positive(name, getattr(self, name))

    def reading(self) -> dict[str, float]:
        """The values under which the paper's margins come out [m³/s/mA, rad/s]."""
        return {"flow_gain": self.actuator.flow_gain * self.reading_gain, "valve_frequency": self.reading_valve}

    def variants(self) -> dict[str, tuple[str, str, dict[str, float]]]:
        """What the paper speaks of beside its cases: label, the case it starts from, and the values that it sets."""
        slow, fast = ({"valve_frequency": value} for value in (self.large_signal_valve, self.fast_valve))
        reading = self.reading()
        return {
            "initial_large_signal": ("initial design, valve at ±90 % of its signal", "initial", slow),
            "recommended_fast_valve": ("recommended design, {valve_hz:.0f} Hz valve", "recommended", fast),
            "initial_reading": ("initial design, as the paper's margins read", "initial", reading),
            "recommended_reading": ("recommended design, as the paper's margins read", "recommended", reading),
        }

    def design(self, name: str) -> Actuator:
        """The actuator of a case or variant.

        Raises:
            InputError: if there is no such case.
        """
        variants = self.variants()
        if name not in CASES | variants:
            raise InputError(f"case = {name!r}: must be one of {', '.join((*CASES, *variants))}")
        _, base, values = variants.get(name, ("", name, {}))
        powers = CASES[base][1].items()
        scaled = {key: getattr(self.actuator, key) * self.factor**power for key, power in powers}
        return self.actuator.with_values(scaled | values)

    def to_dict(self) -> dict[str, Any]:
        """The study as plain data."""
        return vars(self) | {"actuator": described(self.actuator)}


def described(actuator: Actuator) -> dict[str, dict[str, Any]]:
    """The linear parameters of an actuator with unit, symbol and source, as plain data."""
    known, keys = Actuator.quantities(), ("value", "unit", "symbol", "source")
    return {
        name: dict(zip(keys, (getattr(actuator, name), *known[name][:2], actuator.sources[name]), strict=True))
        for name in LINEAR
    }


@dataclass(frozen=True)
class PaperCase:
    """One design, computed."""

    label: str
    """What to call it."""
    actuator: Actuator
    merits: FiguresOfMerit

    def numbers(self) -> dict[str, float]:
        """The paper's four numbers [Hz, -, dB, Hz], of the exact form and (``_eq8``) of eq. 8 corrected; ω_h and δ_h
        are definitions of the paper's, and the same in both."""
        merits, names = vars(self.merits), ("omega_h_hz", "delta_h", "gain_margin_db", "phase_crossover_hz")
        return {name + form: merits.get(name + form, merits[name]) for form in ("", "_eq8") for name in names}

    def to_dict(self) -> dict[str, Any]:
        """The case as plain data."""
        return {"label": self.label, **self.numbers(), "parameters": described(self.actuator)}


def paper_cases(study: PaperStudy) -> dict[str, PaperCase]:
    """Every case and variant by name.

    Raises:
        InputError: if the study is not physical.
    """
    found = {}
    for name, (label, *_) in (CASES | study.variants()).items():
        design = study.design(name)
        merits = study.merits(design, study.mass)
        found[name] = PaperCase(label.format_map(vars(merits)), design, merits)
    return found
