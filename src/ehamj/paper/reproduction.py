"""The paper, reproduced number by number, with what does not reproduce said aloud.

Beside every number that the paper states stands the computed one, and what the rounding of its Table I leaves open.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from typing import Any, Final

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import PAPER_MASS, delta_h, omega_h, scaled
from ehamj.paper.cases import CASES, PaperCase, PaperStudy, paper_cases
from ehamj.paper.claims import Claim, claims
from ehamj.paper.loop import PositionLoop

ROUNDING: Final = {
    "mass": 0.5,
    "piston_area": 0.005e-2,
    "chamber_volume": 0.005e-4,
    "bulk_modulus": 0.05e9,
    "membrane_stiffness": 0.05e8,
    "membrane_damping": 50.0,
    "flow_gain": 0.005e-6,
    "flow_pressure": 0.05e-11,
    "valve_gain": 0.5,
    "valve_frequency": 0.5,
    "valve_damping": 0.005,
}
"""Half a unit of the last digit that Table I prints of each value [SI, mA]."""


@dataclass(frozen=True)
class PaperNumber:
    """One number of the paper, and what `reproduce` finds for it."""

    section: str
    name: str
    unit: str
    paper: float
    half_unit: float
    """Half a unit of the last digit that the paper prints."""
    case: str
    """The design that it is of, by name."""
    figure: str
    """What it is of that design, by name."""
    note: str = ""
    value: float = math.nan
    """What is computed."""
    allowed: tuple[float, float] | None = None
    """What the rounding of Table I leaves open, to first order; None where nothing is computed from it."""
    verdict: str = ""

    @property
    def stated(self) -> str:
        """The paper's number with its unit."""
        return f"{self.paper:g}{self._unit}"

    @property
    def computed(self) -> str:
        """The computed number with its unit."""
        return f"{self.value:.{self._digits}f}{self._unit}"

    @property
    def deviation(self) -> str:
        """Computed minus paper, of a frequency also in percent."""
        difference = round(self.value - self.paper, self._digits) + 0.0  # no −0
        percent = "" if self._percent is None else f" ({self._percent:+.1f} %)"
        return f"{difference:+.{self._digits}f}{self._unit}{percent}".replace("-", "−")

    @property
    def comment(self) -> str:
        """Verdict and note."""
        return "; ".join(part for part in (self.verdict, self.note) if part)

    @property
    def allowed_text(self) -> str:
        """What the rounding of Table I leaves open, as words."""
        return " to ".join(f"{end:.{self._digits}f}" for end in self.allowed or ())

    @property
    def _unit(self) -> str:
        return "" if self.unit == "-" else f" {self.unit}"

    @property
    def _digits(self) -> int:
        return 3 if self.unit == "-" else 1

    @property
    def _percent(self) -> float | None:
        return 100.0 * (self.value / self.paper - 1.0) if self.unit == "Hz" else None

    def to_dict(self) -> dict[str, Any]:
        """The number as plain data, numbers as numbers."""
        return {
            "section": self.section,
            "name": self.name,
            "unit": self.unit,
            "paper": self.paper,
            "computed": self.value,
            "deviation": self.value - self.paper,
            "deviation_percent": self._percent,
            "table_1_allows": list(self.allowed) if self.allowed else None,
            "verdict": self.verdict,
            "note": self.note,
        }


_F, _D, _V = "hydro-mechanical frequency", "hydraulic damping ratio", "valve frequency"
_SIX = "256.7 Hz initially would give all six"
_INPUT = "taken from the text, not computed"


def _margins(case: str, label: str, gain_margin: float, crossover: float) -> Iterator[PaperNumber]:
    """A gain margin and its frequency as the paper prints them, beside each way to compute them."""
    reading = "exact form, ten times the loop gain and a valve of 260 Hz, of which the paper says nothing"
    ways = ((case, "", "exact form"), (case, "_eq8", "eq. 8 corrected"), (f"{case}_reading", "", reading))
    for name, suffix, way in ways:
        yield PaperNumber("5", f"gain margin, {label}", "dB", gain_margin, 0.5, name, f"gain_margin_db{suffix}", way)
    for name, suffix, way in ways:
        figure = f"phase_crossover_hz{suffix}"
        yield PaperNumber("5", f"frequency of the gain margin, {label}", "Hz", crossover, 0.5, name, figure, way)


