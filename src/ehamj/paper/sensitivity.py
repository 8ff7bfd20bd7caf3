"""What each parameter does to each figure of merit, and how far the paper's rule holds.

`one_at_a_time` multiplies and divides every parameter, `elasticities` are the slopes d ln f/d ln p where the design
is, `rule_map` and `rule_curves` show what a proportional loop reaches over the valve's and the load's frequency and the
load's damping.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.paper.actuator import PAPER_MASS, RULE_OF_THREE, FiguresOfMerit, Loop, figures_of_merit
from ehamj.paper.paper import LINEAR, PaperStudy, figure_style, save_figure
from ehamj.plots import BLUE, GREEN, INK, ORANGE, VERMILLION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

PARAMETERS: Final = ("mass", *LINEAR)
"""Every parameter of the linear actuator."""

SYMBOLS: Final = {"mass": "M"} | {name: Actuator.quantities()[name][1] for name in LINEAR}

MERITS: Final[dict[str, tuple[str, str, Callable[[FiguresOfMerit], float | None]]]] = {
    "hydraulic_stiffness": ("N/m", "hydraulic stiffness K_h", lambda f: f.hydraulic_stiffness),
    "omega_h": ("rad/s", "hydro-mechanical frequency ω_h", lambda f: f.omega_h),
    "delta_h": ("-", "hydraulic damping ratio δ_h", lambda f: f.delta_h),
    "resonance": ("Hz", "load resonance, exact", lambda f: f.resonance_hz),
    "resonance_damping": ("-", "its damping ratio, exact", lambda f: f.resonance_damping),
    "break_frequency": ("rad/s", "break frequency K_C K_L/A_p²", lambda f: f.break_frequency),
    "velocity_gain": ("m/s/V", "velocity gain K_v K_Q/A_p", lambda f: f.velocity_gain),
    "merritt_limit": ("1/s", "Merritt's limit 2δ_hω_h", lambda f: f.merritt_limit),
    "gain_margin": ("V/m", "gain margin (ratio)", lambda f: 10.0 ** (f.gain_margin_db / 20.0)),
    "phase_crossover": ("Hz", "phase crossover", lambda f: f.phase_crossover_hz),
    "velocity_gain_limit": ("1/s", "velocity gain at the limit", lambda f: f.velocity_gain_limit),
    "gain_crossover": ("Hz", "gain crossover, closed loop", lambda f: f.gain_crossover_hz),
    "bandwidth": ("Hz", "bandwidth, closed loop", lambda f: f.bandwidth_hz),
}
"""Figures of merit with unit, name and where to find them; all of them positive, so that they have a logarithm."""

STEP: Final = 2e-3
"""Step of ln p for the slopes; two of them, extrapolated, leave 1e-10."""


@dataclass(frozen=True)
class SensitivityStudy:
    """A design and what is asked of its loop.

    Raises:
        InputError: if a factor is not a positive number.
    """

    actuator: Actuator = FIRST_GENERATION
    mass: float = PAPER_MASS
    """Translating mass [kg]."""
    factors: tuple[float, ...] = (0.5, 1.0, 2.0)
    """By which each parameter is multiplied, one at a time."""
    gain_margin_db: float = 6.0
    """Gain margin of the closed loop [dB]."""
    phase_margin_deg: float = 45.0
    """Its phase margin [deg]."""

    def __post_init__(self) -> None:
        for factor in self.factors:
            if not 0.0 < factor < math.inf:
                raise InputError(f"factors = {self.factors!r}: each must be a positive, finite number")

    def values(self, parameter: str, factor: float) -> dict[str, float]:
        """Every one of `MERITS` with one parameter multiplied; NaN where a figure does not exist.

        Raises:
            InputError: if there is no such parameter, or the changed design has no such figures.
        """
        if parameter not in PARAMETERS:
            raise InputError(f"parameter = {parameter!r}: must be one of {', '.join(PARAMETERS)}")
        actuator, mass = self.actuator, self.mass
        if parameter == "mass":
            mass = mass * factor
        else:
            actuator = actuator.with_values({parameter: getattr(actuator, parameter) * factor})
        margins = {"gain_margin_db": self.gain_margin_db, "phase_margin_deg": self.phase_margin_deg}
        found = figures_of_merit(actuator, mass, **margins)
        taken = {name: take(found) for name, (_, _, take) in MERITS.items()}
        return {name: math.nan if value is None else value for name, value in taken.items()}


def one_at_a_time(study: SensitivityStudy | None = None) -> xr.Dataset:
    """Figures of merit with each parameter multiplied by each factor, the others kept.

    Returns:
        One variable per figure (`MERITS`), each over (parameter, factor), with units.

    Raises:
        InputError: if the design has no such figures (see `ehamj.paper.actuator.figures_of_merit`).
    """
    study = study or SensitivityStudy()
    table = [[study.values(parameter, factor) for factor in study.factors] for parameter in PARAMETERS]
    variables = {
        name: (("parameter", "factor"), [[cell[name] for cell in row] for row in table], _attributes(name))
        for name in MERITS
    }
    return xr.Dataset(variables, _coordinates() | {"factor": list(study.factors)})


def elasticities(study: SensitivityStudy | None = None) -> xr.DataArray:
    """Normalised local derivatives d ln f/d ln p [-]: by how many per cent a figure moves with one per cent.

    Central differences of ln f, extrapolated (Richardson), good to 1e-8. The gain that keeps two margins has a kink
    where the deciding one changes, and the bandwidth jumps where a dip of the closed loop just reaches −3 dB; closer to
    either than `STEP` there is no slope to find.

    Returns:
        Over (figure, parameter).

    Raises:
        InputError: as `one_at_a_time`.
    """
    study = study or SensitivityStudy()
    study.values("mass", 1.0)  # refuse the design as it is, not as it is varied
    columns = []
    for parameter in PARAMETERS:

        def logarithms(step: float, parameter: str = parameter) -> Array:
            values = np.array(list(study.values(parameter, math.exp(step)).values()))
            with np.errstate(divide="ignore"):
                return np.log(values)

        with np.errstate(invalid="ignore"):
            wide, near = ((logarithms(h) - logarithms(-h)) / (2.0 * h) for h in (STEP, 0.5 * STEP))
        columns.append((4.0 * near - wide) / 3.0)
    names = ("figure", [name for _, name, _ in MERITS.values()])
    coordinates = {"figure": list(MERITS), "name": names} | _coordinates()
    attributes = {"units": "1", "long_name": "d ln figure / d ln parameter"}
    return xr.DataArray(np.array(columns).T, coordinates, ("figure", "parameter"), "elasticity", attributes)


def _attributes(name: str) -> dict[str, str]:
    unit, long_name, _ = MERITS[name]
    return {"units": unit, "long_name": long_name}


def _coordinates() -> dict[str, Any]:
    return {"parameter": list(PARAMETERS), "symbol": ("parameter", [SYMBOLS[name] for name in PARAMETERS])}


# --- the paper's rule ----------------------------------------------------------------------------------------------


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
            if not 0.0 < value < math.inf:
                raise InputError(f"damping = {value!r}: must be a positive, finite number")
        if self.points < 2:
            raise InputError(f"points = {self.points}: must be at least 2")

    def reach(self, ratio: float, damping: float) -> tuple[float, float]:
        """Bandwidth and gain crossover over the valve's frequency, for f_h/f_v = ``ratio`` [-]."""
        resonance = [1.0 / ratio**2, 2.0 * damping / ratio, 1.0]
        oil = np.polymul([1.0, 0.0], resonance)
        loop = Loop(1.0, np.asarray(np.polymul(oil, [1.0, 2.0 * self.valve_damping, 1.0]), np.float64))
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
        if not 0.0 < value < math.inf:
            raise InputError(f"damping = {value!r}: must be a positive, finite number")
    hertz = np.geomspace(*study.hertz, study.points)
    last = study.points - 1
    steps = (hertz[1] / hertz[0]) ** np.arange(-last, last + 1)  # every ratio of two grid points
    rows, columns = np.indices((study.points, study.points))
    maps = []
    for value in damping:
        reached = np.array([study.reach(ratio, value) for ratio in steps])
        maps.append(reached[rows - columns + last] * hertz[columns][..., None])
    return _reached(np.array(maps), "Hz", {"damping": list(damping), "load_hz": hertz, "valve_hz": hertz})


