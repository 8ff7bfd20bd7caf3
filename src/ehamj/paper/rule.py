"""How far the paper's rule holds that the lesser of two frequencies, the valve's and the load's, limits the bandwidth.

`rule_map` and `rule_curves` show what a proportional loop reaches over both frequencies and the load's damping.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import xarray as xr

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import Array, positive
from ehamj.paper.cases import PaperStudy
from ehamj.paper.loop import PositionLoop
from ehamj.paper.merits import RULE_OF_THREE, FiguresOfMerit
from ehamj.plots import Figure, Line, lines_chart, map_chart


@dataclass(frozen=True)
class RuleStudy:
    """A position loop of an integrator, a resonance (f_h, δ_h) and a valve (f_v, ζ) at the highest gain that keeps two
    margins: eq. 8 and eq. 1 with K_L = 0.

    What it reaches is a function of the frequencies' ratio, times either frequency. K_L and C are left out; the paper's
    designs reach up to 9 % more than the map says at their place.
    """

    hertz: tuple[float, float] = (30.0, 1500.0)
    """Lowest and highest frequency of the map, of valve and hydro-mechanics alike [Hz]."""
    points: int = 161
    """Frequencies of the map, each way."""
    damping: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7)
    """Damping ratios δ_h of the curves [-]."""
    ratios: tuple[float, float] = (0.1, 10.0)
    """Lowest and highest ratio f_h/f_v of the curves [-]."""
    valve_damping: float = FIRST_GENERATION.valve_damping
    """ζ of the valve [-]."""
    gain_margin_db: float = 6.0
    """Gain margin of the loop [dB]."""
    phase_margin_deg: float = 45.0
    """Its phase margin [deg]."""

    def __post_init__(self) -> None:
        for name in ("hertz", "ratios"):
            low, high = getattr(self, name)
            if not 0.0 < low < high < math.inf:
                raise InputError(f"{name} = {(low, high)!r}: must be two rising, positive, finite numbers")
        for value in (*self.damping, self.valve_damping):
            positive("damping", value)
        if self.points < 2:
            raise InputError(f"points = {self.points}: must be at least 2")

    def reach(self, ratio: float, damping: float) -> tuple[float, float]:
        """Bandwidth and gain crossover over the valve's frequency, for f_h/f_v = ``ratio`` [-]."""
        resonance = [1.0 / ratio**2, 2.0 * damping / ratio, 1.0]
        oil = np.polymul([1.0, 0.0], resonance)
        loop = PositionLoop(1.0, np.polymul(oil, [1.0, 2.0 * self.valve_damping, 1.0]))
        gain = loop.highest_gain(self.gain_margin_db, self.phase_margin_deg)
        return loop.bandwidth(gain), loop.gain_crossings(gain)[0]


_REACH: Final = {
    "bandwidth": "closed-loop bandwidth (−3 dB) under proportional control",
    "gain_crossover": "frequency up to which the loop's gain is above 1",
}


def rule_curves(study: RuleStudy | None = None, points: int = 121) -> xr.Dataset:
    """Bandwidth and gain crossover over the lesser of the two frequencies, on (damping, ratio) [-].

    Args:
        study: which curves.
        points: number of ratios.
    """
    study = study or RuleStudy()
    ratios = np.geomspace(*study.ratios, points)
    values = np.array([[study.reach(ratio, damping) for ratio in ratios] for damping in study.damping])
    values /= np.minimum(1.0, ratios)[:, None]
    return _reached(values, "1", {"damping": list(study.damping), "ratio": ratios})


def rule_map(damping: tuple[float, ...], study: RuleStudy | None = None) -> xr.Dataset:
    """Bandwidth and gain crossover [Hz] over valve and hydro-mechanical frequency, on (damping, load_hz, valve_hz).

    Args:
        damping: damping ratios δ_h, one map each.
        study: range and margins.

    Raises:
        InputError: if a damping ratio is not positive.
    """
    study = study or RuleStudy()
    for value in damping:
        positive("damping", value)
    hertz = np.geomspace(*study.hertz, study.points)
    last = study.points - 1
    steps = (hertz[1] / hertz[0]) ** np.arange(-last, last + 1)  # every ratio of two grid points
    rows, columns = np.indices((study.points, study.points))
    reached = np.array([[study.reach(ratio, value) for ratio in steps] for value in damping])
    maps = reached[:, rows - columns + last] * hertz[columns][..., None]
    return _reached(maps, "Hz", {"damping": list(damping), "load_hz": hertz, "valve_hz": hertz})


