"""The page that an engineer hands on: what was simulated, the verdict, every figure and table, in one HTML file.

Its numbers are those of the summary and of the result's dataset; nothing is analysed again here.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from numpy.typing import NDArray
from pydantic import BaseModel

from ehamj import plots
from ehamj.criteria.third_octave import bands
from ehamj.criteria.vc import CLASSES, limit
from ehamj.layout import MOUNTS
from ehamj.parameters import Parameters
from ehamj.plots import Levels, Limit, Trace
from ehamj.result import Result, written_whole
from ehamj.scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Results = Mapping[str, Result]
Window = tuple[float, float] | None

DASH: Final = "–"
HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")
ZOOM: Final = 1.0
"""Length of the part of a run that is drawn in full [s]."""

MICRO: Final = 1e6
BAR: Final = 1e-5
LITRE_PER_MINUTE: Final = 6e4

ENGINEERING: Final = {
    "m": (1e6, "µm"),
    "m/s": (1e6, "µm/s"),
    "m/s^2": (1e3, "mm/s²"),
    "rad": (1e6, "µrad"),
    "rad/s": (1e6, "µrad/s"),
    "Pa": (1e-5, "bar"),
    "m^3": (1e6, "cm³"),
    "m^3/s": (6e4, "l/min"),
}
"""Factor and unit in which people read an SI unit."""

FAMILIES: Final = ("machine-", "attenuation-", "criterion-", "history-")
"""How the names of a report's figures begin; those that an earlier report left behind are removed."""

NEGLIGIBLE: Final = 1e-6
"""Values below this in engineering units are rounding; a channel of nothing else is left out."""

AXIS_NAMES: Final = {"z": "vertical, z", "x": "along x", "y": "along y", "rx": "roll, rx", "ry": "pitch, ry"}
CRITERION_AXES: Final = ("z", "x", "y")
TURNS: Final = ("rx", "ry", "rz")

PROCESSING: Final = re.compile(r"record .*(: [xyz] from |, in this order: )|the ground starts from rest")
"""Warnings that only say how a record was processed."""


@dataclass(frozen=True)
class Picture:
    """A figure of the page: file name without ending, the section that it stands in, what is said below it."""

    name: str
    section: str
    figure: "Figure"
    caption: str = ""


