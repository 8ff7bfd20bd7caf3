"""The paper, reproduced number by number and figure by figure, with what does not reproduce said aloud.

`reproduce` computes every case, `compare` sets every number that the paper states beside it, `write_paper` writes
figures, table and a record that `PaperStudy.from_dict` reads back.
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

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import (
    FAST_VALVE,
    LARGE_SIGNAL_VALVE,
    PAPER_MASS,
    FiguresOfMerit,
    Form,
    Loop,
    bode,
    delta_h,
    figures_of_merit,
    omega_h,
)
from ehamj.plots import BLUE, GREEN, INK, PURPLE, STYLE, VERMILLION

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

VARIANTS: Final[dict[str, tuple[str, Callable[["PaperStudy"], dict[str, float]]]]] = {
    "initial_large_signal": ("initial", lambda study: {"valve_frequency": study.large_signal_valve}),
    "recommended_fast_valve": ("recommended", lambda study: {"valve_frequency": study.fast_valve}),
    "initial_reading": ("initial", lambda study: study.reading()),
    "recommended_reading": ("recommended", lambda study: study.reading()),
}
"""What the paper speaks of beside its cases: the case that it starts from, and the values that it sets."""

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
    "initial_large_signal": "initial design, valve at ±90 % of its signal",
    "recommended_fast_valve": "recommended design, faster valve",
    "initial_reading": "initial design, as the paper's margins read",
    "recommended_reading": "recommended design, as the paper's margins read",
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
            raise InputError(f"case = {name!r}: must be one of {', '.join(LABELS)}")
        base, extra = VARIANTS.get(name, (name, lambda _: {}))
        powers = CASES[base].items()
        values: dict[str, float] = {key: getattr(self.actuator, key) * self.factor**power for key, power in powers}
        return self.actuator.with_values(values | extra(self))

    def reading(self) -> dict[str, float]:
        """The values under which the paper's margins come out [m³/s/mA, rad/s]."""
        return {"flow_gain": self.actuator.flow_gain * self.reading_gain, "valve_frequency": self.reading_valve}

    def figures(self, actuator: Actuator, mass: float | None = None) -> FiguresOfMerit:
        """Figures of merit with the study's margins, under its mass unless another is given [kg]."""
        margins = {"gain_margin_db": self.gain_margin_db, "phase_margin_deg": self.phase_margin_deg}
        return figures_of_merit(actuator, self.mass if mass is None else mass, **margins)

    def to_dict(self) -> dict[str, Any]:
        """The study as plain data, see `from_dict`."""
        plain = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "actuator"}
        return {"actuator": described(self.actuator), **plain}

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Self:
        """The study of a record: a whole ``paper.json``, or its part ``study``.

        Raises:
            InputError: if an entry is missing, unknown or not physical.
        """
        try:
            study = dict(record.get("study", record))
            entries = study.pop("actuator")
            values = {name: entry["value"] for name, entry in entries.items()}
            sources = {name: entry["source"] for name, entry in entries.items()}
            return cls(actuator=Actuator(**values, sources=sources), **study)
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise InputError(f"study: this is no record of one: {error}") from error


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
        """What to call it."""
        if self.name == "recommended_fast_valve":
            return f"recommended design, {self.figures.valve_hz:.0f} Hz valve"
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
    name: str
    unit: str
    paper: float
    value: float
    """What is computed."""
    allowed: tuple[float, float] | None
    """What the rounding of Table I leaves open, to first order; None where nothing is computed from it."""
    verdict: str
    note: str

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
        percent = f" ({100.0 * (self.value / self.paper - 1.0):+.1f} %)" if self.unit == "Hz" else ""
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

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain data, numbers as numbers."""
        return {
            "section": self.section,
            "name": self.name,
            "unit": self.unit,
            "paper": self.paper,
            "computed": self.value,
            "deviation": self.value - self.paper,
            "deviation_percent": 100.0 * (self.value / self.paper - 1.0) if self.unit == "Hz" else None,
            "table_1_allows": list(self.allowed) if self.allowed else None,
            "verdict": self.verdict,
            "note": self.note,
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

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data; `PaperStudy.from_dict` and `reproduce` give the same again."""

        def entry(case: Case) -> dict[str, Any]:
            return {"label": case.label, **case.numbers(), "parameters": described(case.actuator)}

        return {
            "study": self.study.to_dict(),
            "cases": {name: entry(case) for name, case in self.cases.items()},
            "variants": {name: entry(case) for name, case in self.variants.items()},
            "table": [comparison.to_dict() for comparison in self.table],
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
    name: str
    unit: str
    paper: float
    half_unit: float
    case: str
    figure: str
    note: str = ""


_F, _D, _V = "hydro-mechanical frequency", "hydraulic damping ratio", "valve frequency"
_SIX = "256.7 Hz initially would give all six"
_INPUT = "taken from the text, not computed"


def _margins(case: str, label: str, gain_margin: float, crossover: float) -> Iterator[_Stated]:
    """A gain margin and its frequency as the paper prints them, beside each way to compute them."""
    reading = "exact form, ten times the loop gain and a valve of 260 Hz, of which the paper says nothing"
    ways = ((case, "", "exact form"), (case, "_eq8", "eq. 8 corrected"), (f"{case}_reading", "", reading))
    for name, suffix, way in ways:
        yield _Stated("5", f"gain margin, {label}", "dB", gain_margin, 0.5, name, f"gain_margin_db{suffix}", way)
    for name, suffix, way in ways:
        figure = f"phase_crossover_hz{suffix}"
        yield _Stated("5", f"frequency of the gain margin, {label}", "Hz", crossover, 0.5, name, figure, way)


_STATED: Final = (
    _Stated("3", f"{_F}, initial design", "Hz", 257, 0.5, "initial", "omega_h_hz", _SIX),
    _Stated("3", f"{_V} at ±5 %", "Hz", 250, 0.5, "initial", "valve_hz", "1571 rad/s in Table I"),
    _Stated("3", f"{_V} at ±90 %", "Hz", 100, 0.5, "initial_large_signal", "valve_hz", _INPUT),
    _Stated("3", "lag of the valve around its frequency", "deg", 90, 0.5, "initial", "valve_lag_deg", "at 250 Hz"),
    _Stated("4.1", f"{_F}, chamber volume × 2", "Hz", 182, 0.5, "volume_double", "omega_h_hz", _SIX),
    _Stated("4.1", f"{_F}, chamber volume ÷ 2", "Hz", 363, 0.5, "volume_half", "omega_h_hz", _SIX),
    _Stated("4.1", f"{_D}, chamber volume × 2", "-", 0.15, 0.005, "volume_double", "delta_h"),
    _Stated("4.1", f"{_D}, chamber volume ÷ 2", "-", 0.3, 0.05, "volume_half", "delta_h"),
    _Stated("4.2", f"{_F}, piston area × 2", "Hz", 513, 0.5, "area_double", "omega_h_hz", _SIX),
    _Stated("4.2", f"{_F}, piston area ÷ 2", "Hz", 128, 0.5, "area_half", "omega_h_hz", _SIX),
    _Stated("5", f"{_F}, recommended design", "Hz", 726, 0.5, "recommended", "omega_h_hz", _SIX),
    _Stated("5", f"{_D}, recommended design", "-", 0.3, 0.05, "recommended", "delta_h"),
    _Stated("5", f"{_V}, recommended design", "Hz", 250, 0.5, "recommended", "valve_hz", "the initial valve"),
    _Stated("5", f"{_V}, faster valve", "Hz", 400, 0.5, "recommended_fast_valve", "valve_hz", _INPUT),
    *_margins("initial", "initial design", 116, 187),
    *_margins("recommended", "recommended design", 128, 230),
)
"""Every frequency, damping ratio and margin of the paper's text."""

AGREES, ROUNDED, FAILS, GIVEN = (
    "agrees to the printed digit",
    "agrees within the rounding of Table I",
    "does not reproduce",
    "given",
)


def compare(study: PaperStudy, every: Mapping[str, Case]) -> tuple[Comparison, ...]:
    """Every number that the paper states, beside the computed one.

    Args:
        study: what was computed.
        every: cases and variants by name.
    """
    return tuple(_compared(study, every[stated.case].actuator, stated) for stated in _STATED)


def _compared(study: PaperStudy, actuator: Actuator, stated: _Stated) -> Comparison:
    computed = _value(actuator, study.mass, stated.figure)
    if stated.note == _INPUT:
        allowed, verdict = None, GIVEN
    else:
        allowed = _allowed(study, actuator, stated.figure, computed)
        low, high = allowed
        overlaps = low <= stated.paper + stated.half_unit and high >= stated.paper - stated.half_unit
        near = abs(computed - stated.paper) <= stated.half_unit
        verdict = AGREES if near else ROUNDED if overlaps else FAILS
    return Comparison(stated.section, stated.name, stated.unit, stated.paper, computed, allowed, verdict, stated.note)


def _value(actuator: Actuator, mass: float, figure: str) -> float:
    """A figure of merit by name, and no more than that one."""
    if figure == "valve_lag_deg":  # at 250 Hz, eq. 1
        ratio = 2.0 * math.pi * 250.0 / actuator.valve_frequency
        return math.degrees(math.atan2(2.0 * actuator.valve_damping * ratio, 1.0 - ratio**2))
    if figure == "valve_hz":
        return actuator.valve_frequency / (2.0 * math.pi)
    if figure == "omega_h_hz":
        return omega_h(actuator, mass) / (2.0 * math.pi)
    if figure == "delta_h":
        return delta_h(actuator, mass)
    loop = Loop.of_actuator(actuator, mass, "eq8" if figure.endswith("_eq8") else "exact")
    if figure.startswith("gain_margin_db"):
        return 20.0 * math.log10(loop.stability_gain)
    return loop.phase_crossover / (2.0 * math.pi)


def _allowed(study: PaperStudy, actuator: Actuator, figure: str, computed: float) -> tuple[float, float]:
    """Span of a figure when every value of Table I moves by half a unit of its last digit, the worst way, to first
    order; a case that multiplies a value multiplies its rounding."""
    spread = 0.0
    for name, half_unit in ROUNDING.items():
        table = PAPER_MASS if name == "mass" else getattr(FIRST_GENERATION, name)
        ends = []
        for factor in (1.0 + half_unit / table, 1.0 - half_unit / table):
            if name == "mass":
                ends.append(_value(actuator, study.mass * factor, figure))
            else:
                moved = actuator.with_values({name: getattr(actuator, name) * factor})
                ends.append(_value(moved, study.mass, figure))
        spread += 0.5 * abs(ends[0] - ends[1])
    return computed - spread, computed + spread


# --- the claims ----------------------------------------------------------------------------------------------------


def claims(study: PaperStudy, every: Mapping[str, Case]) -> tuple[Claim, ...]:
    """What the paper states in words, and what the numbers say to it."""
    f = {name: case.figures for name, case in every.items()}
    first, last, fast, slow = (
        f[name] for name in ("initial", "recommended", "recommended_fast_valve", "initial_large_signal")
    )
    first_read, last_read = f["initial_reading"], f["recommended_reading"]
    recommended = study.design("recommended")
    tight = study.figures(recommended.with_values({"flow_pressure": study.actuator.flow_pressure}))
    quarter = study.figures(study.design("initial"), study.mass / 4.0)
    keeps = f"the highest proportional gain with {study.gain_margin_db:g} dB and {study.phase_margin_deg:g}°"
    shift = f["flow_gain_half"].gain_margin_db - first.gain_margin_db
    smaller = 20.0 * math.log10(first.velocity_gain / last.velocity_gain)
    return (
        Claim("2.2", "Eq. 8, as printed", _printed_equation(study)),
        Claim("3 to 5", "Hydro-mechanical frequencies of 257, 182, 363, 513, 128 and 726 Hz", _six(first.omega_h_hz)),
        Claim(
            "3",
            "One actuator under a machine load of 4 tonnes",
            f"The whole machine on one actuator. A mount of four carries a quarter: {quarter.omega_h_hz:.0f} Hz and a "
            f"damping ratio of {quarter.delta_h:.3f}, so the paper's numbers are not those of the four-mount machine.",
        ),
        Claim(
            "3",
            "The closed-loop bandwidth is limited by the lesser of valve and hydro-mechanical frequency",
            f"As a limit, yes: with {keeps}, {first.bandwidth_hz:.0f} Hz of {first.valve_hz:.0f} Hz for the initial "
            f"design and {last.bandwidth_hz:.0f} Hz of {last.valve_hz:.0f} Hz for the recommended one. But the loop "
            f"corrects errors only up to its gain crossover, {first.gain_crossover_hz:.0f} and "
            f"{last.gain_crossover_hz:.0f} Hz.",
        ),
        Claim(
            "3",
            "With the valve at ±90 % control stays below 100 Hz",
            f"The same loop then has {slow.bandwidth_hz:.0f} Hz of bandwidth (3 dB below a static gain that is itself "
            f"below 1) and its gain crossover at {slow.gain_crossover_hz:.0f} Hz.",
        ),
        Claim(
            "4.1",
            "A larger chamber lowers the bandwidth",
            f"{f['volume_double'].bandwidth_hz:.0f} Hz with twice the volume, {first.bandwidth_hz:.0f} Hz as it is, "
            f"{f['volume_half'].bandwidth_hz:.0f} Hz with half.",
        ),
        Claim(
            "4.2",
            "A larger piston is preferable although it lowers the damping",
            f"Damping ratio {f['area_double'].delta_h:.3f} instead of {first.delta_h:.3f}; gain crossover "
            f"{f['area_double'].gain_crossover_hz:.0f} instead of {first.gain_crossover_hz:.0f} Hz. Merritt's limit "
            "2δ_hω_h = 4βK_C/V_t does not know the area.",
        ),
        Claim(
            "4.3",
            "The flow gain is a gain only",
            f"Halving it moves the gain margin by {shift:+.2f} dB and the crossover by "
            f"{f['flow_gain_half'].phase_crossover_hz - first.phase_crossover_hz:.0e} Hz.".replace("0e+00", "0"),
        ),
        Claim(
            "4.3",
            "Damping is proportional to the flow-pressure coefficient",
            f"{f['flow_pressure_half'].delta_h:.4f}, {first.delta_h:.4f}, {f['flow_pressure_double'].delta_h:.4f}.",
        ),
        Claim(
            "5",
            "Small chamber, large piston and high flow-pressure coefficient together make the loop fast",
            f"Gain crossover {first.gain_crossover_hz:.0f} Hz initially, "
            f"{f['area_double'].gain_crossover_hz:.0f} Hz with the piston alone, {tight.gain_crossover_hz:.0f} Hz with "
            f"piston and chamber, {last.gain_crossover_hz:.0f} Hz with all three: it is the piston that does it, and "
            "with it the additional leakage costs a little.",
        ),
        Claim(
            "5",
            "A gain margin of 128 dB is far superior to 116 dB",
            f"Their difference comes out ({last.gain_margin_db - first.gain_margin_db:.1f} dB), but {smaller:.1f} dB "
            "of it only say that a piston of twice the area moves half as fast per volt. What a loop gains is its "
            f"velocity gain at the limit: {first.velocity_gain_limit:.0f} and {last.velocity_gain_limit:.0f} 1/s.",
        ),
        Claim(
            "5",
            "Gain margins of 116 and 128 dB",
            f"Table I gives {first.gain_margin_db - 116:.1f} and {last.gain_margin_db - 128:.1f} dB more: a factor of "
            "ten in loop gain. With ten times the flow gain and a valve of 260 Hz margins and frequencies come out "
            f"({first_read.gain_margin_db:.1f} dB at {first_read.phase_crossover_hz:.1f} Hz, "
            f"{last_read.gain_margin_db:.1f} dB at {last_read.phase_crossover_hz:.1f} Hz). Table I stays the default.",
        ),
        Claim(
            "5",
            "A valve of 400 Hz makes it better still",
            f"Bandwidth {fast.bandwidth_hz:.0f} instead of {last.bandwidth_hz:.0f} Hz, gain crossover "
            f"{fast.gain_crossover_hz:.0f} instead of {last.gain_crossover_hz:.0f} Hz.",
        ),
        Claim(
            "5",
            "The frequencies of the recommended design are very well separated",
            f"By a factor of {1 / last.valve_ratio:.1f}, with the valve below the load. Valve makers ask for three "
            f"times above it; here it is {last.valve_ratio:.2f} ({fast.valve_ratio:.2f} with the faster valve).",
        ),
    )


def _printed_equation(study: PaperStudy) -> str:
    crossings, shifts = [], []
    for name in ("initial", "recommended"):
        design = study.design(name)
        w, d = omega_h(design, study.mass), delta_h(design, study.mass)
        hertz = np.linspace(1.0, w / (2.0 * math.pi), 20001)[:-1]  # below the resonance its pole pair adds no phase
        _, phase = bode(design, study.mass, hertz, "eq8-printed")
        crossings.append(f"{np.interp(180.0, -phase, hertz):.0f} Hz")
        shifts.append(f"{100.0 * (math.sqrt(1.0 + 2.0 * d / w) - 1.0):.3f}")
    return (
        "The damping term lacks its s. As printed it adds a time to a number; taken as numbers it is an undamped "
        f"resonance, {' and '.join(shifts)} % above ω_h for the initial and the recommended design, with an infinite "
        f"peak and a jump in phase, and −180° would be passed at {' and '.join(crossings)}. The paper's own "
        "frequencies do not come from it; the term must read 2δ_h s/ω_h."
    )


def _six(computed: float) -> str:
    """Which initial frequency gives all six printed ones."""
    ratios = {257: 1.0, 182: 2**-0.5, 363: 2**0.5, 513: 2.0, 128: 0.5, 726: 8**0.5}
    low = max((printed - 0.5) / ratio for printed, ratio in ratios.items())
    high = min((printed + 0.5) / ratio for printed, ratio in ratios.items())
    return (
        f"All six follow from one initial frequency between {low:.2f} and {high:.2f} Hz. Table I as printed gives "
        f"{computed:.2f} Hz, {100 * (low / computed - 1):.1f} % less; its rounding (the bulk modulus has two digits) "
        "leaves ten times that open."
    )


# --- figures -------------------------------------------------------------------------------------------------------

FIGURES: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "figure-3": ("Open loop of the initial design: exact, and eq. 8 corrected and as printed", ("initial",)),
    "figure-4": ("Sensitivity of the open loop to the chamber volume", ("initial", "volume_double", "volume_half")),
    "figure-5": ("Sensitivity of the open loop to the piston area", ("initial", "area_double", "area_half")),
    "figure-6a": ("Sensitivity of the open loop to the flow gain", ("initial", "flow_gain_double", "flow_gain_half")),
    "figure-6b": (
        "Sensitivity of the open loop to the flow-pressure coefficient",
        ("initial", "flow_pressure_double", "flow_pressure_half"),
    ),
    "figure-7": (
        "Open loop of the initial and the recommended design, and of the latter with a faster valve",
        ("initial", "recommended", "recommended_fast_valve"),
    ),
}
"""The paper's figures: caption and cases. The paper numbers its last one 5 a second time; the text calls it 7."""

