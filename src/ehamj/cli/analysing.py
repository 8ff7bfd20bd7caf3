"""Commands that analyse a machine: its modes, the paper's actuator."""

import cmath
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from ehamj.cli.frame import (
    JsonOption,
    OverwriteOption,
    ScenarioArgument,
    SetOption,
    app,
    check_out,
    log,
    new_folder,
    out,
    print_json,
)
from ehamj.layout import DOFS

if TYPE_CHECKING:
    from ehamj.analysis.modes import Mode


@app.command()
def modes(scenario: ScenarioArgument = "recorded", overrides: SetOption = None, as_json: JsonOption = False) -> None:
    """Natural frequencies, damping and shapes of the machine: passive, and under the scenario's digital controller.

    Frequencies are |λ|/2π, damping ratios −Re λ/|λ|; shapes are the motion of the mount plane's centre, its largest
    part one. A feedforward does not move modes, so its closed loop adds only the controller's own.
    """
    from ehamj.analysis.linear import linear_model
    from ehamj.analysis.modes import modes as find
    from ehamj.scenario import load_scenario

    loaded = load_scenario(scenario, overrides or ())
    model, controller = linear_model(loaded), loaded.controller()
    found = {"modes": find(model)}
    if controller is not None:
        found["closed_loop"] = find(model, controller)
    if as_json:
        print_json({key: [mode.to_dict() for mode in modes] for key, modes in found.items()})
        return
    for key, title in (("modes", "valves held"), ("closed_loop", "closed loop")):
        if key in found:
            out.print(_mode_table(found[key], f"{loaded.name}: {title}"))


def _mode_table(modes: "Sequence[Mode]", title: str) -> Table:
    """Modes with their shapes in words: the parts above 1 %, and their phases where they are not in step."""
    table = Table("mode", "f [Hz]", "ζ [-]", "shape (m and rad, largest part 1)", title=title)
    for mode in modes:
        parts = [(dof, abs(part), math.degrees(cmath.phase(part))) for dof, part in zip(DOFS, mode.shape, strict=True)]
        words = [
            f"{dof} {size:.2f}" + (f"∠{angle:.0f}°" if abs(angle) > 1 else "")
            for dof, size, angle in parts
            if size > 0.01
        ]
        moved = mode.name not in ("valve", "controller")
        table.add_row(
            mode.name, f"{mode.frequency:.2f}", f"{mode.damping_ratio:.4f}", ", ".join(words) if moved else ""
        )
    return table


@app.command()
def paper(
    out_folder: Annotated[Path | None, typer.Option("--out", help="Folder [default: a new runs/NNNN].")] = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Reproduce the source paper: figures 3 to 7, and every number it states beside the computed one.

    Beyond the paper, amplitude.svg shows how its actuator answers commands of ±1 to ±90 % in the nonlinear simulation.
    """
    from ehamj.scenario import load_scenario
    from ehamj.studies.amplitude import AmplitudeStudy, amplitude_response, write_amplitude
    from ehamj.studies.paper import reproduce, write_paper

    check_out(out_folder, overwrite, ("paper.json", "table.csv"))
    found = reproduce()
    with new_folder(out_folder, overwrite) as (folder, target), log.status("drawing"):
        write_paper(target)
        write_amplitude(target, amplitude_response(AmplitudeStudy(load_scenario("single-actuator"))))
    if as_json:
        print_json({"folder": str(folder), **found.to_dict()})
        return
    table = Table("number", "paper", "computed", "deviation", "comment", title="the paper, number by number")
    for row in found.table:
        table.add_row(row.name, row.stated, row.computed, row.deviation, row.comment)
    out.print(table)
    out.print(f"figures, table and record: {folder}", highlight=False, soft_wrap=True)
