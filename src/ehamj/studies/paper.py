"""The paper, reproduced number by number and figure by figure, with what does not reproduce said aloud.

`reproduce` computes every case, `compare` sets every number that the paper states beside it, `write_paper` writes
figures, table and a record that `PaperStudy.from_record` reads back.
"""

import csv
import html
import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from ehamj.analysis.actuator import (
    FAST_VALVE,
    LARGE_SIGNAL_VALVE,
    PAPER_MASS,
    FiguresOfMerit,
    Form,
    Loop,
    bode,
    figures_of_merit,
)
from ehamj.errors import InputError
from ehamj.parameters import FIRST_GENERATION, Actuator
from ehamj.plots import BLUE, GREEN, INK, ORANGE, PURPLE, STYLE, VERMILLION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LINEAR: Final = (
    "piston_area",
    "chamber_volume",
    "bulk_modulus",
    "membrane_stiffness",
    "membrane_damping",
    "flow_gain",
    "flow_pressure",
    "valve_gain",
    "valve_frequency",
    "valve_damping",
)
"""The parameters that the linear actuator has, beside its mass."""

CASES: Final[dict[str, dict[str, float]]] = {
    "initial": {},
    "volume_double": {"chamber_volume": 1.0},
    "volume_half": {"chamber_volume": -1.0},
    "area_double": {"piston_area": 1.0},
    "area_half": {"piston_area": -1.0},
    "flow_gain_double": {"flow_gain": 1.0},
    "flow_gain_half": {"flow_gain": -1.0},
    "flow_pressure_double": {"flow_pressure": 1.0},
    "flow_pressure_half": {"flow_pressure": -1.0},
    "recommended": {"chamber_volume": -1.0, "piston_area": 1.0, "flow_pressure": 1.0},
}
"""The paper's cases: which parameters are multiplied by which power of the study's factor. Its "±100 %" of Table I are
×2 and ÷2: with these its frequencies come out."""

LABELS: Final = {
    "initial": "initial design",
    "volume_double": "chamber volume × 2",
    "volume_half": "chamber volume ÷ 2",
    "area_double": "piston area × 2",
    "area_half": "piston area ÷ 2",
    "flow_gain_double": "flow gain × 2",
    "flow_gain_half": "flow gain ÷ 2",
    "flow_pressure_double": "flow-pressure coefficient × 2",
    "flow_pressure_half": "flow-pressure coefficient ÷ 2",
    "recommended": "recommended design",
    "initial_large_signal": "initial design, valve at ±90 %",
    "recommended_fast_valve": "recommended design, 400 Hz valve",
    "initial_reading": "initial design, other reading",
    "recommended_reading": "recommended design, other reading",
}

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
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise InputError(f"{name} = {value!r}: must be a positive, finite number")

    def design(self, name: str) -> Actuator:
        """The actuator of a case or variant.

        Raises:
            InputError: if there is no such case.
        """
        if name not in LABELS:
            raise InputError(f"case {name!r}: must be one of {', '.join(LABELS)}")
        base, _, variant = name.partition("_") if name not in CASES else (name, "", "")
        factors = {key: self.factor**power for key, power in CASES[base].items()}
        values: dict[str, float] = {key: getattr(self.actuator, key) * factor for key, factor in factors.items()}
        if variant == "large_signal":
            values["valve_frequency"] = self.large_signal_valve
        elif variant == "fast_valve":
            values["valve_frequency"] = self.fast_valve
        elif variant == "reading":
            values |= {"valve_frequency": self.reading_valve, "flow_gain": self.actuator.flow_gain * self.reading_gain}
        return self.actuator.with_values(values)

    def figures(self, actuator: Actuator, mass: float | None = None) -> FiguresOfMerit:
        """Figures of merit with the study's margins, under its mass unless another is given [kg]."""
        margins = {"gain_margin_db": self.gain_margin_db, "phase_margin_deg": self.phase_margin_deg}
        return figures_of_merit(actuator, self.mass if mass is None else mass, **margins)

    def record(self) -> dict[str, Any]:
        """The study as plain data, see `from_record`."""
        plain = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "actuator"}
        return {"actuator": described(self.actuator), **plain}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """The study of a record: a whole ``paper.json``, or its part ``study``.

        Raises:
            InputError: if an entry is missing, unknown or not physical.
        """
        study = dict(record.get("study", record))
        try:
            values = {name: entry["value"] for name, entry in study.pop("actuator").items()}
            sources = {"sources": {name: entry["source"] for name, entry in record_entries(record).items()}}
            return cls(actuator=Actuator(**values, **sources), **study)
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise InputError(f"study: this is no record of it: {error}") from error