def _reached(values: Array, unit: str, coordinates: Mapping[str, Any]) -> xr.Dataset:
    return xr.Dataset(
        {
            name: (tuple(coordinates), values[..., k], {"units": unit, "long_name": text})
            for k, (name, text) in enumerate(_REACH.items())
        },
        coordinates,
    )


@dataclass(frozen=True)
class Mark:
    """A design in the map, with what its own exact loop reaches."""

    label: str
    figures: FiguresOfMerit
    color: str
    marker: str


def paper_marks(study: PaperStudy | None = None) -> tuple[Mark, ...]:
    """Both prototypes (valve at ±5 and at ±90 %), the recommendation, and the recommendation with the 400 Hz valve."""
    study = study or PaperStudy()
    chosen = (
        ("initial", "first prototype, valve at ±5 %", VERMILLION, "o"),
        ("initial_large_signal", "first prototype, valve at ±90 %", ORANGE, "s"),
        ("recommended", "recommended design", BLUE, "D"),
        ("recommended_fast_valve", "recommended design, 400 Hz valve", GREEN, "^"),
    )
    return tuple(Mark(text, study.figures(study.design(name)), color, sign) for name, text, color, sign in chosen)


# --- figures -------------------------------------------------------------------------------------------------------

LEVELS: Final = (10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 800.0)
"""Contours of the map [Hz]."""