SYMBOLS: Final = {
    f"{name}_{change}": f"{words} ${symbol}$ {sign} 2"
    for name, words, symbol in (
        ("volume", "volume", "V_t"),
        ("area", "piston area", "A_p"),
        ("flow_gain", "flow gain", "K_Q"),
        ("flow_pressure", "flow-pressure", "K_C"),
    )
    for change, sign in (("double", "×"), ("half", "÷"))
}
"""What the figures call the cases."""

LINES: Final = ((BLUE, "-", 1.9), (VERMILLION, (0, (6, 1.6)), 1.6), (GREEN, (0, (3, 1.2, 1, 1.2)), 1.6))
"""Colour, dash and width of the first, second and third line."""

SPAN: Final = (1.0, 2000.0)
"""Frequencies that the figures show [Hz]."""


@contextmanager
def figure_style() -> Iterator[None]:
    """Matplotlib's settings for the studies' figures: symbols are set as mathematics, letters are drawn as shapes."""
    import matplotlib

    settings: Any = STYLE | {"text.parse_math": True, "mathtext.fontset": "dejavusans", "svg.fonttype": "path"}
    with matplotlib.rc_context(settings):
        yield


def figure(reproduction: Reproduction, name: str) -> "Figure":
    """One of the paper's `FIGURES`, drawn anew.

    Raises:
        InputError: if there is no such figure.
    """
    if name not in FIGURES:
        raise InputError(f"figure = {name!r}: must be one of {', '.join(FIGURES)}")
    every = reproduction.cases | reproduction.variants
    chosen = [every[case] for case in FIGURES[name][1]]
    mass = reproduction.study.mass
    if name == "figure-3":
        forms: tuple[tuple[Form, str], ...] = (
            ("exact", "exact, third order"),
            ("eq8", "eq. 8, damping term corrected"),
            ("eq8-printed", "eq. 8 as printed (undamped)"),
        )
        return bode_figure([Line(label, chosen[0].actuator, mass, form) for form, label in forms])
    return bode_figure([Line(SYMBOLS.get(case.name, case.label), case.actuator, mass) for case in chosen])


