"""The page beside the picture: what was simulated, what came out, how to read the picture."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ehamj.plant.mounts import UP
from ehamj.replay.marks import MOST_ARROWS, length_text, shown_at
from ehamj.replay.plots import MOST_ROWS, NEGLIGIBLE
from ehamj.result import Result
from ehamj.scenario.model import Scenario
from ehamj.settings import Parameters, Settings


def _labels_of(results: Mapping[str, Result], texts: Callable[[Result], Iterable[str]]) -> dict[str, list[str]]:
    """What is said of the results, each text once, with the labels of those that share it."""
    found: dict[str, list[str]] = {}
    for label, result in results.items():
        for text in texts(result):
            found.setdefault(text, []).append(label)
    return found


def page(results: Mapping[str, Result], factor: float, arrows: float, speed: float) -> str:
    """The page as Markdown.

    Args:
        results: what is shown, by label.
        factor: exaggeration of the motions.
        arrows: length of an arrow over velocity [m/(m/s)].
        speed: playback speed, simulated seconds per second.
    """
    first = next(iter(results.values())).scenario
    parts = [
        f"# {first.name}",
        first.description,
        _verdicts(results),
        _numbers(results),
        *_warnings(results),
        _reading(factor, arrows, speed, results),
    ]
    return "\n\n".join(part for part in parts + _parameters(results) if part) + "\n"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def _verdicts(results: Mapping[str, Result]) -> str:
    """The headline of the first result, and of those beside it the classes alone, unless something failed in them."""
    said: list[str] = []
    for label, result in results.items():
        lines, verdict = result.summary.lines(), result.summary.criterion.verdict
        if said and not result.summary.broken:
            lines = {name: f"{getattr(verdict, name)}" for name in verdict}
        said += [f"- {label}, {what}: {text}" for what, text in lines.items()]
    return "\n".join(said)


def _numbers(results: Mapping[str, Result]) -> str:
    columns = [_figures(result) for result in results.values()]
    names = dict.fromkeys(name for column in columns for name in column)
    rows = [[name, *(column.get(name, "–") for column in columns)] for name in names]
    mixed = next((f", {said}" for result in results.values() if (said := result.summary.mixed)), "")
    return table([f"about the equilibrium{mixed}", *results], rows)


def _figures(result: Result) -> dict[str, str]:
    """The numbers a person asks for first, each as text with its unit."""
    data = result.dataset
    if not data.time.size:
        return {"simulated": "nothing, **incomplete**"}
    ground, cg = data.ground_velocity.values.mean(axis=1), data.cg_velocity.values
    floor_z, cg_z = _rms(ground[:, 2]), _rms(cg[:, 2])
    moving = min(floor_z, cg_z) > 1e-6 * NEGLIGIBLE  # in m/s
    attenuation = round(20 * math.log10(floor_z / cg_z), 1) + 0.0 if moving else math.nan  # + 0: no "-0.0"
    stroke = data.stroke.values - data.stroke.values[0]
    full = np.array([actuator.spool_stroke for actuator in result.scenario.plant.actuators])
    return {
        "vertical velocity of the CG, RMS": _speed(cg_z),
        "vertical velocity of the CG, peak": _speed(_peak(cg[:, 2])),
        "vertical velocity of the floor, RMS": _speed(floor_z),
        "attenuation of the CG, vertical RMS": f"{attenuation} dB" if moving else "–",
        "horizontal velocity of the CG, RMS": _speed(math.hypot(_rms(cg[:, 0]), _rms(cg[:, 1]))),
        "largest stroke": length_text(_peak(stroke)),
        "largest command": f"{_peak(data.valve_command.values):.3g} V",
        "largest spool opening": f"{100 * _peak(data.spool.values / full):.3g} %",
        "time at a limit, worst mount": _limits(result),
        "simulated": f"{float(data.time[-1]):.4g} s" + ("" if result.complete else ", **incomplete**"),
    }


def _limits(result: Result) -> str:
    """Share of time at each limit, of the mount that is there longest."""
    saturation = result.summary.saturation
    worst = {limit.replace("_", " "): max(shares.values(), default=0.0) for limit, shares in saturation.items()}
    return ", ".join(f"{limit} {100 * share:.2g} %" for limit, share in worst.items() if share > 0.0) or "none"


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _peak(values: np.ndarray) -> float:
    return float(np.abs(values).max())


def _speed(velocity: float) -> str:
    return "< 0.001 µm/s" if velocity < 1e-9 else f"{1e6 * velocity:.3g} µm/s"


def _warnings(results: Mapping[str, Result]) -> list[str]:
    """Failures and warnings, once where results share them; nothing when there is nothing to say."""
    said = _labels_of(results, lambda result: filter(None, (result.summary.failure, *result.summary.warnings)))
    whose = {text: "" if len(labels) == len(results) else f"{'; '.join(labels)}: " for text, labels in said.items()}
    lines = [f"- {labels}{text}" for text, labels in whose.items()]
    return ["## Warnings", "\n".join(lines)] if said else []


def _reading(factor: float, arrows: float, speed: float, results: Mapping[str, Result]) -> str:
    shown, rows = "", max(result.dataset.time.size for result in results.values())
    plants = [result.scenario.plant for result in results.values()]
    if arrows > 0.0:
        upright = all(direction == UP for plant in plants for direction in plant.directions)
        what = "vertical velocities" if upright else "velocities along the mounts"
        shown = f"""- Arrows beside the mounts are {what}, blue of the floor, coloured of the machine's
  foot: {1e6 * 0.1 / arrows:g} µm/s are an arrow of 10 cm. Isolation works where blue swings and the other does not.