def rule_figure(study: RuleStudy | None = None, marks: tuple[Mark, ...] | None = None) -> "Figure":
    """The paper's rule: bandwidth over both frequencies at the marks' damping ratios, and both measures over the lesser
    frequency against the ratio.

    Args:
        study: range and margins.
        marks: designs; without, the paper's four.
    """
    from matplotlib.figure import Figure

    study = study or RuleStudy()
    marks = paper_marks() if marks is None else marks
    of_marks = (round(mark.figures.delta_h, 9) for mark in marks)
    dampings = tuple(dict.fromkeys((*of_marks, *study.damping, 0.2, 0.3)))[:2]
    maps, curves = rule_map(dampings, study), rule_curves(study)
    with figure_style():
        drawing = Figure(figsize=(7.6, 7.4), layout="constrained")
        upper, lower = drawing.subplots(2, 2, gridspec_kw={"height_ratios": (1.15, 1.0)})
        for axes, damping in zip(upper, dampings, strict=False):
            filled = _draw_map(axes, maps["bandwidth"].sel(damping=damping))
            own = [mark for mark in marks if round(mark.figures.delta_h, 9) == damping]
            for mark in sorted(own, key=lambda mark: mark.figures.valve_hz):
                _mark_map(axes, mark, left=mark.figures.valve_hz == min(one.figures.valve_hz for one in own))
            axes.set_title(f"bandwidth, $\\delta_h$ = {damping:.3f}")
        bar = drawing.colorbar(filled, ax=list(upper), shrink=0.9, pad=0.01, ticks=list(LEVELS))
        bar.ax.set_yticklabels([f"{level:g}" for level in LEVELS])
        bar.ax.minorticks_off()
        bar.set_label("closed-loop bandwidth [Hz]")
        for axes, (name, title) in zip(
            lower,
            (("bandwidth", "bandwidth / lesser frequency"), ("gain_crossover", "gain crossover / lesser frequency")),
            strict=True,
        ):
            _draw_curves(axes, curves[name])
            for mark in marks:
                _mark_curves(axes, mark, name)
            axes.set_title(title)
        lower[1].legend(loc="lower right", title="damping ratio $\\delta_h$", ncols=2)
        drawing.legend(handles=[_handle(mark) for mark in marks], loc="outside lower center", ncols=2)
    return drawing