@dataclass(frozen=True)
class Line:
    """One line of a Bode plot."""

    label: str
    actuator: Actuator
    mass: float
    form: Form = "exact"


def bode_figure(lines: list[Line]) -> "Figure":
    """Magnitude and phase of G_EHA (eq. 9) of several designs, three at most.

    Rings mark the hydro-mechanical frequency, diamonds the phase crossover; vertical lines mark the valves.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    with figure_style():
        drawing = Figure(figsize=(5.6, 5.0), layout="constrained")
        above, below = drawing.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (1.15, 1.0)})
        handles = []
        for before, line, (color, dash, width) in zip([None, *lines], lines, LINES, strict=False):
            look: dict[str, Any] = {"color": color, "linestyle": dash, "linewidth": width}
            _draw(above, below, line, look)
            handles.append(Line2D([], [], label=_legend_text(line, before), **look))
        _axes(above, below, lines)
        above.legend(handles=handles, loc="lower left")
        mark: dict[str, Any] = {"linestyle": "none", "color": INK, "markerfacecolor": "white"}
        rings = Line2D([], [], marker="o", markersize=5.5, label="hydro-mechanical frequency $f_h$", **mark)
        diamonds = Line2D([], [], marker="D", markersize=4.8, label="phase crossover at −180°", **mark)
        below.legend(handles=[rings, diamonds], loc="lower left")
    return drawing


def _legend_text(line: Line, before: Line | None) -> str:
    """The label, and what is new in this line's resonance."""
    told = [
        None if one is None else (omega_h(one.actuator, one.mass) / (2.0 * math.pi), delta_h(one.actuator, one.mass))
        for one in (line, before)
    ]
    if told[0] is None or told[0] == told[1]:
        return line.label
    return f"{line.label} ($f_h$ = {told[0][0]:.0f} Hz, $\\delta_h$ = {told[0][1]:.3f})"