"""
    if any(len(shown_at(plant)) < len(plant.mounts) for plant in plants):
        shown += f"- Of many mounts, {MOST_ARROWS} at most have arrows: those that stand farthest out.\n"
    if any(plant.slides for plant in plants):
        shown += "- Slides go along their rails as far as they do in truth, and with the machine as it is drawn.\n"
    thinned = ""
    if rows > MOST_ROWS:
        thinned = f"""
- The run has {rows} rows; to stay small, its plots show the lowest and highest value of each stretch of rows."""
    return f"""## How to read the picture

- Real motions are micrometres. Every motion is drawn **{factor:g} times** larger about the position of equilibrium, by
  the same factor everywhere: {length_text(0.1 / factor)} look like 10 cm. The white bar gives the scale. The machine's
  size is not enlarged, so large rotations look stranger than they are.
- Blue pads and the floor are the ground. Orange plates are what the oil lifts; they carry the machine's feet. The grey
  outline is the machine at rest.
{shown}- Playback runs at {speed:g} × real time; space starts and stops it, the plot below follows.{thinned}"""


def _parameters(results: Mapping[str, Result]) -> list[str]:
    """Parameters with unit and source, ground and control in a line each; once where results share them."""
    found = _labels_of(results, lambda result: [_tables(result.scenario)])
    parts = []
    for text, labels in found.items():
        whose = f" of {'; '.join(labels)}" if len(found) > 1 else ""
        parts += [f"## Parameters{whose}", text]
    said = _labels_of(results, lambda r: [_line("ground", r.scenario.ground), _line("control", r.scenario.control)])
    lines = [f"- {'; '.join(labels)}: {line}" for line, labels in said.items()]
    return [*parts, "## Ground and control", "\n".join(lines)]


def _tables(scenario: Scenario) -> str:
    tables: dict[str, Parameters] = {"Machine": scenario.machine}
    tables |= {f"Actuator {name}": actuator for name, actuator in scenario.running.items()}
    tables["Supply"] = scenario.supply
    return "\n\n".join(f"### {name}\n\n{_quantities(values)}" for name, values in tables.items())


def _quantities(values: Parameters) -> str:
    rows = []
    for name, (unit, symbol, _) in values.quantities().items():
        value = f"{_number(getattr(values, name))} {'' if unit == '-' else unit}".strip()
        if name in values.deviations:
            value += f" ± {_number(values.deviations[name])}"
        rows.append([name.replace("_", " "), symbol, value, values.sources[name]])
    return table(["quantity", "symbol", "value", "source"], rows)


def _line(what: str, settings: Settings) -> str:
    """A table of settings in one line, without long tables of numbers."""
    values = settings.model_dump()
    kind = values.pop("kind", "")
    plain = [f"{key} {value}" for key, value in values.items() if isinstance(value, str | int | float)]
    return f"{what} {kind}{': ' if plain else ''}{', '.join(plain)}"


def _number(value: Any) -> str:
    if isinstance(value, tuple | list):
        return "(" + ", ".join(_number(part) for part in value) + ")"
    return "∞" if math.isinf(value) else f"{value:.4g}".replace("e+0", "e").replace("e-0", "e-")