def _draw_map(axes: "Axes", bandwidth: xr.DataArray) -> Any:
    from matplotlib.colors import LogNorm

    valve, load = bandwidth.valve_hz.values, bandwidth.load_hz.values
    norm = LogNorm(LEVELS[0], LEVELS[-1])
    filled = axes.pcolormesh(valve, load, bandwidth.values, norm=norm, cmap="cividis", shading="gouraud")
    filled.set_rasterized(True)
    lines = axes.contour(valve, load, bandwidth.values, LEVELS, colors="white", linewidths=0.8)
    top, right = int(0.9 * len(load)), int(0.9 * len(valve))
    places = [(valve[np.argmin(np.abs(bandwidth.values[top] - level))], load[top]) for level in LEVELS]
    places += [(valve[right], load[np.argmin(np.abs(bandwidth.values[:, right] - level))]) for level in LEVELS]
    apart = [place for place in places if 1.1 * valve[0] < min(place) < 0.45 * max(place)]
    axes.clabel(lines, fmt="%g", fontsize=7.5, manual=apart)
    axes.set(xscale="log", yscale="log", xlabel="valve frequency [Hz]")
    axes.set_ylabel("hydro-mechanical frequency [Hz]")
    ends = np.array([valve[0], valve[-1]])
    axes.plot(ends, ends, color="white", linewidth=1.4, linestyle=(0, (5, 2)))
    axes.plot(ends, ends / RULE_OF_THREE, color="white", linewidth=1.1, linestyle=(0, (1, 1.5)))
    axes.set(xlim=tuple(ends), ylim=(load[0], load[-1]))
    axes.set_aspect("equal")
    axes.grid(False)
    _plain(axes, "xy", (30, 50, 100, 200, 500, 1000))
    words = {"rotation": 45, "rotation_mode": "anchor", "color": "white", "fontsize": 7.8}
    axes.text(34, 36.5, "$f_h = f_v$", **words)  # type: ignore[arg-type]
    axes.text(125, 125 / 2.72, "$f_v = 3 f_h$", **words)  # type: ignore[arg-type]
    return filled


def _mark_map(axes: "Axes", mark: Mark, left: bool) -> None:
    place = (mark.figures.valve_hz, mark.figures.omega_h_hz)
    axes.plot(*place, mark.marker, color=mark.color, markersize=8, markeredgecolor="white", markeredgewidth=1.2)
    text = axes.annotate(
        f"{mark.figures.bandwidth_hz:.0f} Hz",
        place,
        (-7 if left else 7, 0),
        textcoords="offset points",
        ha="right" if left else "left",
        va="center",
        fontsize=8.8,
        color="white",
        fontweight="bold",
    )
    _outline(text)


def _outline(text: Any) -> None:
    from matplotlib.patheffects import withStroke

    text.set_path_effects([withStroke(linewidth=2.0, foreground=INK)])


def _draw_curves(axes: "Axes", curves: xr.DataArray) -> None:
    from matplotlib import colormaps

    shades = colormaps["viridis"](np.linspace(0.0, 0.9, curves.sizes["damping"]))
    for shade, line in zip(shades, curves, strict=True):
        axes.semilogx(line.ratio, line, color=tuple(shade), linewidth=1.5, label=f"{float(line.damping):g}")
    axes.axvline(1.0, color="#8A939C", linewidth=0.9, zorder=1)
    axes.axvline(1.0 / RULE_OF_THREE, color="#8A939C", linewidth=0.9, linestyle=(0, (1, 1.5)), zorder=1)
    axes.set_xlim(float(curves.ratio[0]), float(curves.ratio[-1]))
    axes.set_ylim(0.0, None)
    axes.set_xlabel("$f_h / f_v$: left, the valve is faster; right, the load")
    _plain(axes, "x", (0.1, 0.2, 0.5, 1, 2, 5, 10))


