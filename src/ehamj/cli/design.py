"""The command that designs a controller."""

from typing import Annotated

import typer
from rich.table import Table

from ehamj.cli.frame import (
    JsonOption,
    OutOption,
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
from ehamj.design.synthesis import SYNTHESES
from ehamj.design.tuning import DESIGNABLE


@app.command()
def design(
    scenario: ScenarioArgument = "recorded",
    architecture: Annotated[
        str | None,
        typer.Option(help=f"{', '.join((*DESIGNABLE, *SYNTHESES))} [default: the scenario's own]."),
    ] = None,
    gain_margin: Annotated[float, typer.Option(help="Least gain margin [dB].")] = 6.0,
    phase_margin: Annotated[float, typer.Option(help="Least phase margin [deg].")] = 45.0,
    disk_margin: Annotated[float, typer.Option(help="Least disk margin, also of all valves at once [-].")] = 0.5,
    out_folder: OutOption = None,
    overwrite: OverwriteOption = False,
    overrides: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Design a controller for a machine: crossings under stated margins, what they leave, and what limits them.

    The margins hold on the machine and on its variations: mass ±30 %, half the oil's stiffness, 1.5 times the flow
    gain. Writes design.html (read it first), controller.json (a scenario runs it with `control.kind = "law"`),
    scenario.toml (the machine under the designed control: `ehamj run FOLDER/scenario.toml`), tables and figures.
    """
    from ehamj.design.command import DESIGN_FILES, design_controller, write_design

    check_out(out_folder, overwrite, DESIGN_FILES)
    with log.status("designing"):
        found = design_controller(scenario, overrides or (), architecture, gain_margin, phase_margin, disk_margin)
        with new_folder(out_folder, overwrite) as (folder, target):
            write_design(target, found)
    if as_json:
        print_json({"folder": str(folder), "answers": list(found.outcome.answers), **found.outcome.numbers})
        return
    if found.design.reports:
        table = Table("machine", "gain [dB]", "phase [deg]", "disk [-]", "stable", title=found.outcome.title)
        for name, report in found.design.reports.items():
            gain, phase, disk = report.worst
            table.add_row(
                name, f"{gain:.1f}", f"{phase:.1f}", f"{disk:.2f}", "yes" if report.stable else "[bold red]NO[/]"
            )
        out.print(table)
    for answer in found.outcome.answers:
        out.print(f"- {answer}", markup=False, highlight=False, soft_wrap=True)
    out.print(f"page, tables and figures: {folder / 'design.html'}", markup=False, highlight=False, soft_wrap=True)
    out.print(f"run it: ehamj run {folder / 'scenario.toml'}", markup=False, highlight=False, soft_wrap=True)