def _draw(above: "Axes", below: "Axes", line: Line, look: dict[str, Any]) -> None:
    resonance = omega_h(line.actuator, line.mass) / (2.0 * math.pi)
    around = resonance * (1.0 + np.linspace(-0.02, 0.02, 401))
    hertz = np.unique(np.concatenate([np.geomspace(*SPAN, 1200), around]))
    magnitude, phase = _decibels(line, hertz)
    above.semilogx(hertz, magnitude, **look)
    below.semilogx(hertz, phase, **look)
    if line.form == "eq8-printed":
        return
    crossover = Loop.of_actuator(line.actuator, line.mass, line.form).phase_crossover / (2.0 * math.pi)
    for at, marker, size in ((resonance, "o", 5.5), (crossover, "D", 4.8)):
        values = _decibels(line, np.array([at]))
        for axes, value in zip((above, below), values, strict=True):
            axes.plot(at, value, marker, color=look["color"], markerfacecolor="white", markersize=size, zorder=4)


def _decibels(line: Line, hertz: Array) -> tuple[Array, Array]:
    magnitude, phase = bode(line.actuator, line.mass, hertz, line.form)
    return 20.0 * np.log10(magnitude), phase


def _axes(above: "Axes", below: "Axes", lines: list[Line]) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, MultipleLocator, NullFormatter

    above.set_xlim(*SPAN)
    above.set_ylim(-200.0, -90.0)
    above.yaxis.set_major_locator(MultipleLocator(20.0))
    above.set_ylabel("magnitude [dB re 1 m/V]")
    below.set_ylim(-460.0, 10.0)
    below.yaxis.set_major_locator(MultipleLocator(90.0))
    below.set_ylabel("phase [deg]")
    below.set_xlabel("frequency [Hz]")
    below.axhline(-180.0, color="#8A939C", linewidth=0.9, zorder=1)
    below.xaxis.set_major_locator(FixedLocator([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000]))
    below.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    below.xaxis.set_minor_formatter(NullFormatter())
    for axes in (above, below):
        axes.grid(which="minor", axis="x", linewidth=0.4)
    valves = sorted({line.actuator.valve_frequency / (2.0 * math.pi) for line in lines})
    sides = ("center",) if len(valves) == 1 else ("right", "left")
    for valve, side in zip(valves, sides, strict=False):
        for axes in (above, below):
            axes.axvline(valve, color=PURPLE, linewidth=1.1, linestyle=(0, (1, 1.5)), zorder=1.5)
        place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
        text = f"valve {valve:.0f} Hz"
        above.annotate(text, (valve, 1.0), (0, 2), ha=side, va="bottom", fontsize=8.8, color=PURPLE, **place)


