"""Modes of the machine: with the valves held, in each closed loop, and over CG height and footprint."""

import cmath
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import xarray as xr

from ehamj.designs.footprint import rocking_modes, slowest_rocking
from ehamj.errors import InputError
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.margins import feeds_back
from ehamj.linear.modes import Mode, modes
from ehamj.pages import Picture, Table
from ehamj.pages.words import DASH, number
from ehamj.plant.axes import DOFS
from ehamj.plots.charts import Line, map_chart
from ehamj.report.shown import Results
from ehamj.result import Result
from ehamj.scenario.model import Scenario

NOTABLE: Final = 0.05
"""Share of a shape's largest part below which a part is left out."""
IN_STEP: Final = 5.0
"""Phase below which parts of a shape count as in step, or against each other [deg]."""
DESIGNS: Final = 25
"""Designs of the map each way."""
HEIGHTS: Final = (0.25, 2.5)
"""Range of the map's CG heights, over the machine's own [-]."""
LEAST_HEIGHT: Final = 0.2
"""CG height that the range is taken of at least [m]: that of a machine may be zero."""
WIDTHS: Final = (0.4, 1.8)
"""Range of the map's footprints, over the machine's own [-]."""


def modal_tables(results: Results) -> Iterator[Table]:
    """Natural frequency and damping of the modes in which the machine moves, a table for each machine.

    Columns: with its valves held, and in the closed loop of each result whose law feeds back. Machines without a rest
    to linearise about (under a load that is held) have no table.
    """
    machines: list[tuple[LinearModel, dict[str, Result]]] = []
    for label, result in results.items():
        own = next(
            (runs for _, runs in machines if next(iter(runs.values())).scenario.plant == result.scenario.plant), {}
        )
        if not own:
            try:
                machines.append((linear_model(result.scenario), own))
            except InputError:
                continue
        own[label] = result
    for model, runs in machines:
        whose = f", {next(iter(runs))}" if len(machines) > 1 else ""
        yield _table(f"Modes of the machine{whose}", model, runs)


def _table(title: str, model: LinearModel, runs: Results) -> Table:
    held = modes(model)
    columns: dict[str, Sequence[Mode]] = {"valves held": held}
    notes = [
        "Natural frequency |λ|/2π and damping ratio −Re λ/|λ|; with valves held, the motion of the mount plane's "
        "centre (m, rad; largest one), and the axis about which it turns."
    ]
    still = []
    for label, result in runs.items():
        law = result.controller
        if law is None:
            continue
        if not feeds_back(law):
            still.append(label)
        else:
            columns[label] = modes(model, law, sensors=result.scenario.sensors, seed=result.scenario.seed)
    if still:
        notes.append(f"{', '.join(still)}: the law reads the ground alone and moves no mode.")
    notes += [note for label, found in columns.items() if (note := _others(label, found))]
    by_name = {label: {mode.name: mode for mode in found if mode.machine_moves} for label, found in columns.items()}
    rows = []
    for name in dict.fromkeys(name for found in by_name.values() for name in found):
        row = [name]
        for found in by_name.values():
            one = found.get(name)
            row += [
                number(one.frequency if one else None, 4),
                f"{one.damping_ratio:.4f}".replace("-", "−") if one else DASH,
            ]
        mode = by_name["valves held"].get(name)
        rows.append([*row, _moves(mode) if mode else "", str(mode.centre or "nothing: translates") if mode else ""])
    head = [f"{label}: {what}" if len(columns) > 1 else what for label in columns for what in ("f [Hz]", "ζ [-]")]
    return Table(title, ["mode", *head, "moves", "turns about"], rows, " ".join(notes), kind="words")


def _others(label: str, found: Sequence[Mode]) -> str:
    """What else swings: valves and law, of which the machine hardly takes notice."""
    rest = [mode for mode in found if not mode.machine_moves]
    if not rest:
        return ""
    least = min(rest, key=lambda mode: mode.damping_ratio)
    what = "the valves swing" if label == "valves held" else "valves and law swing"
    kind = "at" if len({round(mode.frequency) for mode in rest}) == 1 else "by themselves, least damped at"
    return f"{label}: {what} {kind} {number(least.frequency)} Hz, ζ {least.damping_ratio:.3f}."


def _moves(mode: Mode) -> str:
    """The shape's parts, largest one; phases where they are not in step."""
    largest = max(map(abs, mode.shape))
    words = []
    for dof, part in zip(DOFS, mode.shape.tolist(), strict=True):
        if abs(part) > NOTABLE * largest:
            size, angle = abs(part) / largest, math.degrees(cmath.phase(part))
            if abs(angle) > 180.0 - IN_STEP:
                size, angle = -size, 0.0
            words.append(f"{dof} {size:.2f}" + (f"∠{angle:.0f}°" if abs(angle) > IN_STEP else ""))
    return ", ".join(words).replace("-", "−")


def rocking_map(scenario: Scenario) -> Iterator[Picture]:
    """The slowest sway-rocking mode over CG height and footprint, the machine marked.

    There is none for machines whose linear model has no closed form (`ehamj.designs.designs.Designs`).
    """
    height, across = scenario.machine.cg[2], float(np.ptp(np.array(scenario.plant.positions)[:, 1]))
    heights = xr.DataArray(np.linspace(*HEIGHTS, DESIGNS) * max(height, LEAST_HEIGHT), dims="height")
    widths = xr.DataArray(np.linspace(*WIDTHS, DESIGNS), dims="width")
    try:
        found = rocking_modes(scenario, heights, widths)
    except InputError:
        return
    slowest = slowest_rocking(found).transpose("height", "width").values
    if np.isnan(slowest).all():
        return
    figure = map_chart(
        "Slowest sway-rocking mode, valves held",
        ("distance of the mounts in y [m]", across * widths.values),
        ("CG height [m]", heights.values),
        ("slowest sway-rocking [Hz]", slowest),
        boundary=("tips over", -found["tipping_margin"].transpose("height", "width").values),
        points=[Line("this machine", [across], [height], color=1, marker="s")],
    )
    caption = "Mass and inertia about the CG kept, all mounts moved in proportion. ehamj study rocking has more."
    yield Picture("modes-map", figure, caption)