def record_entries(record: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The described parameters of a record's actuator."""
    entries: dict[str, dict[str, Any]] = record.get("study", record)["actuator"]
    return entries


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
class Case:
    """One design, computed."""

    name: str
    actuator: Actuator
    figures: FiguresOfMerit

    @property
    def label(self) -> str:
        """What the paper calls it."""
        return LABELS[self.name]

    def numbers(self) -> dict[str, float]:
        """The paper's four numbers, of the exact form and (``_eq8``) of eq. 8 corrected; ω_h and δ_h are definitions
        of the paper's, and the same in both [Hz, -, dB, Hz]."""
        f = self.figures
        return {
            "omega_h_hz": f.omega_h_hz,
            "delta_h": f.delta_h,
            "gain_margin_db": f.gain_margin_db,
            "phase_crossover_hz": f.phase_crossover_hz,
            "omega_h_hz_eq8": f.omega_h_hz,
            "delta_h_eq8": f.delta_h,
            "gain_margin_db_eq8": f.gain_margin_db_eq8,
            "phase_crossover_hz_eq8": f.phase_crossover_hz_eq8,
        }


@dataclass(frozen=True)
class Comparison:
    """One number of the paper beside the computed one."""

    section: str
    quantity: str
    unit: str
    paper: float
    computed: float
    allowed: tuple[float, float] | None
    """What the rounding of Table I leaves open, to first order; None where nothing is computed from it."""
    verdict: str
    comment: str

    @property
    def deviation(self) -> float:
        """Computed minus paper, in the unit of the number."""
        return self.computed - self.paper

    def row(self) -> dict[str, Any]:
        """The comparison as plain data."""
        relative = 100.0 * self.deviation / self.paper
        allowed = list(self.allowed) if self.allowed else None
        return {
            "section": self.section,
            "quantity": self.quantity,
            "unit": self.unit,
            "paper": self.paper,
            "computed": self.computed,
            "deviation": self.deviation,
            "deviation_percent": relative if self.unit == "Hz" else None,
            "table_1_allows": allowed,
            "verdict": self.verdict,
            "comment": self.comment,
        }


@dataclass(frozen=True)
class Claim:
    """One statement of the paper in words, and what the numbers say to it."""

    section: str
    statement: str
    finding: str


@dataclass(frozen=True)
class Reproduction:
    """The whole reproduction: cases by name, variants beyond the paper's ten, the table and the claims."""

    study: PaperStudy
    cases: dict[str, Case]
    variants: dict[str, Case]
    table: tuple[Comparison, ...] = field(repr=False)
    claims: tuple[Claim, ...] = field(repr=False)

    def record(self) -> dict[str, Any]:
        """Everything as plain data; `PaperStudy.from_record` and `reproduce` give the same again."""

        def entry(case: Case) -> dict[str, Any]:
            return {"label": case.label, **case.numbers(), "parameters": described(case.actuator)}

        return {
            "study": self.study.record(),
            "cases": {name: entry(case) for name, case in self.cases.items()},
            "variants": {name: entry(case) for name, case in self.variants.items()},
            "table": [comparison.row() for comparison in self.table],
            "claims": [vars(claim) for claim in self.claims],
            "versions": {name: version(name) for name in ("ehamj", "numpy", "scipy")},
        }


def reproduce(study: PaperStudy | None = None) -> Reproduction:
    """Compute the paper's ten cases, four variants (the valve at ±90 %, the 400 Hz valve, both designs under the other
    reading), and everything that the paper states about them.

    Raises:
        InputError: if the study is not physical.
    """
    study = study or PaperStudy()
    every = {name: Case(name, design, study.figures(design)) for name in LABELS for design in [study.design(name)]}
    cases = {name: every[name] for name in CASES}
    variants = {name: case for name, case in every.items() if name not in CASES}
    return Reproduction(study, cases, variants, compare(study, every), claims(study, every))


# --- the table -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Stated:
    """A number that the paper prints, with half a unit of its last digit."""

    section: str
    quantity: str
    unit: str
    paper: float
    half_unit: float
    case: str
    figure: str
    comment: str = ""


_F, _D, _G, _X = "hydro-mechanical frequency", "hydraulic damping ratio", "gain margin", "its phase crossover"
_G8, _X8 = "gain_margin_db_eq8", "phase_crossover_hz_eq8"
_READING = "with ten times the loop gain and a valve of 260 Hz, which the paper does not state"

_STATED: Final = (
    _Stated("3", f"{_F}, initial", "Hz", 257, 0.5, "initial", "omega_h_hz", "see the note on the six frequencies"),
    _Stated("3", "valve frequency at ±5 %", "Hz", 250, 0.5, "initial", "valve_hz", "Table I: 1571 rad/s"),
    _Stated("3", "valve frequency at ±90 %", "Hz", 100, 0.5, "initial_large_signal", "valve_hz", "taken from the text"),
    _Stated("4.1", f"{_F}, volume × 2", "Hz", 182, 0.5, "volume_double", "omega_h_hz"),
    _Stated("4.1", f"{_F}, volume ÷ 2", "Hz", 363, 0.5, "volume_half", "omega_h_hz"),
    _Stated("4.1", f"{_D}, volume × 2", "-", 0.15, 0.005, "volume_double", "delta_h"),
    _Stated("4.1", f"{_D}, volume ÷ 2", "-", 0.3, 0.05, "volume_half", "delta_h"),
    _Stated("4.2", f"{_F}, area × 2", "Hz", 513, 0.5, "area_double", "omega_h_hz"),
    _Stated("4.2", f"{_F}, area ÷ 2", "Hz", 128, 0.5, "area_half", "omega_h_hz"),
    _Stated("5", f"{_F}, recommended", "Hz", 726, 0.5, "recommended", "omega_h_hz"),
    _Stated("5", f"{_D}, recommended", "-", 0.3, 0.05, "recommended", "delta_h"),
    _Stated("5", "valve frequency, recommended", "Hz", 250, 0.5, "recommended", "valve_hz", "the initial valve"),
    _Stated("5", "valve frequency, faster valve", "Hz", 400, 0.5, "recommended_fast_valve", "valve_hz", "from the text"),
    _Stated("5", f"{_G}, initial", "dB", 116, 0.5, "initial", "gain_margin_db", "exact form"),
    _Stated("5", f"{_G}, initial", "dB", 116, 0.5, "initial", _G8, "eq. 8 corrected"),
    _Stated("5", f"{_G}, initial", "dB", 116, 0.5, "initial_reading", "gain_margin_db", f"exact form, {_READING}"),
    _Stated("5", f"{_X}, initial", "Hz", 187, 0.5, "initial", "phase_crossover_hz", "exact form"),
    _Stated("5", f"{_X}, initial", "Hz", 187, 0.5, "initial", _X8, "eq. 8 corrected"),
    _Stated("5", f"{_X}, initial", "Hz", 187, 0.5, "initial_reading", "phase_crossover_hz", f"exact form, {_READING}"),
    _Stated("5", f"{_G}, recommended", "dB", 128, 0.5, "recommended", "gain_margin_db", "exact form"),
    _Stated("5", f"{_G}, recommended", "dB", 128, 0.5, "recommended", _G8, "eq. 8 corrected"),
    _Stated("5", f"{_G}, recommended", "dB", 128, 0.5, "recommended_reading", "gain_margin_db", f"exact form, {_READING}"),
    _Stated("5", f"{_X}, recommended", "Hz", 230, 0.5, "recommended", "phase_crossover_hz", "exact form"),
    _Stated("5", f"{_X}, recommended", "Hz", 230, 0.5, "recommended", _X8, "eq. 8 corrected"),
    _Stated("5", f"{_X}, recommended", "Hz", 230, 0.5, "recommended_reading", "phase_crossover_hz", f"exact form, {_READING}"),
)