def _reached(values: Array, unit: str, coordinates: Mapping[str, Any]) -> xr.Dataset:
    over, parts = tuple(coordinates), enumerate(_REACH.items())
    data = {name: (over, values[..., k], {"units": unit, "long_name": text}) for k, (name, text) in parts}
    return xr.Dataset(data, coordinates)


# --- figures -------------------------------------------------------------------------------------------------------

LEVELS: Final = (10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 800.0)
"""Contours of the map [Hz]."""

MARKS: Final = {
    "initial": Line("first prototype, valve at ±5 %", [], [], 1, marker="o"),
    "initial_large_signal": Line("first prototype, valve at ±90 %", [], [], 4, marker="s"),
    "recommended": Line("recommended design", [], [], 0, marker="D"),
    "recommended_fast_valve": Line("recommended design, 400 Hz valve", [], [], 2, marker="^"),
}
"""Looks of the paper's designs in the figures."""


def paper_marks(study: PaperStudy | None = None) -> dict[str, FiguresOfMerit]:
    """What the paper's designs reach, each with its own exact loop, by the names of `MARKS`."""
    study = study or PaperStudy()
    return {name: study.merits(study.design(name), study.mass) for name in MARKS}


def rule_maps(study: RuleStudy | None = None, marks: Mapping[str, FiguresOfMerit] | None = None) -> list[Figure]:
    """The paper's rule: bandwidth over valve and hydro-mechanical frequency, one map per damping ratio of the marks.

    Args:
        study: range and margins.
        marks: designs, by names of `MARKS`; without, the paper's four.
    """
    marks = paper_marks() if marks is None else marks
    dampings = tuple(dict.fromkeys(round(one.delta_h, 9) for one in marks.values()))
    return [
        _map(
            bandwidth,
            [_at_frequencies(name, one) for name, one in marks.items() if round(one.delta_h, 9) == damping],
        )
        for damping, bandwidth in zip(dampings, rule_map(dampings, study)["bandwidth"], strict=True)
    ]


def _map(bandwidth: xr.DataArray, points: list[Line]) -> Figure:
    valve, load = bandwidth.valve_hz.values, bandwidth.load_hz.values
    ends = valve[[0, -1]]
    rules = [
        Line("equal frequencies", ends, ends, 7, 1, width=1.4),
        Line(f"valve {RULE_OF_THREE:g} times as fast", ends, ends / RULE_OF_THREE, 7, 2, width=1.4),
    ]
    return map_chart(
        f"Bandwidth at a damping ratio of {float(bandwidth.damping):.3f}",
        ("valve frequency [Hz]", valve), ("hydro-mechanical frequency [Hz]", load),
        ("closed-loop bandwidth [Hz]", bandwidth.values), points=[*rules, *points], levels=LEVELS, logarithmic="xy",
    )  # fmt: skip


def _at_frequencies(name: str, reached: FiguresOfMerit) -> Line:
    label = f"{MARKS[name].label}: {reached.bandwidth_hz:.0f} Hz"
    return replace(MARKS[name], label=label, x=[reached.valve_hz], y=[reached.omega_h_hz])


def rule_chart(study: RuleStudy | None = None, marks: Mapping[str, FiguresOfMerit] | None = None) -> Figure:
    """Bandwidth and gain crossover over the lesser frequency against the frequencies' ratio; arguments of
    `rule_maps`."""
    curves, marks = rule_curves(study), paper_marks() if marks is None else marks
    panels: dict[str, list[Line]] = {}
    for name in _REACH:
        quantity = f"{name.replace('_', ' ')} / lesser f [-]"
        panels[quantity] = [
            Line(f"δ_h = {float(line.damping):g}", line.ratio, line, k, k // 4) for k, line in enumerate(curves[name])
        ]
        for mark, reached in marks.items():
            height = getattr(reached, f"{name}_hz")
            if height is not None:
                height /= min(reached.valve_hz, reached.omega_h_hz)
                panels[quantity].append(replace(MARKS[mark], x=[1.0 / reached.valve_ratio], y=[height]))
    places = {"equal": 1.0, f"valve {RULE_OF_THREE:g} × faster": 1.0 / RULE_OF_THREE}
    return lines_chart("The rule over the ratio of frequencies", "f_h/f_v [-]", panels, "x", places)