NUMBERS: Final = (
    PaperNumber("3", f"{_F}, initial design", "Hz", 257, 0.5, "initial", "omega_h_hz", _SIX),
    PaperNumber("3", f"{_V} at ±5 %", "Hz", 250, 0.5, "initial", "valve_hz", "1571 rad/s in Table I"),
    PaperNumber("3", f"{_V} at ±90 %", "Hz", 100, 0.5, "initial_large_signal", "valve_hz", _INPUT),
    PaperNumber("3", "lag of the valve around its frequency", "deg", 90, 0.5, "initial", "valve_lag_deg", "at 250 Hz"),
    PaperNumber("4.1", f"{_F}, chamber volume × 2", "Hz", 182, 0.5, "volume_double", "omega_h_hz", _SIX),
    PaperNumber("4.1", f"{_F}, chamber volume ÷ 2", "Hz", 363, 0.5, "volume_half", "omega_h_hz", _SIX),
    PaperNumber("4.1", f"{_D}, chamber volume × 2", "-", 0.15, 0.005, "volume_double", "delta_h"),
    PaperNumber("4.1", f"{_D}, chamber volume ÷ 2", "-", 0.3, 0.05, "volume_half", "delta_h"),
    PaperNumber("4.2", f"{_F}, piston area × 2", "Hz", 513, 0.5, "area_double", "omega_h_hz", _SIX),
    PaperNumber("4.2", f"{_F}, piston area ÷ 2", "Hz", 128, 0.5, "area_half", "omega_h_hz", _SIX),
    PaperNumber("5", f"{_F}, recommended design", "Hz", 726, 0.5, "recommended", "omega_h_hz", _SIX),
    PaperNumber("5", f"{_D}, recommended design", "-", 0.3, 0.05, "recommended", "delta_h"),
    PaperNumber("5", f"{_V}, recommended design", "Hz", 250, 0.5, "recommended", "valve_hz", "the initial valve"),
    PaperNumber("5", f"{_V}, faster valve", "Hz", 400, 0.5, "recommended_fast_valve", "valve_hz", _INPUT),
    *_margins("initial", "initial design", 116, 187),
    *_margins("recommended", "recommended design", 128, 230),
)
"""Every frequency, damping ratio and margin of the paper's text."""

AGREES, ROUNDED = "agrees to the printed digit", "agrees within the rounding of Table I"
FAILS, GIVEN = "does not reproduce", "given"


@dataclass(frozen=True)
class Reproduction:
    """The whole reproduction: cases by name, variants beyond the paper's ten, the table and the claims."""

    study: PaperStudy
    cases: dict[str, PaperCase]
    variants: dict[str, PaperCase]
    table: tuple[PaperNumber, ...] = field(repr=False)
    claims: tuple[Claim, ...] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, numbers as numbers."""
        return {
            "study": self.study.to_dict(),
            "cases": {name: case.to_dict() for name, case in self.cases.items()},
            "variants": {name: case.to_dict() for name, case in self.variants.items()},
            "table": [number.to_dict() for number in self.table],
            "claims": [claim._asdict() for claim in self.claims],
            "versions": {name: version(name) for name in ("ehamj", "numpy", "scipy")},
        }


def reproduce(study: PaperStudy | None = None) -> Reproduction:
    """Compute the paper's ten cases, four variants (the valve at ±90 %, the 400 Hz valve, both designs under the other
    reading), and everything that the paper states about them.

    Raises:
        InputError: if the study is not physical.
    """
    study = study or PaperStudy()
    every = paper_cases(study)
    cases = {name: every[name] for name in CASES}
    variants = {name: case for name, case in every.items() if name not in CASES}
    table = tuple(_compared(study, every[number.case].actuator, number) for number in NUMBERS)
    return Reproduction(study, cases, variants, table, claims(study, every))


def _compared(study: PaperStudy, actuator: Actuator, number: PaperNumber) -> PaperNumber:
    value = _value(actuator, study.mass, number.figure)
    if number.note == _INPUT:
        return replace(number, value=value, verdict=GIVEN)
    spread, off = _spread(study, actuator, number.figure), abs(value - number.paper)
    verdict = AGREES if off <= number.half_unit else ROUNDED if off <= number.half_unit + spread else FAILS
    return replace(number, value=value, allowed=(value - spread, value + spread), verdict=verdict)


def _spread(study: PaperStudy, actuator: Actuator, figure: str) -> float:
    """By how much a figure moves when every value of Table I moves by half a unit of its last digit, the worst way, to
    first order; a case that multiplies a value multiplies its rounding."""
    spread = 0.0
    for name, half_unit in ROUNDING.items():
        relative = half_unit / (PAPER_MASS if name == "mass" else getattr(FIRST_GENERATION, name))
        ends = [_value(*scaled(actuator, study.mass, name, 1.0 + way), figure) for way in (relative, -relative)]
        spread += 0.5 * abs(ends[0] - ends[1])
    return spread


def _value(actuator: Actuator, mass: float, figure: str) -> float:
    """A figure of merit by name, or the valve's lag at 250 Hz [deg] (eq. 1), and no more than that one."""
    ratio = 2.0 * math.pi * 250.0 / actuator.valve_frequency
    match figure.removesuffix("_eq8"):
        case "valve_lag_deg":
            return math.degrees(math.atan2(2.0 * actuator.valve_damping * ratio, 1.0 - ratio**2))
        case "valve_hz":
            return actuator.valve_frequency / (2.0 * math.pi)
        case "omega_h_hz":
            return omega_h(actuator, mass) / (2.0 * math.pi)
        case "delta_h":
            return delta_h(actuator, mass)
    loop = PositionLoop.of_actuator(actuator, mass, "eq8" if figure.endswith("_eq8") else "exact")
    if figure.startswith("gain_margin_db"):
        return 20.0 * math.log10(loop.stability_gain)
    return loop.phase_crossover / (2.0 * math.pi)