@dataclass(frozen=True)
class Table:
    """A table of the page. A row's first cell is its name; a row of one cell is a heading."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    kind: str = "numbers"
    """``numbers`` (to the right; ``numbers wide``: with long names) or ``words`` (to the left)."""
    badges: Sequence[str] = field(default=())
    """Of each row, a word that its last cell shows as a badge."""


def write_report(folder: Path, results: Results) -> None:
    """Write ``report.html``, one page without external parts, and its figures as ``figures/*.svg``.

    Args:
        folder: existing folder.
        results: by label; the first is the one reported, the others are variants beside it.

    Raises:
        ValueError: if there is no result.
    """
    if not results:
        raise ValueError("results: a report needs at least one")
    pictures = draw(results)
    drawings = {picture.name: plots.svg(picture.figure, picture.name) for picture in pictures}
    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    for old in figures.glob("*.svg"):
        if old.stem not in drawings and old.stem.startswith(FAMILIES):
            old.unlink()
    for name, text in drawings.items():
        with written_whole(figures / f"{name}.svg") as path:
            path.write_text(text, encoding="utf-8")
    with written_whole(folder / "report.html") as path:
        path.write_text(page(results, pictures, drawings), encoding="utf-8")


def draw(results: Results) -> list[Picture]:
    """Every figure of the page, in its order."""
    colors = colors_of(results)
    return [
        *_machine(next(iter(results.values())).scenario),
        *_attenuation(results, colors),
        *_criterion(results, colors),
        *_histories(results, colors),
    ]


def page(results: Results, pictures: Sequence[Picture], drawings: Mapping[str, str]) -> str:
    """The page as HTML; ``drawings`` holds the SVG of each picture by name."""
    loader = PackageLoader("ehamj", "templates")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    sections: dict[str, list[dict[str, Any]]] = {}
    for picture in pictures:
        drawing = Markup(plots.inline(drawings[picture.name]))
        title = picture.figure.get_suptitle()
        sections.setdefault(picture.section, []).append(
            {"name": picture.name, "title": title, "caption": picture.caption, "svg": drawing}
        )
    first = next(iter(results.values()))
    return environment.get_template("report.html").render(
        scenario=first.scenario,
        variants=len(results),
        failures={label: _failure(result) for label, result in results.items() if not result.complete},
        verdict=_verdict(first),
        headline=_headline(results),
        classes=_classes(results),
        facts=_facts(first),
        warnings=_warnings(results, processing=False),
        processing=_warnings(results, processing=True),
        figures=sections,
        notes=_notes(results),
        bands=_bands(results),
        tables=[_levels(results), _saturation(results), _oil(results), _timing(results)],
        inputs=list(_inputs(results)),
        versions=first.summary.get("versions", {}),
    )


# --- numbers -------------------------------------------------------------------------------------------------------


def number(value: float | None, digits: int = 3) -> str:
    """A measured number with so many significant digits; a dash where there is none."""
    if value is None or math.isnan(value):
        return DASH
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if -4 < exponent < 6:
        text = f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - exponent, 0)}f}"
    else:
        text = f"{mantissa} × 10{str(exponent).translate(SUPERSCRIPTS)}"
    return text.replace("-", "−")


def exact(value: float) -> str:
    """A number that someone wrote, as it was written."""
    if not math.isfinite(value):
        return number(value)
    text = f"{value:.9g}"
    if abs(value) >= 1e6 or 0 < abs(value) < 1e-3:
        mantissa, _, power = f"{value:.8e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
        text = f"{mantissa} × 10{str(int(power)).translate(SUPERSCRIPTS)}"
    return text.replace("-", "−")


SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def measured(value: float | None) -> str:
    """A number in engineering units, of which nobody reads less than a thousandth."""
    return "< 0.001" if value is not None and 0.0 < abs(value) < 1e-3 else number(value)


def decibel(value: float | None) -> str:
    """A level difference to a tenth of a decibel."""
    return DASH if value is None else f"{value:.1f}".replace("-0.0", "0.0").replace("-", "−")


def plain(value: Any) -> str:
    """A setting as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return exact(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {plain(part)}" for key, part in value.items())
    if isinstance(value, tuple | list):
        if len(value) > 12:
            return f"{len(value)} values, {plain(value[0])} to {plain(value[-1])}"
        return ", ".join(f"({plain(part)})" if isinstance(part, tuple) else plain(part) for part in value) or DASH
    return DASH if value is None or value == "" else str(value)


def colors_of(results: Results) -> dict[str, str]:
    """Colour of each result: the first passive one always has the same, the others follow in order."""
    passive = next((label for label, result in results.items() if result.scenario.control.kind == "passive"), None)
    others = iter((plots.BLUE, plots.GREEN, plots.PURPLE, plots.SKY, plots.ORANGE) * len(results))
    return {label: plots.VERMILLION if label == passive else next(others) for label in results}


# --- figures -------------------------------------------------------------------------------------------------------


def _machine(scenario: Scenario) -> Iterator[Picture]:
    actuators: dict[str, str] = {mount.name: mount.actuator for mount in scenario.mount}
    feet = [
        plots.Foot(name, *position, kind=actuators[name])
        for name, position in zip(MOUNTS, scenario.plant.positions, strict=True)
    ]
    waves = dict.fromkeys(
        (f"wave\n{part.wave.speed:.4g} m/s", float(part.wave.direction))
        for part in _ground_parts(scenario)
        if getattr(part, "wave", None) is not None
    )
    size, cg = scenario.machine.size, scenario.machine.cg
    caption = "To scale; dimensions in metres."
    yield Picture("machine-plan", "machine", plots.machine_plan(size, cg, feet, list(waves)), caption)
    caption = "To scale but for the height of the mounts; dimensions in metres."
    yield Picture("machine-side", "machine", plots.machine_side(size, cg, feet), caption)


def _ground_parts(scenario: Scenario) -> tuple[Any, ...]:
    return getattr(scenario.ground, "parts", None) or (scenario.ground,)


def _attenuation(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    for axis in AXIS_NAMES:
        curves = [
            curve
            for label, result in results.items()
            if (curve := _curve(label, result.summary.get("attenuation_db", {}).get(axis), 1.0, colors[label]))
        ]
        if curves:
            figure = plots.attenuation(f"Attenuation, {AXIS_NAMES[axis]}", curves)
            yield Picture(f"attenuation-{axis}", "attenuation", figure)


def _curve(label: str, table: Mapping[str, float | None] | None, factor: float, color: str) -> Levels | None:
    """A line over bands; None where no band is decided."""
    if not table or all(value is None for value in table.values()):
        return None
    values = [math.nan if value is None else factor * value for value in table.values()]
    return Levels(label, np.array([float(band) for band in table]), np.array(values), color)


def _criterion(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    classes = {}
    for name in CLASSES:
        limits = [(float(band.name), level) for band in bands(1.0, 100.0) if (level := limit(name, band)) is not None]
        frequency, level = np.array(limits).T
        classes[name] = (frequency, MICRO * level)
    known = {result.summary.get("analysis", {}).get("usable_to_hz") for result in results.values()}
    known_to = min((value for value in known if value is not None), default=None)
    for axis in CRITERION_AXES:
        curves = [
            curve
            for label, who, table, color in _velocities(results, axis, colors)
            if (curve := _curve(who or label, table, MICRO, color)) and np.nanmax(curve.values) > plots.QUIETEST
        ]
        if curves:
            figure = plots.criterion(f"Velocity and vibration classes, {AXIS_NAMES[axis]}", curves, classes, known_to)
            yield Picture(f"criterion-{axis}", "criterion", figure)


def _velocities(results: Results, axis: str, colors: Mapping[str, str]) -> Iterator[tuple[str, str, Any, str]]:
    """Label, name of the floor (or nothing), levels per band and colour; floors that are alike once."""
    tables = {label: result.summary.get("third_octave_velocity", {}) for label, result in results.items()}
    floors: list[Any] = []
    for label, table in tables.items():
        floor = table.get("floor", {}).get(axis)
        if floor is not None and floor not in floors:
            floors.append(floor)
            yield label, "floor" if len(floors) == 1 else f"floor of {label}", floor, plots.FLOOR_COLOR
    for label, table in tables.items():
        yield label, "", table.get("machine", {}).get(axis), colors[label]


def _histories(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    label, first = next(iter(results.items()))
    if first.dataset.time.size < 2:
        return
    window = characteristic_part(first)
    yield _velocity_history(results, colors, window)
    data, time = first.dataset, first.dataset.time.values
    plant, color = first.scenario.plant, colors[label]
    stroke = MICRO * (data.stroke.values - data.stroke.values[:1])
    at_rest = data.stroke.values[0]
    ends = [actuator.maximum_stroke for actuator in plant.actuators]
    travel = Limit(
        f"end of stroke, {1e3 * min(ends):.3g} mm",
        (MICRO * float(np.min(ends - at_rest)), MICRO * float(np.max(-np.array(ends) - at_rest))),
    )
    voltages = [actuator.voltage_limit for actuator in plant.actuators]
    if first.controller is not None:
        voltages = [min(voltage, first.controller.voltage_limit) for voltage in voltages]
    openings = [actuator.spool_stroke for actuator in plant.actuators]
    flows = [LITRE_PER_MINUTE * actuator.flow_gain * actuator.spool_stroke for actuator in plant.actuators]
    quantities = (
        ("stroke", "Strokes of the plates, from equilibrium", "stroke [µm]", stroke, travel, "Plate over ground."),
        ("command", "Valve commands", "command [V]", data.valve_command.values, _both("range", voltages, "V"), ""),
        ("spool", "Spools", "spool [mA]", data.spool.values, _both("fully open", openings, "mA"), ""),
        (
            "flow",
            "Oil into chamber 1, which lifts",
            "flow [l/min]",
            LITRE_PER_MINUTE * data.chamber_flow.values[:, :, 0],
            _both("rated flow, fully open", flows, "l/min"),
            "Positive into the chamber. Rated: at half the supply pressure per edge.",
        ),
    )
    for name, title, quantity, values, bound, caption in quantities:
        if not np.any(values):
            continue
        whole = [Trace("all mounts", time, values, color)]
        figure = plots.history(title, quantity, whole, _per_mount(time, values), [bound], window)
        yield Picture(f"history-{name}", "histories", figure, caption)
    yield _pressure_history(results, window)


def characteristic_part(result: Result) -> Window:
    """From when to when a run is drawn in full [s]; None for a run that is hardly longer.

    Around the vertical peak of the floor, or of the machine if the floor rests; the end of a run that failed.
    """
    time = result.dataset.time.values
    if time[-1] - time[0] < 1.5 * ZOOM:
        return None
    ground = result.dataset.ground_velocity.values[:, :, 2].mean(axis=1)
    signal = np.abs(ground if np.any(ground) else result.dataset.cg_velocity.values[:, 2])
    peak = float(time[int(np.argmax(np.nan_to_num(signal)))]) if result.complete else float(time[-1])
    begin = min(max(peak - 0.4 * ZOOM, float(time[0])), float(time[-1]) - ZOOM)
    return begin, begin + ZOOM


def _velocity_history(results: Results, colors: Mapping[str, str], window: Window) -> Picture:
    first = next(iter(results.values())).dataset
    floor = MICRO * first.ground_velocity.values[:, :, 2].mean(axis=1)
    traces = [Trace("floor", first.time.values, floor, plots.FLOOR_COLOR, width=2.4)]
    machines = [
        Trace(label, result.dataset.time.values, MICRO * result.dataset.cg_velocity.values[:, 2], colors[label])
        for label, result in results.items()
    ]
    traces += sorted(machines, key=lambda trace: -float(np.nan_to_num(trace.values).std()))  # the quietest on top
    figure = plots.history("Vertical velocity of floor and machine", "velocity [µm/s]", traces, traces, (), window)
    caption = "Floor: mean of the mounts; machine: its centre of gravity."
    return Picture("history-velocity", "histories", figure, caption)


def _pressure_history(results: Results, window: Window) -> Picture:
    first = next(iter(results.values()))
    time, pressure = first.dataset.time.values, BAR * first.dataset.chamber_pressure.values
    supply = first.scenario.supply
    whole = [
        Trace(f"chamber {k + 1}, all mounts", time, pressure[:, :, k], color)
        for k, color in enumerate((plots.SKY, plots.ORANGE))
    ]
    detail = [*_per_mount(time, pressure[:, :, 0]), *_per_mount(time, pressure[:, :, 1], "--")]
    manifold = BAR * first.dataset.supply_pressure.values
    if np.ptp(manifold) > 0:
        whole.append(Trace("manifold", time, manifold, plots.FLOOR_COLOR))
    limits = [
        Limit(
            f"supply {BAR * supply.pressure:.4g}, tank {BAR * supply.tank_pressure:.4g} bar",
            (BAR * supply.pressure, BAR * supply.tank_pressure),
        ),
    ]
    figure = plots.history("Chamber pressures, absolute", "pressure [bar]", whole, detail, limits, window)
    caption = "Chamber 1, which lifts, solid; chamber 2 dashed."
    return Picture("history-pressure", "histories", figure, caption)


def _per_mount(time: Array, values: Array, dash: str = "-") -> list[Trace]:
    """A trace per mount, (n, mount); lines get thinner, so that those which coincide all show."""
    return [
        Trace(name, time, values[:, k], color, width if dash == "-" else 1.0, dash)
        for k, (name, (color, width)) in enumerate(zip(MOUNTS, plots.MOUNT_STYLES, strict=True))
    ]


def _both(label: str, values: Sequence[float], unit: str) -> Limit:
    """A limit on both sides; that of the weakest mount."""
    least = min(values)
    return Limit(f"{label}, ±{least:.3g} {unit}", (least, -least))


# --- verdict -------------------------------------------------------------------------------------------------------


def _failure(result: Result) -> str:
    return str(result.summary.get("failure", "the simulation did not reach its end"))


def _verdict(result: Result) -> list[tuple[str, str]]:
    """The verdict's lines as the summary says them: vertical apart from horizontal."""
    criterion = result.summary.get("criterion", {})
    lines = []
    for name, axes in (("vertical", ("z",)), ("horizontal", ("x", "y"))):
        parts = [criterion.get(who, {}).get(axis, {}) for who in ("floor", "machine") for axis in axes]
        judged = any(part.get("deciding_band_hz") is not None for part in parts)
        said = criterion.get("verdict", {}).get(name, DASH)
        lines.append((name, said if judged else "not judged: the run is too short for any band of the criterion"))
    return lines


def _headline(results: Results) -> Table:
    """Vertical attenuation at a few bands."""
    tables = {label: result.summary.get("attenuation_db", {}).get("z", {}) for label, result in results.items()}
    rows = [[label, *(decibel(table.get(band)) for band in HEADLINE_BANDS)] for label, table in tables.items()]
    note = f"{DASH}: undecided." if any(DASH in row for row in rows) else ""
    if not _known(tables.values()):
        rows, note = [], "Undecided in every band: the run is too short, or the floor moves too little."
    if not _floor_moves(next(iter(results.values()))):
        note = "The ground is at rest: there is nothing to attenuate."
    head = ["", *(f"{band} Hz" for band in HEADLINE_BANDS)]
    return Table("Vertical attenuation [dB] in the third-octave bands at", head, rows, note)


def _floor_moves(result: Result) -> bool:
    peak = result.summary.get("peak", {}).get("ground_velocity", {})
    return any(value for axes in peak.values() for value in axes.values())


def _classes(results: Results) -> Table:
    """Vibration class per axis of the floor and of each machine, with margin and band."""
    columns: list[tuple[str, Mapping[str, Any]]] = []
    for label, result in results.items():
        criterion = result.summary.get("criterion", {})
        floor = criterion.get("floor", {})
        if not any(floor == known for _, known in columns):
            columns.append(("floor" if not columns else f"floor of {label}", floor))
        columns.append((label, criterion.get("machine", {})))
    rows = [[AXIS_NAMES[axis], *(_class(column.get(axis, {})) for _, column in columns)] for axis in CRITERION_AXES]
    note = "Margin: below the limit of the class in the band that decides, the nearest to the next stricter class."
    return Table("Vibration class", ["", *(name for name, _ in columns)], rows, note, kind="words")


def _class(verdict: Mapping[str, Any]) -> str:
    band, margin = verdict.get("deciding_band_hz"), verdict.get("margin_db")
    if band is None:
        return "not judged"
    if verdict.get("class") is None:
        return f"worse than workshop ({band} Hz)"
    if margin is None or margin > 100.0:
        return f"{verdict['class']} (at rest)"
    return f"{verdict['class']} ({decibel(margin)} dB, {band} Hz)"


def _warnings(results: Results, processing: bool) -> list[str]:
    """Warnings in plain words, each with the results that it holds for; ``processing``: those about a record's."""
    found: dict[str, list[str]] = {}
    for label, result in results.items():
        for text in result.summary.get("warnings", []):
            if bool(PROCESSING.match(text)) == processing:
                found.setdefault(text, []).append(label)
    alone = len(results) == 1
    return [text if alone or len(who) == len(results) else f"{', '.join(who)}: {text}" for text, who in found.items()]


def _notes(results: Results) -> dict[str, list[str]]:
    """What each section says before its figures: how to read them, and why some are missing."""
    label, first = next(iter(results.items()))
    tables = [result.summary.get("attenuation_db", {}) for result in results.values()]
    silent = [name for axis, name in AXIS_NAMES.items() if not _known(table.get(axis, {}) for table in tables)]
    attenuation = [
        "Up is quieter. Along x, y and z: the mean of the floor at the mounts over the machine's centre of gravity; "
        "roll and pitch: of the plane fitted to the floor, over those of the machine. Gaps are undecided bands."
    ]
    if not _floor_moves(first):
        attenuation = ["The ground is at rest: attenuation is not defined."]
    elif silent:
        attenuation.append(
            f"Undecided in every band, since the floor moves too little or the run is short: {'; '.join(silent)}."
        )
    criterion = [
        "The floor at its worst mount, the machine at its centre of gravity; thin lines are the classes' limits."
    ]
    velocities = [result.summary.get("third_octave_velocity", {}) for result in results.values()]
    quiet = []
    for axis in CRITERION_AXES:
        levels = _known(part.get(axis, {}) for table in velocities for part in table.values())
        if not any(level * MICRO > plots.QUIETEST for level in levels):
            quiet.append(AXIS_NAMES[axis])
    if quiet:
        criterion.append(f"Nothing above {plots.QUIETEST:g} µm/s, or not known: {'; '.join(quiet)}.")
    if first.dataset.time.size < 2:
        return {"attenuation": attenuation, "criterion": criterion, "histories": ["Nothing was recorded."]}
    histories = [f"What belongs to single mounts is that of {label}."] if len(results) > 1 else []
    window = characteristic_part(first)
    if window:
        histories.append(f"The lower part of each figure shows {window[0]:.4g} to {window[1]:.4g} s.")
    if not np.any(first.dataset.valve_command.values):
        histories.append("There is no command: the valves stay centred.")
    return {"attenuation": attenuation, "criterion": criterion, "histories": [" ".join(histories)]}


def _known(tables: Iterable[Mapping[str, float | None]]) -> list[float]:
    return [value for table in tables for value in table.values() if value is not None]


# --- tables --------------------------------------------------------------------------------------------------------


def _facts(result: Result) -> list[tuple[str, str]]:
    """What was simulated, in a few lines."""
    scenario, timing = result.scenario, result.summary.get("timing", {})
    plant, supply = scenario.plant, scenario.supply
    kinds = [getattr(part, "kind", "") for part in _ground_parts(scenario)]
    facts = [
        ("machine", f"{exact(plant.total_mass)} kg with its plates, on four mounts ({scenario.plates} plates)"),
        ("supply", f"{exact(BAR * supply.pressure)} bar, tank {exact(BAR * supply.tank_pressure)} bar (absolute)"),
        ("floor", " + ".join(kinds)),
        ("control", scenario.control.kind),
        ("simulated", f"{exact(timing.get('simulated_s', 0.0))} of {exact(scenario.duration)} s, seed {scenario.seed}"),
    ]
    law = result.controller
    if law is not None:
        bits = "exact" if law.bits is None else f"{law.bits} bit"
        facts.insert(
            4,
            (
                "law",
                f"{law.states} states, {len(law.inputs)} inputs, {exact(1e-3 / law.period)} kHz, "
                f"delay {exact(1e3 * law.latency)} ms, ±{exact(law.voltage_limit)} V, {bits}",
            ),
        )
    analysis = result.summary.get("analysis")
    if analysis:
        facts.append(("levels taken", f"from {exact(analysis['from_s'])} to {exact(analysis['to_s'])} s"))
    return facts


def _bands(results: Results) -> Table:
    """Vertical levels and attenuation per band."""
    first = next(iter(results.values())).summary
    head = ["band [Hz]", "floor [µm/s]"]
    for label in results:
        head += [f"{label} [µm/s]", f"{label} [dB]"]
    rows = []
    for band, level in first.get("third_octave_velocity", {}).get("floor", {}).get("z", {}).items():
        row = [band, measured(_scaled(level, MICRO))]
        for result in results.values():
            machine = result.summary.get("third_octave_velocity", {}).get("machine", {}).get("z", {})
            attenuation = result.summary.get("attenuation_db", {}).get("z", {})
            row += [measured(_scaled(machine.get(band), MICRO)), decibel(attenuation.get(band))]
        if set(row[1:]) != {DASH}:
            rows.append(row)
    note = (
        "Levels: RMS velocity, of the floor at its worst mount, of the machine at its centre of gravity. Attenuation "
        "is counted from the mean of the mounts, which a passing wave makes smaller than a single mount's motion."
    )
    return Table("Vertical, per third-octave band", head, rows, note)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _levels(results: Results) -> Table:
    """Peak and RMS of every channel that moves."""
    rows: list[list[str]] = []
    data = next(iter(results.values())).dataset
    for name in data.data_vars:
        channel = str(name).replace("_", " ").replace("cg", "CG").replace("ground", "floor")
        for part in _parts(results, str(name)):
            factor, unit = _unit(str(data[name].attrs.get("units", "")), part)
            values = [
                _scaled(_worst(result.summary.get(kind, {}).get(name), part), factor)
                for result in results.values()
                for kind in ("peak", "rms")
            ]
            if any(value is not None and abs(value) > NEGLIGIBLE for value in values):
                rows.append([f"{channel} {part}".strip() + f" [{unit}]", *map(measured, values)])
    head = ["about the equilibrium", *(f"{label}, {kind}" for label in results for kind in ("peak", "RMS"))]
    note = "What each mount has: the largest of the four. Channels that do not move are left out."
    return Table("Peak and RMS", head, rows, note, kind="numbers wide")


def _parts(results: Results, name: str) -> list[str]:
    """Names of a channel's parts without the mounts: its axes, degrees of freedom or chambers; '' where it has none."""
    data = next(iter(results.values())).dataset[name]
    inner = [dimension for dimension in data.dims if dimension not in ("time", "mount")]
    return [str(label) for label in data[inner[0]].values] if inner else [""]


def _worst(table: Any, part: str) -> float | None:
    """A part's value; where there is one per mount, the largest."""
    if not isinstance(table, Mapping):
        return table if isinstance(table, float | int) else None
    if part in table:
        return table[part]
    values = [_worst(inner, part) for inner in table.values()]
    return max((value for value in values if value is not None), default=None)


def _unit(units: str, part: str) -> tuple[float, str]:
    """Factor and unit in which a channel's part is shown; units may tell turns apart: 'm (rx, ry, rz: rad)'."""
    turned = re.fullmatch(r"(\S+) \(rx, ry, rz: (\S+)\)", units)
    if turned:
        units = turned.group(2 if part in TURNS else 1)
    return ENGINEERING.get(units, (1.0, units))


def _saturation(results: Results) -> Table:
    """Share of the time at each limit, per mount."""
    rows = []
    for label, result in results.items():
        if len(results) > 1:
            rows.append([label])
        for limit_name, shares in result.summary.get("saturation", {}).items():
            percent = [measured(_scaled(shares.get(mount), 100.0)) for mount in MOUNTS]
            rows.append([limit_name.replace("_", " "), *percent])
    return Table("Share of the time at a limit [%]", ["", *MOUNTS], rows)


def _oil(results: Results) -> Table:
    quantities = (
        ("mean flow [l/min]", "mean_flow_m3_s", LITRE_PER_MINUTE),
        ("peak flow [l/min]", "peak_flow_m3_s", LITRE_PER_MINUTE),
        ("volume [l]", "volume_m3", 1e3),
        ("mean power [W]", "mean_power_w", 1.0),
    )
    return _per_result("Oil drawn from the supply", "oil", quantities, results, "All mounts together.")


def _timing(results: Results) -> Table:
    quantities = (
        ("simulated [s]", "simulated_s", 1.0),
        ("step [µs]", "timestep_s", 1e6),
        ("steps", "steps", 1.0),
        ("stepping [s]", "stepping_s", 1.0),
        ("in all [s]", "wall_s", 1.0),
        ("simulated over stepping", "ratio", 1.0),
    )
    return _per_result("Computation", "timing", quantities, results, "")


def _per_result(title: str, key: str, quantities: Iterable[tuple[str, str, float]], results: Results, n: str) -> Table:
    tables = [result.summary.get(key, {}) for result in results.values()]
    rows = [
        [text, *(number(_scaled(table.get(name), factor)) for table in tables)] for text, name, factor in quantities
    ]
    return Table(title, ["", *results], rows, n)


# --- inputs --------------------------------------------------------------------------------------------------------


def _inputs(results: Results) -> Iterator[Table]:
    """Parameters, mounts, ground and control; once where results share them."""
    yield from _shared(results, lambda scenario: [_quantities("Machine", scenario.machine)])
    yield from _shared(results, lambda scenario: [_mounts(scenario)])
    yield from _shared(results, _actuators)
    yield from _shared(results, lambda scenario: [_quantities("Supply", scenario.supply)])
    yield from _shared(results, _run)
    yield from _shared(results, lambda scenario: [_settings("Ground", scenario.ground)])
    yield from _shared(results, lambda scenario: [_settings("Control", scenario.control)])


def _shared(results: Results, tables_of: Any) -> Iterator[Table]:
    found: dict[str, tuple[list[str], list[Table]]] = {}
    for label, result in results.items():
        tables = tables_of(result.scenario)
        found.setdefault(repr(tables), ([], tables))[0].append(label)
    for labels, tables in found.values():
        for table in tables:
            whose = f", {', '.join(labels)}" if len(found) > 1 else ""
            yield Table(table.title + whose, table.head, table.rows, table.note, table.kind, table.badges)


def _run(scenario: Scenario) -> list[Table]:
    single = [
        name
        for name in type(scenario).model_fields
        if name not in ("name", "description") and isinstance(getattr(scenario, name), int | float | str)
    ]
    return [_settings("Run", scenario, single)]


def _actuators(scenario: Scenario) -> list[Table]:
    return [_quantities(f"Actuator {name}", actuator) for name, actuator in scenario.actuators.items()]


def _quantities(title: str, parameters: Parameters) -> Table:
    """Each value with symbol, unit and source; settings without unit have no source."""
    known = parameters.quantities()
    rows, badges = [], []
    for name, about in type(parameters).model_fields.items():
        if name == "sources":
            continue
        unit, symbol, _ = known.get(name, ("", "", ""))
        value, text = getattr(parameters, name), (about.description or "").removesuffix(f" [{unit}]")
        shown = f"{plain(value)} {'' if unit == '-' else unit}".strip()
        if unit == "Pa" and isinstance(value, float) and 1e4 <= value < 1e8:
            shown += f" ({exact(BAR * value)} bar)"
        badges.append(parameters.sources.get(name, ""))
        rows.append([_named(name, text), _symbol(symbol), shown, badges[-1]])
    return Table(title, ("quantity", "symbol", "value", "source"), rows, kind="words", badges=badges)


def _named(key: str, text: str) -> str:
    """What something is, and its key in a scenario."""
    return Markup("{} <code>{}</code>").format(text, key)


def _symbol(symbol: str) -> str:
    """A symbol with its subscripts: A_p."""
    return Markup(re.sub(r"_([^\W_]+)", r"<sub>\1</sub>", str(escape(symbol))))


def _mounts(scenario: Scenario) -> Table:
    actuators: dict[str, str] = {mount.name: mount.actuator for mount in scenario.mount}
    rows = [
        [name, exact(x), exact(y), actuators[name]]
        for name, (x, y) in zip(MOUNTS, scenario.plant.positions, strict=True)
    ]
    return Table("Mounts", ("mount", "x [m]", "y [m]", "actuator"), rows, kind="words")


def _settings(title: str, settings: BaseModel, only: Sequence[str] = ()) -> Table:
    rows = [list(row) for row in _flat(settings, "", only)]
    return Table(title, ("setting", "value"), rows, kind="words")


def _flat(settings: BaseModel, prefix: str, only: Sequence[str] = ()) -> Iterator[tuple[str, str]]:
    """Description with key, and value of each setting, those of inner tables with their path."""
    for name, about in type(settings).model_fields.items():
        if only and name not in only:
            continue
        value, key = getattr(settings, name), f"{prefix}{name}"
        inner = value if isinstance(value, tuple) and value and isinstance(value[0], BaseModel) else ()
        if isinstance(value, BaseModel):
            yield from _flat(value, f"{key}.")
        elif inner:
            for k, part in enumerate(inner):
                yield from _flat(part, f"{key}.{k}.")
        else:
            yield _named(key, about.description or ""), plain(value)