# --- files ---------------------------------------------------------------------------------------------------------


def write_paper(folder: Path, study: PaperStudy | None = None) -> list[Path]:
    """Write the paper's figures (SVG, PNG), its table (CSV, HTML with everything) and ``paper.json`` into a folder.

    Returns:
        What was written, ``table.html`` first.

    Raises:
        InputError: if the study is not physical.
    """
    reproduction = reproduce(study)
    folder.mkdir(parents=True, exist_ok=True)
    page, table, record = (folder / name for name in ("table.html", "table.csv", "paper.json"))
    drawings = []
    for name in FIGURES:
        drawings += save_figure(figure(reproduction, name), folder, name)
    rows = [comparison.to_dict() for comparison in reproduction.table]
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    record.write_text(json.dumps(reproduction.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
    page.write_text(table_html(reproduction), "utf-8")
    return [page, table, record, *drawings]


def save_figure(drawing: "Figure", folder: Path, name: str) -> list[Path]:
    """Save a figure as ``name.svg`` and ``name.png`` (300 dpi); the same figure gives the same bytes."""
    paths = [folder / f"{name}.svg", folder / f"{name}.png"]
    with figure_style():
        drawing.savefig(paths[0], metadata={"Date": None})
        drawing.savefig(paths[1], dpi=300)
    return paths


def table_html(reproduction: Reproduction) -> str:
    """The table, the claims and the figures as one page; it looks for the figures in its own folder."""
    rows = "\n".join(_html_row(comparison) for comparison in reproduction.table)
    told = "\n".join(f"<tr>{_cells(c.section, c.statement, c.finding)}</tr>" for c in reproduction.claims)
    figures = "\n".join(
        f'<figure><img src="{name}.svg" alt="{html.escape(caption)}">'
        f"<figcaption>{name.replace('-', ' ').capitalize()}. {html.escape(caption)}.</figcaption></figure>"
        for name, (caption, _) in FIGURES.items()
    )
    return _PAGE.format(rows=rows, claims=told, figures=figures)


def _cells(*texts: str) -> str:
    return "".join(f"<td>{html.escape(text)}</td>" for text in texts)


def _html_row(row: Comparison) -> str:
    numbers = _cells(row.section, row.name, row.stated, row.computed, row.deviation, row.allowed_text)
    kind = {FAILS: "fails", GIVEN: "given"}.get(row.verdict, "agrees")
    return f'<tr>{numbers}<td class="{kind}">{html.escape(row.verdict)}</td>{_cells(row.note)}</tr>'


_PAGE: Final = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>The paper, reproduced</title>
<style>
body {{ font: 15px/1.5 'Segoe UI', Roboto, Helvetica, Arial, sans-serif; color: #1F2933; max-width: 75rem;
  margin: 2rem auto; padding: 0 1rem; }}
.wide {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 14px; }}
th, td {{ text-align: left; vertical-align: top; padding: .3rem .7rem; border-bottom: 1px solid #E4E7EB; }}
th {{ border-bottom: 2px solid #8A939C; }}
.values :is(td, th):nth-child(n+3):nth-child(-n+6) {{ text-align: right; white-space: nowrap;
  font-variant-numeric: tabular-nums; }}
.agrees {{ color: #00664B; }} .fails {{ color: #B00020; font-weight: 600; }} .given {{ color: #6E7781; }}
.figures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1.5rem; }}
figure {{ margin: 0; }} img {{ width: 100%; }} figcaption {{ font-size: 14px; }}
</style></head><body>
<h1>The paper, reproduced</h1>
<p>Every number that <em>Design guidelines for an electro-hydraulic actuator to isolate machines from vibrations</em>
states, beside what its equations give with its Table I. "Table I allows" is what the rounding of its values leaves
open.</p>
<div class="wide"><table class="values"><thead><tr><th>Section</th><th>Number</th><th>Paper</th><th>Computed</th>
<th>Deviation</th><th>Table I allows</th><th>Verdict</th><th>Comment</th></tr></thead><tbody>
{rows}
</tbody></table></div>
<h2>What the paper says in words</h2>
<div class="wide"><table><thead><tr><th>Section</th><th>Statement</th><th>What the numbers say</th></tr></thead><tbody>
{claims}
</tbody></table></div>
<h2>The figures</h2>
<div class="figures">
{figures}
</div>
</body></html>
"""
