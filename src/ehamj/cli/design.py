"""The command that designs a controller."""

from typing import Annotated

import typer
from rich.text import Text

from ehamj.cli.frame import Command, Json, Out, Overwrite, ScenarioName, Set, app
from ehamj.cli.printing import print_json, print_table, say
from ehamj.cli.progress import doing
from ehamj.design.kinds import DESIGNABLE
from ehamj.folders import check_out, new_folder

OCTAVES = ("1", "2", "4", "8", "16", "31.5", "63", "125", "250")
"""Bands that are printed [Hz]; all are on the page."""


@app.command(cls=Command)
def design(
    scenario: ScenarioName = "recorded",
    architecture: Annotated[
        str | None,
        typer.Option(help=f"{', '.join(DESIGNABLE)} [default: the scenario's own]."),
    ] = None,
    gain_margin: Annotated[
        float | None, typer.Option(help="Least gain margin [dB] [default: control.margins, or 6].")
    ] = None,
    phase_margin: Annotated[
        float | None, typer.Option(help="Least phase margin [deg] [default: control.margins, or 45].")
    ] = None,
    disk_margin: Annotated[
        float | None,
        typer.Option(help="Least disk margin, also of all valves at once [-] [default: control.margins, or 0.5]."),
    ] = None,
    out_folder: Out = None,
    overwrite: Overwrite = False,
    overrides: Set = None,
    as_json: Json = False,
) -> None:
    """Design a controller for a machine: crossings under stated margins, what they leave, and what limits them.

    The margins hold on the machine and on its variations: mass ±30 %, half the oil's stiffness, 1.5 times the flow
    gain. Writes design.html (read it first), controller.json (a scenario runs it with `control.kind = "law"`),
    scenario.toml (the machine under the designed control: `ehamj run FOLDER/scenario.toml`), tables and figures;
    Nichols plots with `--set output.nichols=true`.
    """
    from ehamj.design.command import DESIGN_FILES, design_controller, write_design
    from ehamj.design.outcome import left_out
    from ehamj.design.page import attenuations

    check_out(out_folder, overwrite, DESIGN_FILES)
    margins = (gain_margin, phase_margin, disk_margin)
    with doing("designing", steps=True) as progress:
        found = design_controller(scenario, overrides or (), architecture, *margins, progress=progress)
        progress("writing page and figures")
        with new_folder(out_folder, overwrite) as place:
            write_design(place.target, found)
    if as_json:
        print_json({"folder": str(place.folder), "answers": list(found.outcome.answers), **found.outcome.numbers})
        return
    no = Text("NO", "bold red")
    rows = [
        (name, *(f"{value:.{digits}f}" for value, digits in zip(report.worst, (1, 1, 2), strict=True)),
         "yes" if report.stable else no)
        for name, report in found.design.reports.items()
    ]  # fmt: skip
    if rows:
        print_table(found.outcome.title, ("machine", "gain [dB]", "phase [deg]", "disk [-]", "stable"), rows)
    shown = attenuations(found.limits, OCTAVES)
    if shown.rows:
        print_table(shown.title, shown.head, shown.rows)
    for note in left_out(found.design):
        say(f"note: {note}")
    for answer in found.outcome.answers:
        say(f"- {answer}")
    say(f"page, tables and figures: {place.folder / 'design.html'}", whole=True)
    say(f"run it: ehamj run {place.folder / 'scenario.toml'}", whole=True)
