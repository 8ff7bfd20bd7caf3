"""Modes of the machine: with the valves held, in each closed loop, and over CG height and footprint."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from ehamj.evaluation import Evaluation
from ehamj.linear.modes import Mode
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import DASH, motion, number
from ehamj.plant.axes import DOFS
from ehamj.plots import Line, map_chart
from ehamj.report.shown import Shown

NOTABLE: Final = 0.05
"""Share of a shape's largest part below which a part is left out."""
IN_STEP: Final = 5.0
"""Phase below which parts of a shape count as in step, or against each other [deg]."""


def modes(shown: Shown) -> Section | None:
    """A table for each machine; those without a rest to linearise about (under a load that is held) have none."""
    machines: dict[int, dict[str, Evaluation]] = {}
    for label, one in shown.evaluations.items():
        if one.machine.model is not None:
            machines.setdefault(id(one.machine), {})[label] = one
    if not machines:
        return None
    tables = [
        _table("Modes of the machine" + (f", {next(iter(runs))}" if len(machines) > 1 else ""), runs)
        for runs in machines.values()
    ]
    return Section("modes", "Modes", list(_rocking_map(shown)), tables, tables_first=True)


def _table(title: str, runs: Mapping[str, Evaluation]) -> Table:
    """Natural frequency and damping of the modes in which the machine moves.

    Columns: with its valves held, and in the closed loop of each result whose law feeds back.
    """
    columns: dict[str, Sequence[Mode]] = {"valves held": next(iter(runs.values())).machine.modes}
    columns |= {label: one.modes for label, one in runs.items() if one.modes is not None}
    still = [label for label, one in runs.items() if one.law is not None and one.modes is None]
    notes = [
        "Natural frequency |λ|/2π and damping ratio −Re λ/|λ|; with valves held, the motion of the mount plane's "
        "centre (m, rad; largest one), and the axis about which it turns."
    ]
    if still:
        notes.append(f"{', '.join(still)}: the law reads the ground alone and moves no mode.")
    notes += [note for label, found in columns.items() if (note := _others(label, found))]
    by_name = {label: {mode.name: mode for mode in found if mode.machine_moves} for label, found in columns.items()}
    rows = []
    for name in dict.fromkeys(name for found in by_name.values() for name in found):
        cells = [cell for found in by_name.values() for cell in _cells(found.get(name))]
        mode = by_name["valves held"].get(name)
        last = [_moves(mode), str(mode.centre or "nothing: translates")] if mode else ["", ""]
        rows.append([name, *cells, *last])
    head = [f"{label}: {what}" if len(columns) > 1 else what for label in columns for what in ("f [Hz]", "ζ [-]")]
    return Table(title, ["mode", *head, "moves", "turns about"], rows, " ".join(notes), kind="words")


def _cells(mode: Mode | None) -> tuple[str, str]:
    """Frequency and damping ratio."""
    return (number(mode.frequency, 4), f"{mode.damping_ratio:.4f}".replace("-", "−")) if mode else (DASH, DASH)


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
    return motion(dict(zip(DOFS, mode.shape.tolist(), strict=True)), NOTABLE, ".2f", IN_STEP)


def _rocking_map(shown: Shown) -> Iterator[Picture]:
    """The slowest sway-rocking mode over CG height and footprint, the machine marked."""
    found = next(iter(shown.evaluations.values())).machine.rocking
    if found is None or found["slowest"].isnull().all():
        return
    height, across = shown.scenario.machine.cg[2], float(np.ptp(np.array(shown.scenario.plant.positions)[:, 1]))
    figure = map_chart(
        "Slowest sway-rocking mode, valves held",
        ("distance of the mounts in y [m]", across * found["width"].values),
        ("CG height [m]", found["height"].values),
        ("slowest sway-rocking [Hz]", found["slowest"].values),
        boundary=("tips over", -found["tipping_margin"].values),
        points=[Line("this machine", [across], [height], color=1, marker="s")],
        blank="a mode creeps: no frequency",
    )
    caption = "Mass and inertia about the CG kept, all mounts moved in proportion. ehamj study rocking has more."
    yield Picture("modes-map", figure, caption)
