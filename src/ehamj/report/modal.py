"""Tables of modes: with the valves held, and under each controller that feeds back."""

import cmath
import math
from collections.abc import Iterator, Sequence
from typing import Final

from ehamj.analysis.modes import Mode, modes
from ehamj.errors import InputError
from ehamj.layout import DOFS
from ehamj.linear.machine import linear_model
from ehamj.report.parts import Results, Table
from ehamj.report.words import number

NOTABLE: Final = 0.05
"""Share of a shape's largest part below which a part is left out."""
IN_STEP: Final = 5.0
"""Phase below which parts of a shape count as in step, or against each other [deg]."""


def modal_tables(results: Results) -> Iterator[Table]:
    """Modes of each machine among the results with its valves held, and in each closed loop.

    A law that reads the ground alone moves no mode, and has no table.
    """
    seen: list[object] = []
    for label, result in results.items():
        whose = f", {label}" if len(results) > 1 else ""
        try:
            model = linear_model(result.scenario)
            if result.scenario.plant not in seen:
                yield _table(f"Modes, valves held{whose if seen else ''}", modes(model))
                seen.append(result.scenario.plant)
            law = result.controller
            if law is not None and not all(name.startswith("ground_") for name in law.inputs):
                yield _table(
                    f"Modes, closed loop{whose}",
                    modes(model, law, sensors=result.scenario.sensors, seed=result.scenario.seed),
                )
        except InputError:
            continue  # no operating point at rest, such as under a held load: there are no modes to show


def _table(title: str, found: Sequence[Mode]) -> Table:
    rows = [[mode.name, number(mode.frequency, 4), f"{mode.damping_ratio:.4f}", _moves(mode)] for mode in found]
    note = "Natural frequency |λ|/2π and damping ratio −Re λ/|λ|; motion of the mount plane's centre, m and rad."
    return Table(title, ["mode", "f [Hz]", "ζ [-]", "moves"], rows, note, kind="words")


def _moves(mode: Mode) -> str:
    """The shape's parts, largest one; phases where they are not in step."""
    if any(mode.name.startswith(what) for what in ("valve", "controller")):
        return "the machine hardly"
    largest = max(map(abs, mode.shape))
    words = []
    for dof, part in zip(DOFS, mode.shape.tolist(), strict=True):
        if abs(part) > NOTABLE * largest:
            size, angle = abs(part) / largest, math.degrees(cmath.phase(part))
            if abs(angle) > 180.0 - IN_STEP:
                size, angle = -size, 0.0
            words.append(f"{dof} {size:.2f}" + (f"∠{angle:.0f}°" if abs(angle) > IN_STEP else ""))
    return ", ".join(words).replace("-", "−")