def _mark_curves(axes: "Axes", mark: Mark, name: str) -> None:
    figures = mark.figures
    reached = figures.bandwidth_hz if name == "bandwidth" else figures.gain_crossover_hz
    if reached is None:
        return
    height = reached / min(figures.valve_hz, figures.omega_h_hz)
    axes.plot(1.0 / figures.valve_ratio, height, mark.marker, color=mark.color, markersize=7, markeredgecolor="white")


def _handle(mark: Mark) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], linestyle="none", marker=mark.marker, color=mark.color, markersize=7, label=mark.label)


def _plain(axes: "Axes", which: str, ticks: tuple[float, ...]) -> None:
    """Ticks of a logarithmic axis as plain numbers."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

    for letter in which:
        axis = axes.xaxis if letter == "x" else axes.yaxis
        axis.set_major_locator(FixedLocator(list(ticks)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def elasticity_figure(table: xr.DataArray | None = None) -> "Figure":
    """`elasticities` as a coloured table: by how many per cent a figure moves with one per cent of a parameter."""
    from matplotlib.figure import Figure

    table = elasticities() if table is None else table
    with figure_style():
        drawing = Figure(figsize=(7.6, 4.6), layout="constrained")
        axes = drawing.subplots()
        shown = axes.imshow(table.values, cmap="RdBu_r", vmin=-2.0, vmax=2.0, aspect="auto")
        for (row, column), value in np.ndenumerate(table.values):
            if np.isfinite(value) and abs(value) >= 0.005:
                dark = abs(value) > 1.2
                text = f"{value:+.2f}".replace("-", "−")
                axes.text(column, row, text, ha="center", va="center", fontsize=8.5, color="white" if dark else INK)
        axes.set_xticks(range(table.sizes["parameter"]), [_set(str(symbol)) for symbol in table.symbol.values])
        axes.set_yticks(range(table.sizes["figure"]), [_set(str(name)) for name in table["name"].values])
        axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
        axes.spines[:].set_visible(False)
        axes.grid(False)
        bar = drawing.colorbar(shown, ax=axes, pad=0.01, aspect=30)
        bar.set_label("% per % of the parameter")
    return drawing


def _set(text: str) -> str:
    """Words with their symbols set as mathematics."""
    letters = {"ω": r"\omega ", "δ": r"\delta ", "ζ": r"\zeta ", "β": r"\beta ", "²": "^2"}
    words = text.split(" ")
    return " ".join(
        "$" + "".join(letters.get(letter, letter) for letter in word) + "$" if "_" in word or len(word) == 1 else word
        for word in words
    )


def write_sensitivity(folder: Path, study: SensitivityStudy | None = None, rule: RuleStudy | None = None) -> list[Path]:
    """Write ``rule`` and ``elasticities`` as figures (SVG, PNG), and both tables as CSV, into a folder.

    Returns:
        What was written.

    Raises:
        InputError: as `elasticities`.
    """
    slopes = elasticities(study)
    folder.mkdir(parents=True, exist_ok=True)
    tables = [folder / "elasticities.csv", folder / "one-at-a-time.csv"]
    slopes.drop_vars(("name", "symbol")).to_pandas().to_csv(tables[0])
    one_at_a_time(study).drop_vars("symbol").to_dataframe().to_csv(tables[1])
    drawn = save_figure(rule_figure(rule), folder, "rule") + save_figure(
        elasticity_figure(slopes), folder, "elasticities"
    )
    return [*tables, *drawn]
